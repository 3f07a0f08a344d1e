"""Reference K_I(t) of two dynamic crack problems, by plain finite elements.

It shares nothing with hampm: bilinear elements (2 x 2 Gauss points) on a uniform square mesh, a lumped mass,
explicit central differences, no damping, float64, and numpy alone.

chen    A bar, 20 mm wide and 40 mm long, with a central crack of 4.8 mm across it, is pulled at both ends by
        a step of 1 MPa at t = 0 (plane strain, E = 199.992 GPa, nu = 0.3, rho = 5000 kg/m3).  A quarter is
        modelled.  K_I is signed: the crack may close on itself and interpenetrate (linear).
freund  A semi-infinite crack is met by a plane step wave of sigma0.  Exact until the first reflection:
        K_I = 2 sigma0 / (1 - nu) sqrt(c_d t (1 - 2 nu) / pi), t since the arrival.  The upper half of a plate
        (-H..H) x (0..H) is modelled, between rollers and with sigma0 / 2 on y = H: by symmetry two waves meet
        at the crack plane.

K_I is found from the interaction integral over a domain, with the inertia term

    K = E' int [ (s_ij a_i,1 + sa_ij u_i,1 - sa_kl e_kl d_1j) q_,j + rho u''_i a_i,1 q ] dA

(half a domain; a, sa: displacement and stress of the static mode I field with K = 1), over three domains.  It
is linear in u and u'', so its nodal weights are computed once.  Two other methods check it: the dynamic J
(K = sqrt(E' J)) and the opening of the crack behind the tip.

The tip makes the error of first order in the mesh size h, so the reference is extrapolated from the two finest
meshes, 2 h and h, as 2 K(h) - K(2 h); the coarser meshes tell how far to trust it.  At the wave fronts K_I is
not smooth: over 0.2 us it is known far better than at once, where it is that of the finest mesh, corrected by
the difference that the extrapolation makes over 0.2 us.
"""

import argparse
import time

import numpy as np

E, NU, RHO = 199.992e9, 0.3, 5000.0
MU, LAM = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
E_STRAIN = E / (1 - NU**2)  # E'
C_D = np.sqrt((LAM + 2 * MU) / RHO)
D = np.array([[LAM + 2 * MU, LAM, 0], [LAM, LAM + 2 * MU, 0], [0, 0, MU]])
SIGMA0 = 1e6
MM, US = 1e-3, 1e-6
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))
DOMAINS = ((0.4, 0.8), (0.8, 1.6), (1.2, 2.0))  # mm: q = 1 up to the first, 0 from the second
MAIN = 1  # the domain of the reference
COURANT = 0.98  # of c_d; stable up to 0.991.  Near 1, plane waves hardly disperse
A, B, L = 2.4, 10.0, 20.0  # mm: half the crack, half the width, half the length of Chen's bar
H = 10.0  # mm: size of Freund's plate


def shape(xi, eta, h):
    """Bilinear functions on the unit square, and their gradients in an element of size h."""
    n = np.array([(1 - xi) * (1 - eta), xi * (1 - eta), xi * eta, (1 - xi) * eta])
    dx = np.array([eta - 1, 1 - eta, eta, -eta]) / h
    dy = np.array([xi - 1, -xi, xi, 1 - xi]) / h
    return n, dx, dy


def gauss(n, h):
    """(xi, eta, weight) of n x n Gauss points in an element of size h."""
    p, w = np.polynomial.legendre.leggauss(n)
    p, w = (p + 1) / 2, w / 2
    return [(a, b, u * v * h * h) for a, u in zip(p, w) for b, v in zip(p, w)]


def strain_matrix(dx, dy):
    """Strain (xx, yy, 2xy) from (ux of the 4 nodes, uy of the 4 nodes)."""
    return np.array([np.r_[dx, 0 * dx], np.r_[0 * dy, dy], np.r_[dy, dx]])


def mode_one(x, y):
    """Gradient along x of the displacement, and stress, of the mode I field with K_I = 1."""
    z = x + 1j * y
    kappa = 3 - 4 * NU
    d1 = 0.5 / np.sqrt(2 * np.pi * z)  # phi' of phi = sqrt(z / 2 pi)
    d2 = -0.5 * d1 / z
    a = (kappa * d1 - np.conj(d1) - 2j * y * np.conj(d2)) / (2 * MU)
    total, difference = 4 * d1.real, -4j * y * d2  # sxx + syy, syy - sxx + 2 i sxy
    syy = (total + difference.real) / 2
    return a.real, a.imag, total - syy, syy, difference.imag / 2


