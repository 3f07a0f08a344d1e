"""Displacements of a scene by finite elements of NGSolve, and what follows from them: energies, work, reactions, fields at points.

All that acts is a sum of sources, each with a factor at each load step: loads, motions of supports, the eigenstrain. One factorisation gives the displacements of each.
"""

import math
from dataclasses import dataclass

import ngsolve as ng
import numpy as np
from opinion_mesh import AXIS, is_point
from ngsolve import x, y
from opinion_scene import Outside

BALANCED = 1e-6                     # part of the largest force that a node held for nothing may feel


def chain(scene, body, factors, exponential):
    """The factor of a graded body as a function of place, and its slope along the direction of the body (of its logarithm where it is exponential)."""
    if not factors:
        return ng.CF(1.0), ng.CF(0.0)
    if len(set(factors)) == 1:                                 # NGSolve takes exp(0) of a function that is 0 all over for 0
        return ng.CF(float(factors[0])), ng.CF(0.0)
    s = body.direction[0] * x + body.direction[1] * y
    values = [math.log(f) for f in factors] if exponential else list(factors)
    value, slope = ng.CF(values[-1]), ng.CF(0.0)
    for k in range(len(values) - 2, -1, -1):
        rate = (values[k + 1] - values[k]) / (body.at[k + 1] - body.at[k])
        value = ng.IfPos(s - body.at[k + 1], value, values[k] + rate * (s - body.at[k]))
        slope = ng.IfPos(s - body.at[k + 1], slope, rate)
    value, slope = ng.IfPos(s - body.at[0], value, values[0]), ng.IfPos(s - body.at[0], slope, 0.0)
    return (ng.exp(value) if exponential else value), slope


class Fields:
    """Functions of place of a scene: stiffness, eigenstrain, density, radius, and how the first two change along the direction of a body."""

    def __init__(self, scene, mesh):
        self.scene, self.mesh = scene, mesh
        of = [scene.bodies[body] for body, _, _ in mesh.parts]
        self.stiffness_factor, self.stiffness_slope = self.by_part([chain(scene, b, b.stiffness, True) for b in of])
        self.eigen_factor, self.eigen_slope = self.by_part([chain(scene, b, b.eigen, False) for b in of])
        density = self.by_part([chain(scene, b, b.density, True) for b in of])[0]
        base = self.tensor([b.material.stiffness.ravel() for b in of], (4, 4))
        self.stiffness = self.stiffness_factor * base
        self.base_eigen = self.tensor([b.eigenstrain for b in of], (4,))
        self.eigen = self.eigen_factor * self.base_eigen
        self.slope_direction = self.tensor([b.direction if b.at else np.zeros(2) for b in of], (2,))
        self.mass = density * self.tensor([np.array([b.material.density]) for b in of], ())
        self.weight = x if scene.ring else ng.CF(1.0)

    def tensor(self, values, dims):
        """A constant of each part."""
        found = [ng.CF(tuple(float(v) for v in one), dims=dims) if dims else ng.CF(float(one[0])) for one in values]
        return ng.CF(found) if len(found) > 1 else found[0]

    def by_part(self, pairs):
        """Functions of each part."""
        return [ng.CF([pair[k] for pair in pairs]) for k in range(2)]

    def strain(self, ux, uy, gx, gy):
        """The strain xx, yy, zz, 2 xy of displacements and their gradients."""
        return ng.CF((gx[0], gy[1], ux / x if self.scene.ring else ng.CF(0.0) * ux, gx[1] + gy[0]))


@dataclass
class Solution:
    """Displacements at the last load step, and numbers of the whole."""

    fields: Fields
    ux: ng.GridFunction
    uy: ng.GridFunction
    strain_energy: float
    external_work: float
    reactions: dict              # of holds by number: force at the end
    displaced: list              # of loads by number: mean displacement by which their force does its work, for each component
    singular: bool               # whether a point carries a load
    gives_way: bool              # whether points hold more than a rigid motion: how far they give way hangs on the elements
    floats: bool                 # whether displacements are known but for a rigid motion
    body_force: ng.CoefficientFunction
    keep: object = None

    def strain(self):
        """The strain of the law, all of it."""
        return self.fields.strain(self.ux, self.uy, ng.Grad(self.ux), ng.Grad(self.uy))

    def stress(self):
        """The stress xx, yy, zz, xy."""
        return self.fields.stiffness * (self.strain() - self.fields.eigen)

    def at(self, function, place):
        """The value of a function at a place."""
        return np.array(function(self.fields.mesh.elements(*place)))


