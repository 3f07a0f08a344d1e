"""Displacements of a scene by finite elements of NGSolve, and what follows from them: energies, work, reactions, fields at points.

All that acts is a sum of sources, each with a factor at each load step: loads, motions of supports, the eigenstrain. One factorisation gives the displacements of each.
Vectors of nodal values are those of numpy: first all x, then all y.
"""

import math
from dataclasses import dataclass

import ngsolve as ng
import numpy as np
from ngsolve import x, y
from opinion_mesh import AXIS, is_point
from opinion_scene import Outside
from scipy.sparse import csr_matrix

BALANCED = 1e-6                     # part of the largest force that a node held for nothing may feel


def chain(body, factors, exponential):
    """The factor of a graded body as a function of place, and its slope along the direction of the body (of its logarithm where it is exponential)."""
    if not factors or len(set(factors)) == 1:                  # NGSolve takes exp(0) of a function that is 0 all over for 0
        return ng.CF(float(factors[0]) if factors else 1.0), ng.CF(0.0)
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

        def by_part(values, *dims):
            return ng.CF([ng.CF(tuple(map(float, np.ravel(one))), dims=dims) if dims else ng.CF(one) for one in values])

        (grade, self.stiffness_slope), (eigen, self.eigen_slope), (density, _) = (
            map(by_part, zip(*(chain(b, getattr(b, name), exponential) for b in of))) for name, exponential in (("stiffness", True), ("eigen", False), ("density", True)))
        self.stiffness = grade * by_part([b.material.stiffness for b in of], 4, 4)
        self.base_eigen = by_part([b.eigenstrain for b in of], 4)
        self.eigen = eigen * self.base_eigen
        self.slope_direction = by_part([b.direction if b.at else np.zeros(2) for b in of], 2)
        self.mass = density * by_part([b.material.density for b in of])
        self.weight = x if scene.ring else ng.CF(1.0)

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
        (ux, uy), self.v = self.space.TnT()
        strain, self.virtual = (self.fields.strain(*u, *map(ng.grad, u)) for u in ((ux, uy), self.v))
        self.form = ng.BilinearForm(self.space)
        self.form += ng.InnerProduct(self.fields.stiffness * strain, self.virtual) * self.fields.weight * ng.dx(bonus_intorder=2)
        self.form.Assemble()
        rows, columns, values = map(np.array, self.form.mat.COO())
        self.stiffness = csr_matrix((values, (rows, columns)))
        self.half = one.ndof
        self.free = ng.BitArray(self.space.FreeDofs())       # not those of nodes that no element has

    def to_arc(self, number):
        """From a chord to its arc."""
        _, middle, radius = self.scene.pieces()[number]
        dx, dy = x - middle[0], y - middle[1]
        out = radius / ng.sqrt(dx * dx + dy * dy) - 1
        return ng.CF((out * dx, out * dy))

    def linear(self, term):
        """The forces on the nodes of a linear form."""
        return ng.LinearForm(term).Assemble().vec.FV().NumPy().copy()

    def pushed(self, fx, fy, region=None):
        """The forces on the nodes of a force on each length of the edges of a region, or on each area."""
        fx, fy = fx * self.fields.weight, fy * self.fields.weight
        return self.linear((fx * self.v[0] + fy * self.v[1]) * ng.dx if region is None else (fx * self.v[0].Trace() + fy * self.v[1].Trace()) * ng.ds(region))

    def by_volume(self, number):
        """By what a load on volumes is multiplied to be the force on each."""
        if self.scene.loads[number].kind == "gravity":
            return self.fields.mass
        part = self.fields.mass * ng.CF([float(number in part[2]) for part in self.mesh.parts])
        return part / ng.Integrate(part * self.fields.weight, self.mesh.elements)

    def force_of(self, number):
        """The forces on the nodes of a load with the factor 1, and the same of each component of a unit force."""
        load = self.scene.loads[number]
        if load.kind == "point":
            found = np.zeros((2, 2 * self.half))
            found[[0, 1], self.mesh.node(load.lower) + np.array([0, self.half])] = 1.0
        elif load.kind in ("gravity", "body"):
            part = self.by_volume(number)
            found = [self.pushed(part, 0 * part), self.pushed(0 * part, part)]
        else:
            crack = next((k for k, one in enumerate(self.scene.cracks) if load.kind == "crack" and one.name == load.crack), None)
            region, n = self.mesh.boundaries(lambda key: number in key[1] if crack is None else key[2] == crack), ng.specialcf.normal(2)
            size = ng.Integrate(self.fields.weight, region)
            if not size > 0:
                raise Outside("a load that meets no edge")
            if load.kind != "traction":
                return self.pushed(-load.value * n[0], -load.value * n[1], region), []
            found = [self.pushed(ng.CF(k == 0) / size, ng.CF(k == 1) / size, region) for k in range(2)]
        return load.value @ np.array(found), found

    def body_force(self):
        """Force on each volume at the end."""
        return sum((load.factors[-1] * self.by_volume(k) * ng.CF(tuple(load.value)) for k, load in enumerate(self.scene.loads) if load.kind in ("gravity", "body")), ng.CF((0.0, 0.0)))

    def hold(self):
        """Fixes what is held, and as many components of nodes more, `pins`, as a rigid motion has. Returns of each hold the nodes, and whether they turn."""
        space, nodes, ring, rows, found = self.space.components[0], self.mesh.nodes, self.scene.ring, [], []
        middle, size = nodes.mean(0), np.ptp(nodes, axis=0).max()

        def fix(dofs, component):
            for dof in dofs:
                self.free.Clear(int(dof) + component * self.half)

        def motion(c, place):
            """What a component at a place is moved by the rigid motions of the whole."""
            off = (place - middle) / size
            return [float(c == 1)] if ring else [c == 0, c == 1, -off[1] if c == 0 else off[0]]

        for number, hold in enumerate(self.scene.holds):
            regions = self.mesh.boundaries(lambda key: number in key[0]), self.mesh.materials(lambda part: number in part[1])
            dofs = [self.mesh.node(hold.lower)] if is_point(hold) else np.flatnonzero(np.array(list(space.GetDofs(regions[0]) | space.GetDofs(regions[1]))))
            held = np.array([dof for dof in dofs if dof < len(nodes)])
            if not len(held):
                raise Outside("a support that meets no material")
            turns = hold.turns and len(held) > 1
            for c in hold.components:
                fix(dofs, c)
                rows += [motion(c, place) for place in ([hold.middle] if turns else nodes[held])]
            for other, (nodes_of, turned) in zip(self.scene.holds, found):
                if set(other.components) & set(hold.components) and set(nodes_of) & set(held) and (turns or turned or np.any(other.moved != hold.moved)):
                    raise Outside("supports that share nodes and do not move alike")
            found.append((held, turns))
        if ring:
            fix(np.flatnonzero(np.array(list(space.GetDofs(self.mesh.boundaries(lambda key: key[4] == AXIS))))), 0)
        self.pins, motions = [], 1 if ring else 3
        rows = np.array(rows, float).reshape(-1, motions)
        ends = [(n, c) for k in range(2) for n in (nodes[:, k].argmin(), nodes[:, k].argmax()) for c in range(2)]
        while (rank := np.linalg.matrix_rank(rows, tol=1e-6)) < motions:
            more = [np.vstack([rows, motion(c, nodes[n])]) for n, c in ends]
            best = max(range(len(ends)), key=lambda k: np.linalg.svd(more[k])[1][rank])
            rows = more[best]
            self.pins.append(ends[best])
            fix(ends[best][:1], ends[best][1])
        return found

    def solve(self):
        """The solution."""
        scene, half, held = self.scene, self.half, self.hold()
        inverse, b, x = self.form.mat.Inverse(self.free, inverse="sparsecholesky"), self.form.mat.CreateColVector(), self.form.mat.CreateColVector()

        def response(force, lift=0.0):
            """Displacements, and the forces that supports need."""
            u = np.zeros(2 * half) + lift
            b.FV().NumPy()[:] = force - self.stiffness @ u
            x.data = inverse * b
            u += x.FV().NumPy()
            return u, self.stiffness @ u - force

        def lifted(nodes, values, c):
            vector = np.zeros(2 * half)
            vector[nodes + c * half] = values
            return vector

        def own(number, c):
            """The nodes of a hold that no later one holds in a component: the last one has those that several hold."""
            later = [nodes for hold, (nodes, _) in list(zip(scene.holds, held))[number + 1:] if c in hold.components]
            return np.setdiff1d(held[number][0], np.concatenate([np.zeros(0, int), *later]))

        units = [{c: lifted(own(number, c), 1.0, c) for c in hold.components} for number, hold in enumerate(scene.holds)]
        turns = [sum(lifted(nodes, (1 - 2 * (c == 0)) * (self.mesh.nodes[nodes] - hold.middle)[:, 1 - c], c) for c in hold.components) for hold, (nodes, turn) in zip(scene.holds, held) if turn]
        turned = [response(0.0, one) for one in turns]

        def balanced(u, r):
            """With pins turned so that they feel no moment."""
            angles = np.linalg.solve([[t @ s for _, s in turned] for t in turns], [-t @ r for t in turns]) if turns else []
            return u + sum(angle * du for angle, (du, _) in zip(angles, turned)), r + sum(angle * dr for angle, (_, dr) in zip(angles, turned))

        steps = len(scene.loads[0].factors if scene.loads else scene.holds[0].factors if scene.holds else [1, 1])
        forces = [self.force_of(k) for k in range(len(scene.loads))]
        sources = [(load.factors, force, *balanced(*response(force))) for load, (force, _) in zip(scene.loads, forces)]
        sources += [(hold.factors, 0 * u, *balanced(*response(0.0, u))) for hold, unit in zip(scene.holds, units) if np.any(hold.moved) for u in [sum(hold.moved[c] * unit[c] for c in unit)]]
        f, thermal = self.fields, np.zeros(2 * half)
        has_eigenstrain = any(np.any(body.eigenstrain) for body in scene.bodies)
        if has_eigenstrain:
            thermal = self.linear(ng.InnerProduct(f.stiffness * f.eigen, self.virtual) * f.weight * ng.dx(bonus_intorder=2))
            sources.append(([1.0] * steps, 0 * thermal, *balanced(*response(thermal))))
        acting, us, rs = (np.array([np.zeros((steps + 1, 2 * half)), *(np.outer([0.0, *one[0]], one[k]) for one in sources)]).sum(0) for k in (1, 2, 3))   # by steps, from 0 on
        u, r = us[-1], rs[-1]
        largest = max(*np.abs(acting).sum(1), np.abs(thermal).sum(), np.abs(r).max(), 1e-300)
        if any(abs(r[n + c * half]) > BALANCED * largest for n, c in self.pins):
            raise Outside("loads that nothing balances")

        def work(force, way):
            return np.sum((force[1:] + force[:-1]) / 2 * (way[1:] - way[:-1]))

        external = work(acting, us) + sum(work(rs @ unit[c], hold.moved[c] * np.array([0.0, *hold.factors])) for hold, unit in zip(scene.holds, units) for c in unit)
        energy = u @ (self.stiffness @ u) / 2 - u @ thermal
        if has_eigenstrain:
            energy += ng.Integrate(ng.InnerProduct(f.stiffness * f.eigen, f.eigen) * f.weight, self.mesh.elements, order=12) / 2
        reactions = {k: {c: unit[c] @ r for c in unit} for k, unit in enumerate(units)}
        points = [one for one in scene.loads if one.kind == "point" and np.any(one.value) and np.any(one.factors)]
        supports = [k for k, hold in enumerate(scene.holds) if is_point(hold) and max(map(abs, reactions[k].values())) > BALANCED * largest]
        held = sum(len(hold.components) * (1 if is_point(hold) else 3) for hold in scene.holds if not scene.ring or hold.components != [0]) + scene.ring * sum(
            0 in hold.components for hold in scene.holds)
        ux, uy = (ng.GridFunction(self.space.components[0]) for _ in range(2))
        ux.vec.FV().NumPy()[:], uy.vec.FV().NumPy()[:] = u[:half], u[half:]
        displaced = [[part @ u for part in parts] for _, parts in forces]
        return Solution(f, ux, uy, energy, external, reactions, displaced, bool(points or supports), bool(supports) and held > (1 if scene.ring else 3), bool(self.pins), self.body_force(), self.keep)