class Plate:
    """The mesh, its loads and supports, and the steps in time.  Lengths in mm."""

    def __init__(self, x0, x1, height, tip, h, traction, rollers):
        self.nx, self.ny = round((x1 - x0) / h), round(height / h)
        self.tip, self.h = round((tip - x0) / h), h * MM
        lengths = [x1 - x0, height, tip - x0] + [outer for inner, outer in DOMAINS]
        if any(abs(round(length / h) * h - length) > 1e-9 for length in lengths):
            raise SystemExit(f"h = {h} mm does not divide all of {lengths} mm")
        h = self.h
        self.stiffness = np.zeros((8, 8))
        for xi, eta, w in gauss(2, h):
            b = strain_matrix(*shape(xi, eta, h)[1:])
            self.stiffness += w * b.T @ D @ b
        wx, wy = (np.r_[0.5, np.ones(n - 1), 0.5] for n in (self.nx, self.ny))
        self.inverse_mass = np.stack(2 * [1 / (RHO * h * h * wy[:, None] * wx)])
        for side in rollers:
            self.inverse_mass[0, :, side] = 0  # held
        self.inverse_mass[1, 0, self.tip :] = 0
        self.load = traction * h * wx
        self.u, self.v, self.a = (np.zeros_like(self.inverse_mass) for _ in range(3))
        self.band = max(1, 8000 // self.nx)  # rows of elements that stay in the cache

    def elements(self, field, rows, columns):
        """Values at the nodes of a block of elements, as (8, rows, columns)."""
        (r0, r1), (c0, c1) = rows, columns
        return np.stack([f[r0 + j : r1 + j, c0 + i : c1 + i] for f in field for i, j in CORNERS])

    def accelerate(self):
        """The acceleration in the present state."""
        self.a.fill(0)
        for r0 in range(0, self.ny, self.band):
            u = self.elements(self.u, (r0, min(r0 + self.band, self.ny)), (0, self.nx))
            self.scatter(self.a, -(self.stiffness @ u.reshape(8, -1)).reshape(u.shape), r0)
        self.a[1, -1] += self.load
        self.a *= self.inverse_mass

    @staticmethod
    def scatter(field, values, r0=0):
        """Add values of elements, (8, rows, columns), to the nodes."""
        nr, nc = values.shape[1:]
        for k, value in enumerate(values):
            i, j = CORNERS[k % 4]
            field[k // 4, r0 + j : r0 + j + nr, i : i + nc] += value

    def domain(self, inner, outer):
        """The elements of a domain around the tip, (rows, columns), and q at their nodes."""
        n = round(outer * MM / self.h)
        x, y = np.arange(-n, n + 1) * self.h, np.arange(n + 1) * self.h
        q = np.clip((outer - np.maximum(abs(x), y[:, None]) / MM) / (outer - inner), 0, 1)
        return ((0, n), (self.tip - n, self.tip + n)), self.elements([q], (0, n), (0, 2 * n))

    def interaction(self, inner, outer):
        """Nodal weights (of u, of u'') whose products with the fields sum up to K_I."""
        block, q = self.domain(inner, outer)
        n, h = q.shape[1], self.h
        wu, wa = np.zeros((8, n, 2 * n)), np.zeros((8, n, 2 * n))
        for xi, eta, w in gauss(6, h):  # the mode I field is singular at the tip
            f, dx, dy = shape(xi, eta, h)
            b = strain_matrix(dx, dy)
            x = (np.arange(-n, n) + xi) * h + 0 * q[0]
            y = (np.arange(n)[:, None] + eta) * h + 0 * q[0]
            ax, ay, sxx, syy, sxy = mode_one(x, y)
            q0, qx, qy = (np.tensordot(g, q, 1) for g in (f, dx, dy))
            wu += w * np.tensordot((D @ b).T, np.stack([ax * qx, ay * qy, ax * qy + ay * qx]), 1)
            wu -= w * np.tensordot(b.T, np.stack([sxx, syy, sxy]) * qx, 1)
            for half, g in (slice(4), sxx * qx + sxy * qy), (slice(4, 8), sxy * qx + syy * qy):
                wu[half] += w * np.multiply.outer(dx, g)
            for half, g in (slice(4), ax), (slice(4, 8), ay):
                wa[half] += w * RHO * np.multiply.outer(f, g * q0)
        weights = np.zeros((2, 2, n + 1, 2 * n + 1))
        self.scatter(weights[0], wu)
        self.scatter(weights[1], wa)
        return (slice(None), slice(0, n + 1), slice(self.tip - n, self.tip + n + 1)), E_STRAIN * weights

    def k_of_j(self, inner, outer):
        """|K_I| from the dynamic J integral."""
        block, q = self.domain(inner, outer)
        j, h = 0.0, self.h
        u, a = (self.elements(f, *block) for f in (self.u, self.a))
        for xi, eta, w in gauss(2, h):
            f, dx, dy = shape(xi, eta, h)
            e = np.tensordot(strain_matrix(dx, dy), u, 1)
            s = np.tensordot(D, e, 1)
            q0, qx, qy = (np.tensordot(g, q, 1) for g in (f, dx, dy))
            ux, vx = np.tensordot(dx, u[:4], 1), np.tensordot(dx, u[4:], 1)
            ax, ay = np.tensordot(f, a[:4], 1), np.tensordot(f, a[4:], 1)
            density = (s[0] * ux + s[2] * vx) * qx + (s[2] * ux + s[1] * vx) * qy
            density += -0.5 * (s * e).sum(0) * qx + RHO * (ax * ux + ay * vx) * q0
            j += w * density.sum()
        return np.sqrt(E_STRAIN * max(2 * j, 0))

    def opening(self):
        """Weights of u_y on the crack: a fit of sqrt(r), r^1.5 and r^2.5 over 0.2 to 1 mm."""
        n0, n1 = (round(r * MM / self.h) for r in (0.2, 1.0))
        r = np.arange(n0, n1 + 1) * self.h
        fit = np.linalg.pinv(np.sqrt(r)[:, None] * np.stack([r**0, r / MM, (r / MM) ** 2], 1))
        return slice(self.tip - n1, self.tip - n0 + 1), E_STRAIN / 4 * np.sqrt(2 * np.pi) * fit[0][::-1]

    def run(self, end, sample):
        """t, and K_I by each method, as columns: 3 domains, opening, |K| from J (samples only)."""
        dt = COURANT * self.h / C_D
        steps, per_sample = int(np.ceil(end / dt)), max(1, round(sample / dt))
        integrals = [self.interaction(*d) for d in DOMAINS]
        crack, fit = self.opening()
        out = np.full((steps + 1, 2 + len(DOMAINS)), np.nan)
        for i in range(steps + 1):
            self.accelerate()
            for k, (window, w) in enumerate(integrals):
                out[i, k] = np.vdot(w[0], self.u[window]) + np.vdot(w[1], self.a[window])
            out[i, -2] = fit @ self.u[1, 0, crack]
            if i % per_sample == 0:
                out[i, -1] = self.k_of_j(*DOMAINS[1])
            self.v += np.multiply(self.a, dt if i else dt / 2, out=self.a)  # half a step later
            self.u += np.multiply(self.v, dt, out=self.a)
        return np.arange(steps + 1) * dt, out


def averaged(t, k, at, width):
    """Mean of k over windows of this width, centred; k is 0 before t = 0."""
    total = np.r_[0, np.cumsum((k[1:] + k[:-1]) / 2 * np.diff(t))]
    return (np.interp(at + width / 2, t, total) - np.interp(at - width / 2, t, total)) / width


def differences(name, k, reference, scale):
    """Print, and return, the differences of two curves in % of a scale."""
    d = (k - reference) / scale * 100
    text = f"rms {np.sqrt(np.mean(d**2)):.3f}, max {abs(d).max():.3f}"
    print(f"  {name:44s} {text}")
    return text


def extrapolated(curves):
    """First order extrapolation of the last two curves, the meshes of which must be 2 : 1."""
    return 2 * curves[-1] - curves[-2]


NAMES = [f"K_I, domain {d} mm" for d in DOMAINS] + ["opening"]


def freund(meshes):
    arrival = H * MM / C_D
    width, at = 0.05 * arrival, np.arange(1.2, 2.6001, 0.05) * arrival
    fine = np.linspace(0, 3 * arrival, 30001)
    k = 2 * SIGMA0 / (1 - NU) * np.sqrt(C_D * np.maximum(fine - arrival, 0) * (1 - 2 * NU) / np.pi)
    exact = averaged(fine, k, at, width)
    print("Freund: K_I over 0.05 arrival times, from 1.2 to 2.6; errors in % of the exact K_I")
    curves, titles = [], [f"h = {h} mm" for h in meshes]
    for h in meshes:
        t, k = Plate(-H, H, H, 0, h, SIGMA0 / 2, (0, -1)).run(2.75 * arrival, width)
        curves.append(np.array([averaged(t, c, at, width) for c in k.T[:-1]]))
    for title, curve in zip(titles + ["extrapolated"], curves + [extrapolated(curves)]):
        for name, c in zip(NAMES, curve):
            differences(f"{title}: {name}", c, exact, exact)


def chen(meshes, out):
    step, width, at = 0.05 * US, 0.2 * US, np.arange(281) * 0.05 * US
    points, means = [], []  # of each mesh: at once, and over 0.2 us
    for h in meshes:
        begin = time.time()
        t, k = Plate(0, B, L, A, h, SIGMA0, (0,)).run(at[-1] + width, step)
        points.append(np.array([np.interp(at, t, c) for c in k.T[:-1]]))
        means.append(np.array([averaged(t, c, at, width) for c in k.T[:-1]]))
        print(f"h = {h} mm: {len(t) - 1} steps in {time.time() - begin:.0f} s")
        j = ~np.isnan(k[:, -1])
        differences("  |K_I| from J - |K_I|", k[j, -1], abs(k[j, MAIN]), k[:, MAIN].max())
    # Extrapolating K_I at once would double its ripple at grid frequency: correct it by the means instead.
    mean, point = extrapolated(means), points[-1] + means[-1] - means[-2]
    peak, error = mean[MAIN].max(), ""
    print("Differences from the reference in % of its peak: at once, and over 0.2 us")
    rows = [(f"h = {h} mm", p[MAIN], m[MAIN]) for h, p, m in zip(meshes, points, means)]
    for i in range(1, len(meshes) - 1):
        p, m = points[i] + means[i] - means[i - 1], extrapolated(means[: i + 1])
        rows.append((f"extrapolated from {meshes[i]} mm", p[MAIN], m[MAIN]))
    for name, p, m in rows + [(n, point[i], mean[i]) for i, n in enumerate(NAMES)]:
        found = differences(name, p, point[MAIN], peak)
        found_mean = differences(name + ", 0.2 us", m, mean[MAIN], peak)
        if name.startswith("extrapolated"):
            error = f"# its difference from that {name}, in % of the peak: {found}; over 0.2 us {found_mean}.\n"
    turning_points(at, mean[MAIN])
    if out:
        write(out, meshes, error, np.stack([at, point[MAIN], mean[MAIN]], 1))


def turning_points(t, k):
    scale = SIGMA0 * np.sqrt(np.pi * A * MM)
    print("Turning points of K_I over 0.2 us (t, K_I, K_I / (sigma0 sqrt(pi a)))")
    for i in range(2, len(t) - 2):
        if k[i] in (k[i - 2 : i + 3].max(), k[i - 2 : i + 3].min()) and abs(k[i]) > 0.02 * scale:
            print(f"  {t[i] / US:6.2f} us {k[i]:10.0f} Pa m^0.5 {k[i] / scale:8.4f}")


def write(path, meshes, error, table):
    header = f"""\
# Chen's problem: central crack of 4.8 mm across a bar of 20 mm x 40 mm, pulled by a step of 1 MPa at
# both ends (plane strain, E = 199.992 GPa, nu = 0.3, rho = 5000 kg/m3, no damping, no contact).
# Made by tools/references/chen_reference.py, finite elements that share nothing with hampm: bilinear
# elements, lumped mass, central differences, quarter model; K_I by the dynamic interaction integral.
# Square meshes of {meshes[-2]} and {meshes[-1]} mm, extrapolated to 0 at first order.  Estimated error:
{error}t_s,K_I_Pa_sqrt_m,K_I_mean_0.2us_Pa_sqrt_m"""
    np.savetxt(path, table, fmt=("%.3e", "%.1f", "%.1f"), delimiter=",", header=header, comments="")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problem", choices=("chen", "freund"))
    parser.add_argument("--meshes", type=float, nargs="+", default=[0.05, 0.025, 0.0125], metavar="H",
                        help="sizes of the elements in mm, each half of the one before (default: %(default)s)")
    parser.add_argument("--out", help="file of the reference, for chen")
    arguments = parser.parse_args()
    if len(arguments.meshes) < 2 or np.any(np.array(arguments.meshes[1:]) * 2 != arguments.meshes[:-1]):
        parser.error("two meshes at least, each half of the one before")
    chen(arguments.meshes, arguments.out) if arguments.problem == "chen" else freund(arguments.meshes)


if __name__ == "__main__":
    main()
