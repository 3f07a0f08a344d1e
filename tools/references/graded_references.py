"""Stress intensity factors of a crack along the gradient of an infinite plate with E = E_0 exp(beta x), by an integral equation of its own.

With Airy's function F the strain is compatible where, in plane stress,

    lap(lap F) - 2 beta (lap F),x + beta^2 (F,xx - nu F,yy) = 0.

Its parts exp(i xi x + m y) have (m^2 - xi^2 - i beta xi)^2 = nu beta^2 m^2, two of them with Re m < 0 for y > 0. On the line of the crack the
shear is 0, and of each xi the stress across it is S(xi) times W = E v, v being half of the opening. W is a sum of
sqrt(a^2 - x^2) U_n(x/a), whose transforms are Bessel functions, and the stress on the faces is that of the plate without a crack with its sign
turned around, in the mean with each function (Galerkin). K is what W has at the ends: W = 4 K sqrt(r/(2 pi)).

In plane strain nu/(1 - nu) is in the place of nu. Delale & Erdogan (1983) and Konda & Erdogan (1994) solve the same problem by a dislocation
density.

    .venv/bin/python tools/references/graded_references.py
"""

import numpy as np


def bessel(orders, x, points=300):
    """J_n(x) by Bessel's integral, which the rule of trapezoids makes exact."""
    t = (np.arange(points) + 0.5) * np.pi / points
    return np.array([np.mean(np.cos(n * t[:, None] - np.sin(t)[:, None] * x), axis=0) for n in orders])


def transfer(xi, beta, nu):
    """S(xi)."""
    roots = []
    for sign in (1, -1):
        b = sign * beta * np.sqrt(nu)          # m^2 - b m - xi^2 - i beta xi = 0
        root = np.sqrt(b**2 / 4 + xi**2 + 1j * beta * xi)
        roots.append(b / 2 - root)
    m1, m2 = roots
    part = lambda m: (-xi**2 - nu * m**2) / m
    return -xi**2 * (1 - m1 / m2) / (part(m1) - m1 / m2 * part(m2))


def intensities(beta, nu=0.3, terms=10, stress=np.exp, far=200.0, points=8001):
    """K over sqrt(pi a) at x = a and x = -a, a = 1, for the stress stress(beta x) of the plate without a crack."""
    n = np.arange(terms)
    xi = np.linspace(0, far, points)[1:] - far / (points - 1) / 2
    step = xi[1] - xi[0]
    phi = np.pi * ((-1j) ** n)[:, None] * (n + 1)[:, None] * bessel(n + 1, xi) / xi
    rest = transfer(xi, beta, nu) + xi / 2  # what is left beside the uniform plate
    matrix = np.real(np.conj(phi) @ (phi * rest).T) * step / np.pi
    matrix -= np.diag(np.pi * (n + 1) * np.pi / (4 * np.pi))
    t = (np.arange(400) + 0.5) * np.pi / 400  # x = cos t: sqrt(1 - x^2) U_n dx = sin((n + 1) t) sin t dt
    right = -np.array([np.sum(stress(beta * np.cos(t)) * np.sin((k + 1) * t) * np.sin(t)) * np.pi / 400 for k in n])
    c = np.linalg.solve(matrix, right)
    # sqrt(1 - x^2) U_n(1) = sqrt(2 r) (n + 1), and W = 4 K sqrt(r/(2 pi))
    k = [np.sqrt(2) * np.sum(c * (n + 1)) * np.sqrt(2 * np.pi) / 4, np.sqrt(2) * np.sum(c * (n + 1) * (-1.0) ** n) * np.sqrt(2 * np.pi) / 4]
    return np.array(k) / np.sqrt(np.pi)


if __name__ == "__main__":
    print("beta a,K_right,K_left")
    for beta in (0.25, 0.5, 1.0):
        print(f"{beta},{intensities(beta)[0]:.4f},{intensities(beta)[1]:.4f}")