class Problem:
    """The equations of a scene at one order of elements."""

    def __init__(self, scene, mesh, order):
        self.scene, self.mesh, self.fields = scene, mesh, Fields(scene, mesh)
        mesh.elements.UnsetDeformation()
        arcs = {f"b{k}": self.to_arc(key[4]) for k, key in enumerate(mesh.edges) if key[4] not in (None, AXIS)}
        self.keep = None
        if arcs:
            self.keep = ng.GridFunction(ng.VectorH1(mesh.elements, order=order))
            self.keep.Set(mesh.elements.BoundaryCF(arcs, default=ng.CF((0, 0))), definedon=mesh.elements.Boundaries("|".join(arcs)))
            mesh.elements.SetDeformation(self.keep)
        one = ng.H1(mesh.elements, order=order)
        self.space = one * one
        (ux, uy), (vx, vy) = self.space.TnT()
        self.v = (vx, vy)
        fields = self.fields
        strain = fields.strain(ux, uy, ng.grad(ux), ng.grad(uy))
        self.virtual = fields.strain(vx, vy, ng.grad(vx), ng.grad(vy))
        self.form = ng.BilinearForm(self.space, symmetric=True)
        self.form += ng.InnerProduct(fields.stiffness * strain, self.virtual) * fields.weight * ng.dx(bonus_intorder=2)
        self.form.Assemble()
        self.half = one.ndof
        self.free = ng.BitArray(self.space.FreeDofs())       # not those of nodes that no element has

    def to_arc(self, number):
        """From a chord to its arc."""
        _, middle, radius = self.scene.pieces()[number]
        dx, dy = x - middle[0], y - middle[1]
        out = radius / ng.sqrt(dx * dx + dy * dy) - 1
        return ng.CF((out * dx, out * dy))

    def vector(self):
        """A vector of zeros."""
        return self.form.mat.CreateColVector()

    def load(self, *terms):
        """The forces on the nodes of a linear form."""
        form = ng.LinearForm(self.space)
        for term in terms:
            form += term
        form.Assemble()
        return form.vec

    def force_of(self, number):
        """The forces on the nodes of a load with the factor 1, and the same of each component of a unit force."""
        load, w = self.scene.loads[number], self.fields.weight
        if load.kind == "gravity":
            return self.load(self.fields.mass * w * (load.value[0] * self.v[0] + load.value[1] * self.v[1]) * ng.dx), []
        if load.kind == "pressure":
            n, region = ng.specialcf.normal(2), self.mesh.boundaries(lambda key: number in key[1])
            if not ng.Integrate(ng.CF(1), region) > 0:
                raise Outside("a load that meets no edge")
            return self.load(-load.value * w * (n[0] * self.v[0].Trace() + n[1] * self.v[1].Trace()) * ng.ds(region)), []
        if load.kind == "crack":
            n, crack = ng.specialcf.normal(2), next(k for k, one in enumerate(self.scene.cracks) if one.name == load.crack)
            region = self.mesh.boundaries(lambda key: key[2] == crack)
            return self.load(-load.value * w * (n[0] * self.v[0].Trace() + n[1] * self.v[1].Trace()) * ng.ds(region)), []
        if load.kind == "point":
            node, found = self.mesh.node(load.lower), []
            for k in range(2):
                vector = self.vector()
                vector[:] = 0.0
                vector[node + k * self.half] = 1.0
                found.append(vector)
        elif load.kind == "traction":
            region = self.mesh.boundaries(lambda key: number in key[1])
            size = ng.Integrate(w, region)
            if not size > 0:
                raise Outside("a load that meets no edge")
            found = [self.load(w / size * self.v[k].Trace() * ng.ds(region)) for k in range(2)]
        else:
            region = self.mesh.materials(lambda part: number in part[2])
            size = ng.Integrate(self.fields.mass * w, self.mesh.elements, definedon=region)
            found = [self.load(self.fields.mass * w / size * self.v[k] * ng.dx(definedon=region)) for k in range(2)]
        total = self.vector()
        total.data = load.value[0] * found[0] + load.value[1] * found[1]
        return total, found

    def body_force(self):
        """Force on each volume at the end."""
        force = ng.CF((0.0, 0.0))
        for number, load in enumerate(self.scene.loads):
            if load.kind == "gravity":
                force = force + self.fields.mass * load.factors[-1] * ng.CF(tuple(load.value))
            if load.kind == "body":
                region = self.mesh.materials(lambda part: number in part[2])
                size = ng.Integrate(self.fields.mass * self.fields.weight, self.mesh.elements, definedon=region)
                inside = ng.CF([float(number in part[2]) for part in self.mesh.parts])
                force = force + inside * load.factors[-1] * self.fields.mass / size * ng.CF(tuple(load.value))
        return force

    def hold(self):
        """Fixes what is held. Returns of each hold and component the nodes, and whether displacements are known but for a rigid motion."""
        space, rows, found = self.space.components[0], [], []
        nodes = self.mesh.nodes

        def fix(bits, component):
            for dof in np.flatnonzero(np.array(list(bits))):
                self.free.Clear(int(dof) + component * self.half)

        for number, hold in enumerate(self.scene.holds):
            if is_point(hold):
                bits = ng.BitArray(self.half)
                bits.Clear()
                bits.Set(self.mesh.node(hold.lower))
            else:
                bits = space.GetDofs(self.mesh.boundaries(lambda key: number in key[0])) | space.GetDofs(self.mesh.materials(lambda part: number in part[1]))
            held = np.flatnonzero(np.array(list(bits))[:len(nodes)])
            if not len(held):
                raise Outside("a support that meets no material")
            turns = hold.turns and len(held) > 1
            for c in hold.components:
                fix(bits, c)
                rows += [(c, *place) for place in ([hold.middle] if turns else nodes[held])]
            for other, (nodes_of, turned) in zip(self.scene.holds, found):
                if set(other.components) & set(hold.components) and set(nodes_of) & set(held) and (turns or turned or np.any(other.moved != hold.moved)):
                    raise Outside("supports that share nodes and do not move alike")
            found.append((held, turns))
        if self.scene.ring:
            fix(space.GetDofs(self.mesh.boundaries(lambda key: key[4] == AXIS)), 0)
        middle = nodes.mean(0)
        modes = np.array([[c == 0, c == 1, (-(py - middle[1]) if c == 0 else px - middle[0])] for c, px, py in rows], float).reshape(-1, 3)
        if self.scene.ring:
            modes = modes[:, 1:2] * np.array([row[0] == 1 for row in rows])[:, None] if rows else np.zeros((0, 1))
        self.pins = []
        size = np.ptp(nodes, axis=0).max()
        scale = np.array([1, 1, 1 / size]) if modes.shape[1] == 3 else np.ones(1)
        modes = modes * scale
        ends = [nodes[:, k].argmin() for k in range(2)] + [nodes[:, k].argmax() for k in range(2)]
        while np.linalg.matrix_rank(modes, tol=1e-6) < modes.shape[1]:
            tried = []
            for n in ends:
                for c in range(2):
                    row = np.array([c == 0, c == 1, (-(nodes[n][1] - middle[1]) if c == 0 else nodes[n][0] - middle[0])], float) * scale if len(scale) == 3 else np.array([float(c == 1)])
                    more = np.vstack([modes, row])
                    tried.append((np.linalg.svd(more)[1][np.linalg.matrix_rank(modes, tol=1e-6)] if len(more) else 0, n, c, more))
            _, n, c, modes = max(tried, key=lambda one: one[0])
            self.pins.append((n, c))
            self.free.Clear(n + c * self.half)
        return found

    def solve(self):
        """The solution."""
        scene, held = self.scene, self.hold()
        inverse = self.form.mat.Inverse(self.free, inverse="sparsecholesky")

        def response(force, lift=None):
            """Displacements, and the forces that supports need."""
            u, r = self.vector(), self.vector()
            u[:] = 0.0
            if lift is not None:
                u.data = lift
            r.data = -1.0 * (self.form.mat * u)
            if force is not None:
                r.data += force
            u.data += inverse * r
            r.data = self.form.mat * u
            if force is not None:
                r.data -= force
            return u, r

        def lift(held, functions):
            vector = self.vector()
            vector[:] = 0.0
            values = vector.FV().NumPy()
            for c, function in functions.items():
                values[np.array(held) + c * self.half] = [function(self.mesh.nodes[n]) for n in held]
            return vector

        units = [{c: lift(nodes, {c: lambda place: 1.0}) for c in hold.components} for hold, (nodes, _) in zip(scene.holds, held)]
        turns = [lift(nodes, {c: (lambda place, c=c, hold=hold: (-(place - hold.middle)[1], (place - hold.middle)[0])[c]) for c in hold.components})
                 for hold, (nodes, turn) in zip(scene.holds, held) if turn]
        turned = [response(None, one) for one in turns]
        matrix = np.array([[ng.InnerProduct(t, r) for _, r in turned] for t in turns])

        def balanced(u, r):
            """With pins turned so that they feel no moment."""
            if turns:
                angles = np.linalg.solve(matrix, [-ng.InnerProduct(t, r) for t in turns])
                for angle, (du, dr) in zip(angles, turned):
                    u.data += float(angle) * du
                    r.data += float(angle) * dr
            return u, r

        steps = len(scene.loads[0].factors if scene.loads else scene.holds[0].factors if scene.holds else [1, 1])
        forces = [self.force_of(k) for k in range(len(scene.loads))]
        sources = [(load.factors, *balanced(*response(force)), force) for load, (force, _) in zip(scene.loads, forces)]
        for hold, unit in zip(scene.holds, units):
            moved = self.vector()
            moved[:] = 0.0
            for c in hold.components:
                moved.data += float(hold.moved[c]) * unit[c]
            if np.any(hold.moved):
                sources.append((hold.factors, *balanced(*response(None, moved)), None))
        thermal = None
        if any(np.any(body.eigenstrain) for body in scene.bodies):
            f = self.fields
            thermal = self.load(ng.InnerProduct(f.stiffness * f.eigen, self.virtual) * f.weight * ng.dx(bonus_intorder=2))
            sources.append(([1.0] * steps, *balanced(*response(thermal)), None))
        return self.gathered(sources, steps, units, forces, thermal)

    def gathered(self, sources, steps, units, forces, thermal):
        """The states at all steps, and what follows."""
        scene, zero = self.scene, self.vector()
        zero[:] = 0.0
        states = [(zero, zero, zero, [0.0] * len(units))]
        for step in range(steps):
            u, r, f = self.vector(), self.vector(), self.vector()
            for one in (u, r, f):
                one[:] = 0.0
            for factors, du, dr, df in sources:
                u.data += float(factors[step]) * du
                r.data += float(factors[step]) * dr
                if df is not None:
                    f.data += float(factors[step]) * df
            states.append((u, r, f, [hold.factors[step] for hold in scene.holds]))
        u, r, _, _ = states[-1]
        largest = max([np.abs(one.FV().NumPy()).sum() for one in [state[2] for state in states] + [thermal] * (thermal is not None)] + [np.abs(r.FV().NumPy()).max(), 1e-300])
        if any(abs(r[n + c * self.half]) > BALANCED * largest for n, c in self.pins):
            raise Outside("loads that nothing balances")
        work = 0.0
        for (u0, r0, f0, s0), (u1, r1, f1, s1) in zip(states, states[1:]):
            mean, way = self.vector(), self.vector()
            mean.data, way.data = 0.5 * f0 + 0.5 * f1, u1 - u0
            work += ng.InnerProduct(mean, way)
            mean.data = 0.5 * r0 + 0.5 * r1
            work += sum((b - a) * hold.moved[c] * ng.InnerProduct(mean, unit[c]) for hold, unit, a, b in zip(scene.holds, units, s0, s1) for c in hold.components)
        found = self.vector()
        found.data = self.form.mat * u
        energy = 0.5 * ng.InnerProduct(u, found)
        if thermal is not None:
            f = self.fields
            energy += -ng.InnerProduct(u, thermal) + 0.5 * ng.Integrate(ng.InnerProduct(f.stiffness * f.eigen, f.eigen) * f.weight, self.mesh.elements, order=12)
        reactions = {k: {c: ng.InnerProduct(unit[c], r) for c in scene.holds[k].components} for k, unit in enumerate(units)}
        points = [one for one in scene.loads if one.kind == "point" and np.any(one.value) and np.any(one.factors)]
        supports = [k for k, hold in enumerate(scene.holds) if is_point(hold) and max(map(abs, reactions[k].values())) > BALANCED * largest]
        held = sum(len(hold.components) * (1 if is_point(hold) else 3) for hold in scene.holds if not scene.ring or hold.components != [0]) + scene.ring * sum(
            0 in hold.components for hold in scene.holds)
        motions = 1 if scene.ring else 3
        ux, uy = (ng.GridFunction(self.space.components[0]) for _ in range(2))
        ux.vec.FV().NumPy()[:], uy.vec.FV().NumPy()[:] = u.FV().NumPy()[:self.half], u.FV().NumPy()[self.half:]
        displaced = [[ng.InnerProduct(one, u) for one in parts] for _, parts in forces]
        return Solution(self.fields, ux, uy, energy, work, reactions, displaced, bool(points or supports), bool(supports) and held > motions, bool(self.pins), self.body_force(), self.keep)
