"""J and stress intensity factors by integrals over rings around a tip.

With the virtual motion V = q e of the material along the direction e of the crack, q = 1 within a ring and 0 beyond, G is what the potential energy falls by V, for each
length of the front (Parks 1977; deLorenzi 1982): for the energy density W and w = 1 in a plane, w = r around an axis,

    G = 1/w_tip int [ (sigma_ij u_i,1 - W delta_1j) q_,j w + q e_r (sigma_tt u_r/r - W) - q w (b_i u_i,1 - sigma:eps0_,1 + W_,1|explicit) ] dA  - 1/w_tip int_faces t_i u_i,1 q w ds .

The last term of a pressure p on both faces is int p (u_i,1 q w)_,i dA, by the divergence theorem. The interaction integral is the part of G of the sum of the actual field and a
singular field of a unit K that is bilinear in both (Stern, Becker & Dunham 1976), with the singular field of the material at the tip: Williams' for isotropic, that of Sih, Paris
& Irwin (1965) for anisotropic material. Its stress is that of the stiffness of each place, so that it is not in balance where that changes, nor around an axis: terms of that.
"""

import math

import ngsolve as ng
import numpy as np
from opinion_scene import Outside

RINGS = (0.1, 0.5), (0.2, 0.7), (0.3, 0.75)        # inner and outer radius over the room around the tip
SMALLEST = 0.02                                    # room around a tip that is judged [cells]


def unit_field(compliance, isotropic, mode, x1, x2):
    """Displacements (2, n) and their gradients (2, 2, n), the derivative last but one, of a unit K of a mode in the axes of the crack."""
    if isotropic:
        shear, modulus = 1 / compliance[2, 2], 1 / compliance[0, 0]
        kappa = 8 * shear / modulus - 1
        r, theta = np.hypot(x1, x2), np.arctan2(x2, x1)
        c, s = np.cos(theta / 2), np.sin(theta / 2)
        if mode == 0:
            g = np.array([c * (kappa - 1 + 2 * s * s), s * (kappa + 1 - 2 * c * c)])
            dg = np.array([-s * (kappa - 1 + 2 * s * s) + 4 * s * c * c, c * (kappa + 1 - 2 * c * c) + 4 * c * s * s]) / 2
        else:
            g = np.array([s * (kappa + 1 + 2 * c * c), -c * (kappa - 1 - 2 * s * s)])
            dg = np.array([c * (kappa + 1 + 2 * c * c) - 4 * c * s * s, s * (kappa - 1 - 2 * s * s) + 4 * s * c * c]) / 2
        size = 1 / (2 * shear * math.sqrt(2 * math.pi))
        by_r, by_angle = size * g / (2 * np.sqrt(r)), size * dg / np.sqrt(r)
        cos, sin = np.cos(theta), np.sin(theta)
        return size * np.sqrt(r) * g, np.stack([cos * by_r - sin * by_angle, sin * by_r + cos * by_angle], axis=1)
    (a11, a12, a16), (_, a22, a26), (_, _, a66) = compliance
    roots = np.roots([a11, -2 * a16, 2 * a12 + a66, -2 * a26, a22])
    m1, m2 = (root for root in roots if root.imag > 0)
    if abs(m1 - m2) < 1e-6:
        raise Outside("an orthotropic material that is isotropic in the plane")
    p = [a11 * m * m + a12 - a16 * m for m in (m1, m2)]
    q = [a12 * m + a22 / m - a26 for m in (m1, m2)]
    weights = (-m2, m1) if mode == 0 else (-1.0, 1.0)     # of the two roots
    roots = [np.sqrt(x1 + m * x2) for m in (m1, m2)]
    u, gradient = np.zeros((2, len(x1))), np.zeros((2, 2, len(x1)))
    for i, factors in enumerate((p, q)):
        for k, m in enumerate((m1, m2)):
            size = math.sqrt(2 / math.pi) * weights[k] * factors[k] / (m1 - m2)
            u[i] += (size * roots[k]).real
            gradient[i, 0] += (size / (2 * roots[k])).real
            gradient[i, 1] += (size * m / (2 * roots[k])).real
    return u, gradient


