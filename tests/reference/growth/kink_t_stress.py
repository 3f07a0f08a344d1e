"""K of a short straight kink at a long crack under a T-stress alone, over T times the root of the length of the kink: an integral equation, apart from hampm.

    python tests/reference/growth/kink_t_stress.py > tests/reference/growth/kink_t_stress.csv

Displacement discontinuities, constant over elements whose ends are Chebyshev points of each straight part (stress of edge dislocations by Muskhelishvili's potentials), with
parts that become shorter towards the kink; the crack is 20 000 times as long as the kink. K is the limit of the opening over the root of the distance from the tip, over that
of a straight crack with as many elements. The last column extrapolates from 32 and 64 elements a part, as errors fall with the square. The same functions by the
series of Amestoy & Leblond, Int. J. Solids Struct. 29 (1992) 465, differ by 3e-4 at most.
"""

import numpy as np


def stress(points, elements):
    """Middles of the elements, unit vectors along them, and the tractions there by their jumps."""
    x = -np.cos(np.arange(elements + 1) * np.pi / elements)
    c = -np.cos((np.arange(elements) + 0.5) * np.pi / elements)
    parts = list(zip(points[:-1], points[1:]))
    first, last, middle = (np.concatenate([a + (b - a) * (y + 1) / 2 for a, b in parts]) for y in (x[:-1], x[1:], c))
    along = np.concatenate([np.full(elements, (b - a) / abs(b - a)) for a, b in parts])
    z, blocks = middle[:, None], []
    for unit in (1, 1j):
        phi = slope = psi = 0
        for end, sign in ((first[None, :], 1), (last[None, :], -1)):
            g, d = sign * unit / (np.pi * 1j), z - end
            phi, slope = phi + g / d, slope - g / d**2
            psi = psi + np.conj(g) / d + g * np.conj(end) / d**2
        blocks.append(phi + np.conj(phi) + (np.conj(z) * slope + psi) * (along**2)[:, None])
    return middle, along, np.block([[block.real for block in blocks], [block.imag for block in blocks]])


def tip(points, elements, of_axes):
    """Opening and sliding over the root of the distance to the last point, under stresses xx, yy and xy."""
    points = np.asarray(points, complex)
    middle, along, matrix = stress(points, elements)
    xx, yy, xy = of_axes
    load = (xx + yy + (yy - xx + 2j * xy) * along**2) / 2
    jump = np.linalg.solve(matrix, -np.concatenate([load.real, load.imag]))
    jump = (jump[:len(middle)] + 1j * jump[len(middle):]) / along
    r = abs(middle[-6:] - points[-1])
    return np.polyfit(r, jump[-6:] / np.sqrt(r), 2)[-1]


def kink(angle, elements, length=1e-4):
    """K_I and K_II of a kink."""
    points = [-1, 0, 0.9, 0.99, 0.999, 1 - length, 1, 1 + length * np.exp(1j * np.radians(angle))]
    k = tip(points, elements, (1 / np.sqrt(length), 0, 0)) / (tip([-1, 1], elements, (0, 1, 0)) / (1j * np.sqrt(np.pi)))
    return np.array([k.imag, k.real])


if __name__ == "__main__":
    print("# " + __doc__.split("\n\n")[0].replace("\n", " "))
    print("angle [deg],K_I,K_II")
    for angle in (15, 30, 45, 60, 75, 90):
        coarse, fine = kink(angle, 32), kink(angle, 64)
        print(f"{angle},{','.join(f'{x:.5f}' for x in fine + (fine - coarse) / 3)}")
