"""T-stresses of specimens at rest, by boundary collocation, and of a half-plane crack under a step wave, in closed form.

    tools/references/t_stress_references.py [TERMS]

Prints the rows of tests/reference/t_stress.csv. At rest the stress function of a crack along the negative x axis with free faces is (Williams 1957)

    s_yy - i s_xy = Z1 + Z2 + conj(Z1 - Z2) + (z - conj(z)) conj(Z1' + Z2'),   s_xx + s_yy = 4 Re(Z1 + Z2),   Z1 = P(z)/sqrt(z),   Z2 = Q(z),

with polynomials P and Q of real coefficients in mode I, so that K_I = 2 sqrt(2 pi) P(0) and T = 4 Q(0). The polynomials are orthogonal on the boundary
(Brubeck, Nakatsukasa & Trefethen 2021), their coefficients those that meet the tractions there by least squares.

Under a wave s_yy = s0 of normal incidence the transform of s_yy on the line of the crack is s0 F(0)/(s**2 zeta F(zeta)), F = sqrt(a + zeta)/((c + zeta) S(zeta)) with
Freund's S (1990, section 2.5); the strain along the faces follows from it, as a pole and a cut along the slownesses of both waves, and is the same at all times at the tip.
"""

import sys

import numpy as np


def orthogonal(z, terms):
    """Polynomials with real coefficients, orthogonal on the points z, and their derivatives there and, in the last row, at 0."""
    at = np.append(z, 0)
    q, d = np.zeros((2, at.size, terms), complex)
    q[:, 0] = 1
    for k in range(1, terms):
        v, dv = at * q[:, k - 1], q[:, k - 1] + at * d[:, k - 1]
        for _ in "ab":
            part = np.real(q[:-1, :k].conj().T @ v[:-1]) / z.size
            v, dv = v - q[:, :k] @ part, dv - d[:, :k] @ part
        size = np.linalg.norm(v[:-1]) / np.sqrt(z.size)
        q[:, k], d[:, k] = v / size, dv / size
    return q, d


def collocate(edges, terms):
    """K_I and T of a body above the line y = 0, whose edges are (from, to, what, its value, s_xy as functions of x, y) with what = 's_xx', 's_yy' or 'mirror'."""
    part = (1 - np.cos(np.pi * (np.arange(6 * terms) + 0.5) / (6 * terms))) / 2
    points = [complex(*edge[0]) + part * (complex(*edge[1]) - complex(*edge[0])) for edge in edges]
    z = np.concatenate(points)
    q, d = orthogonal(z, terms)
    root = z[:, None]**-0.5
    first, slope = root * q[:-1], root * (d[:-1] - 0.5 * q[:-1] / z[:, None])
    both, slopes, turned = np.hstack([first, q[:-1]]), np.hstack([slope, d[:-1]]), np.hstack([first.conj(), -q[:-1].conj()])
    across = (z - z.conj())[:, None] * slopes.conj()
    stress = both + turned + across
    values = {"s_yy": stress.real, "s_xx": 4 * both.real - stress.real,
              "mirror": (1j * (2 * both + turned - 2 * both.conj() + across)).real}  # u_x,y: 0 on a plane of symmetry, whatever Poisson's ratio
    rows, right = [], []
    for number, (_, _, what, value, shear) in enumerate(edges):
        here = slice(number * part.size, (number + 1) * part.size)
        rows += [values[what][here], -stress.imag[here]]
        right += [np.broadcast_to(given(z.real[here], z.imag[here]), part.shape) for given in (value, shear)]
    matrix = np.vstack(rows)
    size = np.linalg.norm(matrix, axis=0)
    found = np.linalg.lstsq(matrix / size, np.concatenate(right), rcond=1e-14)[0] / size
    return 2 * np.sqrt(2 * np.pi) * q[-1].real @ found[:terms], 4 * q[-1].real @ found[terms:]


def specimen(crack, width, height, top, left, right, shear=lambda x, y: 0.0):
    """Edges of a plate from x = -crack on, half of whose height is above the crack; `left` and `right` are 's_xx' where free and 'mirror' in the middle of a body."""
    def free(x, y):
        return 0.0
    x0, x1 = -crack, width - crack
    return [((x0, height), (x1, height), "s_yy", top, free), ((x0, 0), (x0, height), left, free, shear), ((x1, 0), (x1, height), right, free, free)]


def one(x, y):
    """Tension."""
    return 1.0


SPECIMENS = {
    "edge crack in tension": specimen(0.5, 1.0, 1.5, one, "s_xx", "s_xx"),
    "edge crack in bending": specimen(0.5, 1.0, 1.5, lambda x, y: 1 - 2 * (x + 0.5), "s_xx", "s_xx"),
    "two edge cracks in tension": specimen(0.5, 1.0, 1.5, one, "s_xx", "mirror"),
    "centre crack in tension": specimen(0.4, 1.0, 3.0, one, "mirror", "s_xx"),
    "double cantilever by end shear": specimen(3.0, 5.0, 1.0, lambda x, y: 0.0, "s_xx", "s_xx", lambda x, y: -6 * y * (1 - y)),
}


def step_wave(poisson):
    """T over s0 of a half-plane crack in plane strain under a step wave; the slowness of shear waves is 1."""
    a, b = np.sqrt((1 - 2 * poisson) / (2 * (1 - poisson))), 1.0
    nodes, weights = np.polynomial.legendre.leggauss(400)
    angle = np.pi * (nodes + 1) / 2                 # slownesses between both waves, close at the ends
    eta, weights = (a + b) / 2 - (b - a) / 2 * np.cos(angle), weights * np.pi / 2 * (b - a) / 2 * np.sin(angle)
    phase = np.arctan(4 * eta**2 * np.sqrt((eta**2 - a**2) * (b**2 - eta**2)) / (b**2 - 2 * eta**2)**2)

    def rayleigh(zeta, product):
        return 4 * zeta**2 * product + (b**2 - 2 * zeta**2)**2

    def beyond(zeta):
        return -np.sqrt(zeta**2 - a**2) * np.sqrt(zeta**2 - b**2)

    low, high = b, 3 * b
    for _ in range(200):
        c = (low + high) / 2
        low, high = (c, high) if rayleigh(c, beyond(c)) > 0 else (low, c)

    def s_plus(zeta):
        return np.exp(-np.sum(weights * phase / (eta + np.asarray(zeta)[..., None]), axis=-1) / np.pi)

    def strain(zeta, product):
        return zeta * (b**2 - 2 * zeta**2 - 2 * product) * (c + zeta) * s_plus(zeta) / np.sqrt(a + zeta)

    step = 1e-6
    slope = (rayleigh(c + step, beyond(c + step)) - rayleigh(c - step, beyond(c - step))) / (2 * step)
    on_cut = -1j * np.sqrt(eta**2 - a**2) * np.sqrt(b**2 - eta**2)
    total = -strain(c, beyond(c)) / slope + np.sum(weights * (strain(eta, on_cut) / rayleigh(eta, on_cut)).imag) / np.pi
    return 2 / (1 - poisson) * np.sqrt(a) / (c * s_plus(0.0)) * total


if __name__ == "__main__":
    for name, edges in SPECIMENS.items():
        print(f"{name},{','.join(format(value, '.6g') for value in collocate(edges, int(sys.argv[1]) if sys.argv[1:] else 200))}")
    for ratio in (0.0, 0.2, 0.3, 0.4):
        print(f"step wave {ratio},,{step_wave(ratio):.6g}")