def release(compliance, isotropic):
    """The matrix L of G = K L K, from the work that closes a short piece of the crack (Irwin 1957)."""
    behind = np.array([-1.0]), np.array([1e-14])
    opened = np.array([[2 * unit_field(compliance, isotropic, mode, *behind)[0][i, 0] for mode in (0, 1)] for i in (1, 0)])
    matrix = math.pi / (4 * math.sqrt(2 * math.pi)) * opened
    return (matrix + matrix.T) / 2


class Disc:
    """The fields of a solution at quadrature points around a tip."""

    def __init__(self, solution, scene, tip, room, order):
        self.tip, self.scene, self.room = tip, scene, room
        mesh, fields = solution.fields.mesh.elements, solution.fields
        rule = ng.IntegrationRule(ng.TRIG, 2 * order + 6)
        points = mesh.MapToAllElements({ng.TRIG: rule, ng.QUAD: rule}, ng.VOL)
        corners = np.array([[v.nr for v in el.vertices] for el in mesh.Elements(ng.VOL)])
        places = solution.fields.mesh.nodes[corners]
        far = np.linalg.norm(places - tip.place, axis=2)
        edge = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(1)
        near = far.min(1) - edge < RINGS[-1][1] * room
        chosen = np.repeat(near, len(rule.points))
        points = points[chosen]

        def value(function):
            return np.array(function(points)).reshape(len(points), -1).T

        weights = np.tile(np.array(rule.weights), int(near.sum()))
        self.weight = weights * np.abs(np.linalg.det(value(ng.specialcf.JacobianMatrix(2)).T.reshape(-1, 2, 2)))
        self.place = value(ng.CF((ng.x, ng.y)))
        self.u = value(ng.CF((solution.ux, solution.uy)))
        self.gradient = value(ng.CF((ng.Grad(solution.ux)[0], ng.Grad(solution.ux)[1], ng.Grad(solution.uy)[0], ng.Grad(solution.uy)[1]))).reshape(2, 2, -1)
        self.stress = value(solution.stress())
        self.elastic = value(solution.strain() - fields.eigen)
        self.energy = (self.stress * self.elastic).sum(0) / 2
        self.force = value(solution.body_force)
        self.stiffness = value(fields.stiffness).reshape(4, 4, -1)
        direction, self.e = value(fields.slope_direction), tip.direction
        along = direction.T @ self.e
        self.grade = value(fields.stiffness_slope)[0] * along                     # of the logarithm, along the crack
        self.grade_vector = value(fields.stiffness_slope)[0] * direction
        self.free_change = value(fields.base_eigen) * value(fields.eigen_slope)[0] * along
        self.rho = self.place[0] if scene.ring else np.ones(len(self.place[0]))
        self.pressure = tip.crack.pressure
        self.size = tip.place[0] if scene.ring else 1.0

    def cut_off(self, inner, outer):
        """q and its gradient."""
        off = self.place - self.tip.place[:, None]
        r = np.hypot(*off)
        t = np.clip((r - inner) / (outer - inner), 0, 1)
        return 1 - t**3 * (10 - 15 * t + 6 * t * t), -30 * t**2 * (1 - t)**2 / (outer - inner) * off / r

    def pressed(self, along, dilatation, radial, q, dq):
        """The integrand of the pressure on the faces, of the field with that derivative along the crack, dilatation in the plane and derivative of the radial part."""
        term = (along * dq).sum(0) * self.rho - dilatation * (self.e @ dq) * self.rho
        if self.scene.ring:
            term += radial * q - dilatation * q * self.e[0]
        return self.pressure * term

    def j(self, inner, outer):
        """J by one ring."""
        q, dq = self.cut_off(inner, outer)
        along = np.einsum("ikn,k->in", self.gradient, self.e)
        s, w = self.stress, self.energy
        flow = (s[0] * along[0] + s[3] * along[1]) * dq[0] + (s[3] * along[0] + s[1] * along[1]) * dq[1] - w * (self.e @ dq)
        inside = -(self.force * along).sum(0) + (s * self.free_change).sum(0) - self.grade * w
        total = (flow + q * inside) * self.rho
        if self.scene.ring:
            total += q * self.e[0] * (s[2] * self.u[0] / self.rho - w)
        total += self.pressed(along, self.gradient[0, 0] + self.gradient[1, 1], along[0], q, dq)
        return float(total @ self.weight) / self.size

    def k(self, inner, outer, material):
        """K_I and K_II by one ring."""
        e, n = self.e, np.array([-self.e[1], self.e[0]])
        axes = np.stack([e, n])                                                 # rows are the axes of the crack
        off = axes @ (self.place - self.tip.place[:, None])
        compliance = turned(material.compliance, math.atan2(e[1], e[0]))
        q, dq = self.cut_off(inner, outer)
        along, s, found = np.einsum("ikn,k->in", self.gradient, e), self.stress, []
        for mode in (0, 1):
            a, da = unit_field(compliance, material.isotropic, mode, *off)
            a, da = axes.T @ a, np.einsum("ai,abn,bk->ikn", axes, da, axes)
            flat = np.array([da[0, 0], da[1, 1], 0 * a[0], da[0, 1] + da[1, 0]])
            sa, hoop = np.einsum("ijn,jn->in", self.stiffness, flat), a[0] / self.rho if self.scene.ring else 0 * a[0]
            a1, w = np.einsum("ikn,k->in", da, e), (s * flat).sum(0) + s[2] * hoop
            flow = (s[0] * a1[0] + s[3] * a1[1] + sa[0] * along[0] + sa[3] * along[1]) * dq[0]
            flow += (s[3] * a1[0] + s[1] * a1[1] + sa[3] * along[0] + sa[1] * along[1]) * dq[1] - w * (e @ dq)
            lack = np.array([sa[0] * self.grade_vector[0] + sa[3] * self.grade_vector[1], sa[3] * self.grade_vector[0] + sa[1] * self.grade_vector[1]])
            inside = -(self.force * a1).sum(0) + (sa * self.free_change).sum(0) - self.grade * w + (lack * along).sum(0)
            total = (flow + q * inside) * self.rho
            if self.scene.ring:
                by_hoop = self.stiffness[:, 2]                                  # stress for each hoop strain, of which that in the plane is taken out of `sa`: faces are free of it
                held = by_hoop[0] * self.gradient[0, 0] + by_hoop[1] * self.gradient[1, 1] + by_hoop[3] * (self.gradient[0, 1] + self.gradient[1, 0])
                total += held * (a[0] * (e @ dq) + (a1[0] + self.grade * a[0]) * q)
                total += q * (s[2] * hoop * e[0] + sa[0] * along[0] + sa[3] * along[1] - w * e[0] - (sa[2] + by_hoop[2] * hoop) * (along[0] - self.u[0] * e[0] / self.rho))
            total += self.pressed(a1, da[0, 0] + da[1, 1], a1[0], q, dq)
            found.append(float(total @ self.weight) / self.size)
        return np.linalg.solve(2 * release(compliance, material.isotropic), found)


