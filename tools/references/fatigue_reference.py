#!/usr/bin/env python3
"""References for growth by fatigue: K of a crack anywhere across a rectangular plate in tension, and the cycles of its growth.

    .venv/bin/python tools/references/fatigue_reference.py tests/reference/growth

K by boundary collocation with the functions of Muskhelishvili. With Phi + Omega = P(z)/sqrt(z**2 - a**2) and Phi - Omega = Q(z) the faces of the crack are
without tractions for any real polynomials P and Q. The tractions on the edges give these (least squares), and displacements have one value where the mean
of P over the crack, with the weight 1/sqrt(a**2 - x**2), is 0. For a crack in the middle Tada, Paris & Irwin (2000), p. 2.2, is within 0.1 %.

Cycles by the rule of the middle (Runge & Kutta, second order) in 2000 steps and more: no step is longer than 10 um.
"""

import sys
from pathlib import Path

import numpy as np

CONSTANT, EXPONENT, STRESS = 1e-29, 3.0, 100e6  # of the scenes input/fatigue_*.nml


def intensity(a, left, right, half_height, n=48, m=240):
    """K at the left and at the right tip over the stress [sqrt(m)], of a crack from -a to a with edges at -left, right and +-half_height."""
    t = (1 - np.cos(np.pi * (np.arange(m) + 0.5) / m)) / 2
    z = np.concatenate([right + 1j * half_height * t, -left + 1j * half_height * t, -left + (left + right) * t + 1j * half_height])
    middle, span = (right - left) / 2, max((left + right) / 2, half_height)

    def powers(z):
        value, slope = np.ones((n, len(z)), complex), np.zeros((n, len(z)), complex)
        for k in range(1, n):
            value[k], slope[k] = value[k - 1] * (z - middle) / span, k * value[k - 1] / span
        return value, slope

    value, slope = powers(z)
    root = np.sqrt(z - a) * np.sqrt(z + a)
    phi = np.concatenate([value / root, value]) / 2
    slope = np.concatenate([slope / root - value * z / root**3, slope]) / 2
    omega = np.concatenate([np.conj(value / root), -np.conj(value)]) / 2  # at the conjugate place
    f = phi + omega + (z - np.conj(z)) * np.conj(slope)  # s_yy - i s_xy
    sides, end = slice(0, 2 * m), slice(2 * m, 3 * m)
    rows = np.concatenate([(4 * phi.real - f.real)[:, sides], -f.imag[:, sides], f.real[:, end], -f.imag[:, end]], axis=1).T
    asked = np.concatenate([np.zeros(4 * m), np.ones(m), np.zeros(m)])
    around = np.concatenate([powers(a * np.cos(np.pi * (np.arange(400) + 0.5) / 400) + 0j)[0].real.mean(axis=1), np.zeros(n)])
    scale = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    x = np.linalg.lstsq(np.vstack([rows / scale, 1e4 * around / scale]), np.append(asked, 0), rcond=1e-14)[0] / scale
    p = [x[:n] @ powers(np.array([end + 0j]))[0][:, 0].real for end in (-a, a)]
    return np.array([-p[0], p[1]]) * np.sqrt(np.pi / a)


def tada(a, width):
    """K over stress of a crack of 2a in the middle of a strip of 2 width [sqrt(m)]: within 0.1 %."""
    part = a / width
    return (1 - 0.025 * part**2 + 0.06 * part**4) * np.sqrt(np.pi * a / np.cos(np.pi * part / 2))


def centre(folder):
    lines = ["# A crack of 2a in the middle of a plate of 100 by 200 mm: K over stress by collocation (tools/references/fatigue_reference.py) and by Tada, Paris & Irwin.",
             "a[mm],K[sqrt(m)],K by Tada[sqrt(m)]"]
    for a in np.arange(10, 31, 1.0) * 1e-3:
        lines.append(f"{1e3 * a:g},{intensity(a, 0.05, 0.05, 0.1)[1]:.6g},{tada(a, 0.05):.6g}")
    (folder / "g1_fatigue_centre_crack.csv").write_text("\n".join(lines) + "\n")


def eccentric(folder):
    """A crack from -10 to 10 mm with edges at -40 and 60 mm, by Paris' law; K on a mesh of places of both tips, cubic in between."""
    lefts, rights = np.linspace(10, 29, 12) * 1e-3, np.linspace(10, 24, 9) * 1e-3
    table = np.array([[intensity((x + y) / 2, 0.04 + (y - x) / 2, 0.06 - (y - x) / 2, 0.1) for y in rights] for x in lefts])

    def basis(nodes, at):
        return np.array([np.prod([(at - nodes[j]) / (nodes[i] - nodes[j]) for j in range(len(nodes)) if j != i]) for i in range(len(nodes))])

    def rate(place):
        return CONSTANT * (STRESS * np.einsum("i,j,ijk->k", basis(lefts, place[0]), basis(rights, place[1]), table)) ** EXPONENT

    place, cycles, marks = np.array([0.01, 0.01]), 0.0, list(np.arange(10, 28.5, 1.0) * 1e-3)
    lines = ["# A crack from -10 to 10 mm, edges at -40 and 60 mm, ends at +-100 mm, 0 to 100 MPa, da/dN = 1e-29 m (dK/Pa sqrt(m))**3: tools/references/fatigue_reference.py.",
             "cycles,left tip[mm],right tip[mm],K left[MPa sqrt(m)],K right[MPa sqrt(m)]"]
    while marks:
        now = rate(place)
        if place[0] >= marks[0] - 1e-12:
            k = (now / CONSTANT) ** (1 / EXPONENT) / 1e6
            lines.append(f"{cycles:.2f},{-1e3 * place[0]:.5f},{1e3 * place[1]:.5f},{k[0]:.5f},{k[1]:.5f}")
            marks.pop(0)
            continue
        step = min(1e-5, marks[0] - place[0]) / now[0]
        middle = rate(place + step / 2 * now)
        step = min(step, (marks[0] - place[0]) / middle[0])
        place, cycles = place + step * middle, cycles + step
    (folder / "g2_fatigue_eccentric_crack.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    centre(folder)
    eccentric(folder)
