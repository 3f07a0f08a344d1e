"""Energy of cracks in the 90-degree plies of a cross-ply laminate [0/90]s, by the principle of minimum complementary energy (Hashin 1985; Nairn 1989).

Plane stress in the plane of load x and thickness z, from the middle z = 0 to the surface. In each layer of a ply group the axial stress is that of the
laminate without cracks and a function of x alone; shear and transverse stress follow from equilibrium, with tau' the derivative along x:

    sum of t phi = 0,   tau(z) = -int_0^z phi' dz,   sigma_z(z) = int_z^h tau' dz.

One layer in each group is the solution of Hashin and Nairn. More layers come from above to that of elasticity. The functions are sums of exp(+-s x), whose s
are found as eigenvalues; conditions: no axial and no shear stress on a crack, the same axial displacement of all other layers there.
"""

import numpy as np
from scipy.linalg import eig
from scipy.optimize import brentq

# Constants as of a carbon/epoxy and a glass/epoxy [Pa, 1/K, K]; they are input of both, the theory and the program
CARBON = {"EA": 128e9, "ET": 7.2e9, "nuA": 0.3, "nuT": 0.5, "GA": 4.0e9, "GT": 2.4e9, "aA": -0.09e-6, "aT": 28.8e-6, "dT": -125.0}
GLASS = {"EA": 41.7e9, "ET": 13e9, "nuA": 0.3, "nuT": 0.42, "GA": 3.4e9, "GT": 4.58e9, "aA": 8.6e-6, "aT": 22.1e-6, "dT": -80.0}


class Laminate:
    """Half of a laminate: t90 of 90-degree plies (half of their thickness), t0 of 0-degree plies above; `layers` in each of both."""

    def __init__(self, of, t90, t0, layers=12, heat=1.0):
        self.of, self.t90, self.t0, self.layers = of, t90, t0, layers
        parts = 1.6**np.arange(layers)
        parts /= parts.sum()
        self.h = t90 + t0
        self.t = np.concatenate([t90 * parts[::-1], t0 * parts]) / self.h
        self.matrices = self._matrices()
        self.stiffness = of["ET"] * t90 + of["EA"] * t0                    # over the width, of half of the laminate
        strains = of["aT"] * of["dT"] * heat, of["aA"] * of["dT"] * heat   # along x, of 90 and 0 degrees
        self.expansion = (of["ET"] * t90 * strains[0] + of["EA"] * t0 * strains[1]) / self.stiffness
        self.share, self.residual = of["ET"] / self.stiffness, of["ET"] * (self.expansion - strains[0])  # stress in 90 degrees: share P + residual
        self._known = {}

    def _matrices(self):
        """Of the quadratic form phi A phi + 2 phi B phi'' + phi' C phi' + phi'' D phi'' of the energy, in 1/(10 GPa) and with h = 1."""
        t, n, of = self.t, len(self.t), self.of
        free = np.vstack([np.eye(n - 1), -t[:-1] / t[-1]])
        a, b, c, d = (np.zeros((n, n)) for _ in range(4))
        top = np.zeros(n)
        for k in reversed(range(n)):
            e_x, nu, g = (of["ET"], of["nuT"], of["GT"]) if k < n // 2 else (of["EA"], of["nuA"], of["GA"])
            below = np.where(np.arange(n) < k, t, 0.0)
            for x, w in zip(*np.polynomial.legendre.leggauss(3)):
                s, w = (x + 1) / 2 * t[k], w / 2 * t[k] * 1e10
                one = np.eye(n)[k]
                tau, across = -below - s * one, top - below * (t[k] - s) - (t[k]**2 - s**2) / 2 * one
                a += w / e_x * np.outer(one, one)
                b -= w * nu / e_x * np.outer(one, across)
                c += w / g * np.outer(tau, tau)
                d += w / of["ET"] * np.outer(across, across)
            top = top - below * t[k] - t[k]**2 / 2 * np.eye(n)[k]
        return [free.T @ m @ free for m in (a, b, c, d)]

    def energy(self, length):
        """Energy that both cracks at the ends of a length add, over the width and the square of the stress that they free [m2/Pa], of half of the laminate."""
        if length in self._known:
            return self._known[length]
        (a, b, c, d), cracked = self.matrices, self.layers
        n = len(a)
        one, none = np.eye(n), np.zeros((n, n))
        values, vectors = eig(np.block([[none, one], [-a, -(b + b.T - c)]]), np.block([[one, none], [none, d]]))
        s, v, half = np.sqrt(values.astype(complex)), vectors[:n], length / 2 / self.h
        s = np.where(s.real < 0, -s, s)
        even, odd = 1 + np.exp(-2 * s * half), 1 - np.exp(-2 * s * half)
        phi, slope = v * even, v * s * odd
        opening = (c - b.T) @ slope - d @ (v * s**3 * odd)
        rows = np.vstack([slope, phi[:cracked], opening[cracked:]])
        right = np.zeros(2 * n, complex)
        right[n:n + cracked] = -1
        scale = np.abs(rows).max(axis=0)
        x = np.linalg.solve(rows / scale, right) / scale
        self._known[length] = 1e-10 * self.h**2 * ((phi @ x) * (opening @ x)).sum().real
        return self._known[length]

    def state(self, lengths, u):
        """Energy and load over the width, of half of the laminate, with cracks at the ends of lengths, whose ends are moved by u altogether."""
        whole, added = sum(lengths), sum(map(self.energy, lengths))
        load = (u - self.expansion * whole - 2 * added * self.share * self.residual) / (whole / self.stiffness + 2 * added * self.share**2)
        stress = self.share * load + self.residual
        return -load**2 * whole / (2 * self.stiffness) - self.expansion * whole * load - added * stress**2 + load * u, load

    def onset(self, before, after, toughness):
        """Displacement at which `after` has released its toughness for one more crack than `before`, by given grips, and the load before."""
        def missing(u):
            return self.state(before, u)[0] - self.state(after, u)[0] - toughness * self.t90
        u = brentq(missing, max(0.0, -self.residual / self.of["ET"]) * sum(before), 0.2 * sum(before))
        return u, self.state(before, u)[1]

    def nairn(self, density):
        """Energy of the next crack at a crack density, for a stress of 1 Pa in the plies and under given load: C3 t90 (2 chi(rho/2) - chi(rho)) [J/m2]."""
        rho, (c1, c2, c3, c4) = 1 / (2 * density * self.t90), self.constants()
        p, q = (c2 - c4) / c3, c1 / c3
        al, be = 0.5 * np.sqrt(2 * np.sqrt(q) - p), 0.5 * np.sqrt(2 * np.sqrt(q) + p)

        def chi(x):
            return 2 * al * be * (al**2 + be**2) * (np.cosh(2 * al * x) - np.cos(2 * be * x)) / (be * np.sinh(2 * al * x) + al * np.sin(2 * be * x))
        return c3 * self.t90 * (2 * chi(rho / 2) - chi(rho))

    def constants(self):
        """C1 to C4 of Nairn (1989)."""
        of, r = self.of, self.t0 / self.t90
        return (1 / of["ET"] + 1 / (r * of["EA"]), of["nuT"] / of["ET"] * (r + 2 / 3) - of["nuA"] * r / (3 * of["EA"]),
                (r + 1) / (60 * of["ET"]) * (3 * r**2 + 12 * r + 8), (1 / of["GT"] + r / of["GA"]) / 3)