def turned(compliance, angle):
    """A compliance of (xx, yy, 2 xy) in axes that are turned by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    stress = np.array([[c * c, s * s, -2 * c * s], [s * s, c * c, 2 * c * s], [c * s, -c * s, c * c - s * s]])   # from the turned axes
    return stress.T @ compliance @ stress


def tip_values(solution, scene, tip, room, seam, order, rings=RINGS):
    """Rows by rings: J, K_I, K_II, the last two NaN at a seam of two materials; of a crack on a symmetry plane those of the whole crack."""
    if room < SMALLEST:
        raise Outside("a tip without room")
    disc = Disc(solution, scene, tip, room, order)
    body = scene.body_at(tip)
    rows = []
    for inner, outer in rings:
        j = disc.j(inner * room, outer * room)
        k = np.full(2, np.nan) if seam else disc.k(inner * room, outer * room, graded(body, tip.place))
        rows.append([j, *k] if tip.crack.kind != "symmetry" else [2 * j, 2 * k[0], 0.0])
    return np.array(rows)


def graded(body, place):
    """The material of a body at a place."""
    if not body.at or not body.stiffness:
        return body.material
    factor = math.exp(np.interp(place @ body.direction, body.at, np.log(body.stiffness)))
    return type(body.material)(body.material.stiffness * factor, body.material.compliance / factor, body.material.isotropic, body.material.density, body.material.key)
