"""The work for the same numbers beside p-version finite elements (NGSolve): K of a slanted crack at rest, G(t) of the beam of the paper.

Elements of a high order on a mesh that is graded in rings around the tips are the best that is known for bodies like these. Both programs
have one thread and the same domain integral; times are of the processor and without the start of a program. NGSolve has its time by
part: mesh, matrix and solution, integrals of both tips. NGSolve's integral of G(t) is a quadratic form of the nodal values, which is assembled
once, and its steps are Newmark's. The least that reaches an error counts.

Run by `make -C bench p_version`, which installs NGSolve in an environment of its own; or for one part: build/ngsolve/bin/python bench/p_version.py rest
"""

import math
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import netgen.occ as occ
import ngsolve as ng
import numpy as np
import scipy.sparse as sparse
from cracks import MODULUS, PLATE, POISSON, SIGMA, YOUNG, direction, rows
from netgen.meshing import Element1D, Element2D, FaceDescriptor, MeshPoint, Pnt
from netgen.meshing import Mesh as Points
from ngsolve import Grad, Id, IfPos, InnerProduct, Trace, dx, x, y
from questions import QUESTIONS, run
from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "postprocess"))

from history import lowpass, read_curve  # noqa: E402

A = 8e-3                                 # half-length of the slanted crack [m]
CUT, WITHIN = 5e4, 6e-4                  # of G(t) [Hz], [s]
LENGTH, TIP, DEPTH, THICK = 0.1, 0.05, 0.01, 0.01  # of the beam [m]
ALUMINIUM = (70e9, 0.3, 2700.0)


# --- meshes ---------------------------------------------------------------------------------------------------------

def circle(centre, radius):
    return occ.WorkPlane(occ.Axes((*centre, 0), occ.Z, occ.X)).Circle(0, 0, radius).Face()


def rings(tips, radius, factor, layers):
    """Discs around tips, each `factor` times as large as the one around it, and the size of elements in them."""
    faces = []
    for tip in tips:
        for layer in range(layers):
            face = circle(tip, radius * factor**layer)
            face.maxh = 1.1 * radius * factor**layer
            faces.append(face)
    return faces


def opened(old, crack, edges, ring):
    """A mesh whose nodes on a crack are doubled; `edges` names boundaries by the middle of a side, elements where `ring` is true are apart."""
    points = [np.array(point.p[:2]) for point in old.Points()]
    new = Points(dim=2)
    ids = [new.Add(MeshPoint(Pnt(*point, 0))) for point in points]
    below = {}
    if crack is not None:
        along = (crack[1] - crack[0]) / np.linalg.norm(crack[1] - crack[0])
        across = np.array([-along[1], along[0]])
        half = np.linalg.norm(crack[1] - crack[0]) / 2
        middle = (crack[0] + crack[1]) / 2
        on = [abs((p - middle) @ across) < 1e-9 and abs((p - middle) @ along) < half - 1e-9 for p in points]
        below = {k: new.Add(MeshPoint(Pnt(*point, 0))) for k, point in enumerate(points) if on[k]}
    new.Add(FaceDescriptor(surfnr=1, domin=1, bc=1))
    new.Add(FaceDescriptor(surfnr=2, domin=2, bc=1))
    new.SetMaterial(1, "far")
    new.SetMaterial(2, "ring")
    for element in old.Elements2D():
        corners = [vertex.nr - 1 for vertex in element.vertices]
        place = np.mean([points[k] for k in corners], axis=0)
        lower = crack is not None and (place - middle) @ across < 0
        new.Add(Element2D(2 if any(ring(points[k]) for k in corners) else 1, [below[k] if lower and k in below else ids[k] for k in corners]))
    names = sorted({name for name in map(edges, points) if name} | {"free"})
    for element in old.Elements1D():
        a, b = (point.nr - 1 for point in element.points)
        name = edges((points[a] + points[b]) / 2)
        if name:
            new.Add(Element1D([ids[a], ids[b]], index=names.index(name) + 1))
    for k, name in enumerate(names):
        new.SetBCName(k, name)
    return ng.Mesh(new)


def plate(layers, factor=0.15, radius=4e-3, largest=16e-3):
    """The plate of the slanted crack."""
    tips = [-A * direction(30), A * direction(30)]
    whole = occ.MoveTo(-PLATE[0], -PLATE[1]).Rectangle(2 * PLATE[0], 2 * PLATE[1]).Face()
    crack = occ.Segment(*(occ.Pnt(*tip, 0) for tip in tips))
    mesh = occ.OCCGeometry(occ.Glue([whole, *rings(tips, radius, factor, layers), crack]), dim=2).GenerateMesh(maxh=largest, grading=0.9)

    def edge(point):
        if abs(abs(point[1]) - PLATE[1]) < 1e-9:
            return "top" if point[1] > 0 else "bottom"
        return "side" if abs(abs(point[0]) - PLATE[0]) < 1e-9 else ""

    return opened(mesh, np.array(tips), edge, lambda point: any(1e-9 < radius - np.linalg.norm(point - tip) < 0.9 * radius for tip in tips)), tips


def beam(layers, factor=0.15, radius=8e-3, largest=10e-3):
    """The upper half of the beam."""
    half = occ.MoveTo(0, 0).Rectangle(LENGTH, DEPTH).Face()
    discs = [half * face for face in rings([(TIP, 0.0)], radius, factor, layers)]
    for layer, face in enumerate(discs):
        face.maxh = 1.1 * radius * factor**layer
    crack = occ.Segment(occ.Pnt(0, 0, 0), occ.Pnt(TIP, 0, 0))
    mesh = occ.OCCGeometry(occ.Glue([half, *discs, crack]), dim=2).GenerateMesh(maxh=largest, grading=0.9)

    def edge(point):
        if abs(point[0]) < 1e-9:
            return "end"
        return "ahead" if abs(point[1]) < 1e-9 and point[0] > TIP else ""

    return opened(mesh, None, edge, lambda point: 1e-9 < radius - np.linalg.norm(point - [TIP, 0]) < 0.9 * radius)


# --- elasticity -----------------------------------------------------------------------------------------------------

def law(young, poisson, plane):
    """Stress of a strain."""
    mu = young / (2 * (1 + poisson))
    lam = young * poisson / ((1 + poisson) * (1 - 2 * poisson)) if plane == "strain" else young * poisson / (1 - poisson**2)
    return mu, lambda e: 2 * mu * e + lam * Trace(e) * Id(2)


def symmetric(h):
    return 0.5 * (h + h.trans)


def weight(mesh, tip, inner, outer):
    """q, 1 around a tip and 0 beyond, linear in the elements."""
    q = ng.GridFunction(ng.H1(mesh, order=1))
    for vertex in mesh.vertices:
        q.vec[vertex.nr] = min(1.0, max(0.0, (outer - math.dist(vertex.point, tip)) / (outer - inner)))
    return q


def tip_field(mode, tip, along, mu, kappa):
    """Gradient, in the axes of the crack, of the displacement around a tip whose K is 1."""
    across = (-along[1], along[0])
    y1 = (x - tip[0]) * along[0] + (y - tip[1]) * along[1]
    y2 = (x - tip[0]) * across[0] + (y - tip[1]) * across[1]
    r = ng.sqrt(y1 * y1 + y2 * y2)
    c, s = ng.sqrt((r + y1) / (2 * r)), IfPos(y2, 1, -1) * ng.sqrt((r - y1) / (2 * r))
    if mode == 1:
        f = c * (kappa - 1 + 2 * s * s), s * (kappa + 1 - 2 * c * c)
        slope = -0.5 * s * (kappa - 1 + 2 * s * s) + 2 * c * s * c, 0.5 * c * (kappa + 1 - 2 * c * c) + 2 * s * c * s
    else:
        f = s * (kappa + 1 + 2 * c * c), -c * (kappa - 1 - 2 * s * s)
        slope = 0.5 * c * (kappa + 1 + 2 * c * c) - 2 * s * c * s, 0.5 * s * (kappa - 1 - 2 * s * s) + 2 * c * s * c
    scale = 1 / (2 * mu * math.sqrt(2 * math.pi)) / ng.sqrt(r)
    terms = [scale * (0.5 * f[i] * a + sign * slope[i] * b) for i in (0, 1) for a, b, sign in ((y1 / r, y2 / r, -1), (y2 / r, y1 / r, 1))]
    return ng.CF(tuple(terms), dims=(2, 2))


def factors(mesh, displacement, tip, along, mu, stress):
    """K_I and K_II by interaction integrals."""
    turn = ng.CF((along[0], along[1], -along[1], along[0]), dims=(2, 2))
    h = turn * Grad(displacement) * turn.trans
    slope = turn * Grad(weight(mesh, tip, 0.7e-3, 3.9e-3))
    found = []
    for mode in (1, 2):
        other = tip_field(mode, tip, along, mu, 3 - 4 * POISSON)
        e = symmetric(other)
        flux = stress(symmetric(h)) * ng.CF((other[0, 0], other[1, 0])) + stress(e) * ng.CF((h[0, 0], h[1, 0]))
        flux -= InnerProduct(stress(symmetric(h)), e) * ng.CF((1, 0))
        found.append(MODULUS / 2 * ng.Integrate(InnerProduct(flux, slope).Compile() * dx("ring", bonus_intorder=4), mesh))
    return found


# --- at rest --------------------------------------------------------------------------------------------------------

def rest(layers, order):
    """Error of K of the first tip over its size [%], unknowns, and processor time by part [s]."""
    row = next(row for row in rows("a2_slanted_centre_plate.csv") if row["case"] == "beta=30" and row["tip"] == "1")
    exact = np.array([float(row["K_I"]), float(row["K_II"])])
    clock = [time.process_time()]
    mesh, tips = plate(layers)
    clock.append(time.process_time())
    mu, stress = law(YOUNG, POISSON, "strain")
    space = ng.VectorH1(mesh, order=order)
    u, v = space.TnT()
    a = ng.BilinearForm(InnerProduct(stress(symmetric(Grad(u))), symmetric(Grad(v))) * dx, symmetric=True, condense=True).Assemble()
    f = ng.LinearForm(SIGMA * v[1] * ng.ds("top") - SIGMA * v[1] * ng.ds("bottom")).Assemble()
    free = ng.BitArray(space.FreeDofs(True))
    bottom = sorted((v.point[0], v.nr) for v in mesh.vertices if abs(v.point[1] + PLATE[1]) < 1e-9)
    n = space.components[0].ndof
    for unknown in (bottom[0][1], n + bottom[0][1], n + bottom[-1][1]):  # the loads are in equilibrium
        free.Clear(unknown)
    found = ng.GridFunction(space)
    force = f.vec.CreateVector()
    force.data = f.vec + a.harmonic_extension_trans * f.vec
    found.vec.data = a.mat.Inverse(free, inverse="sparsecholesky") * force
    found.vec.data += a.harmonic_extension * found.vec
    found.vec.data += a.inner_solve * f.vec
    clock.append(time.process_time())
    k = [factors(mesh, found, tip, sign * direction(30), mu, stress) for tip, sign in zip(tips, (-1, 1))]
    clock.append(time.process_time())
    return 100 * np.linalg.norm(k[0] - exact) / np.linalg.norm(exact), space.ndof, np.diff(clock)


# --- in motion ------------------------------------------------------------------------------------------------------

def as_scipy(form, size):
    i, j, values = form.mat.COO()
    return sparse.csr_matrix((values, (i, j)), shape=(size, size))


def motion(layers, order, dt):
    """Error of G(t) below 50 kHz, rms over the peak [%], unknowns, and processor time by part [s]."""
    times, exact = read_curve(ROOT / "tests/reference/dcb_dynamic_undamped.csv", 1)
    young, poisson, density = ALUMINIUM
    clock = [time.process_time()]
    mesh = beam(layers)
    clock.append(time.process_time())
    _, stress = law(young, poisson, "stress")
    space = ng.VectorH1(mesh, order=order)
    u, v = space.TnT()
    grad_u, grad_v = Grad(u), Grad(v)
    stiffness = ng.BilinearForm(InnerProduct(stress(symmetric(grad_u)), symmetric(grad_v)) * dx, symmetric=True).Assemble()
    mass = ng.BilinearForm(density * u * v * dx, symmetric=True).Assemble()
    f = ng.LinearForm(v[1] / (DEPTH * THICK) * ng.ds("end")).Assemble()
    # J = sum of u.Q u + a.R u, with u,1 along the crack: Moran & Shih (1987), a tip that stays
    q = weight(mesh, (TIP, 0.0), 1.3e-3, 7.9e-3)
    slope = Grad(q)
    first = ng.CF((grad_v[0, 0], grad_v[1, 0]))
    energy = 0.5 * InnerProduct(stress(symmetric(grad_u)), symmetric(grad_v))
    form = ng.BilinearForm(space)
    form += (InnerProduct(stress(symmetric(grad_u)) * first, slope) - energy * slope[0]) * dx("ring", bonus_intorder=1)
    form.Assemble()
    inertia = ng.BilinearForm(space)
    inertia += density * q * InnerProduct(u, first) * dx(bonus_intorder=1)
    inertia.Assemble()
    n = space.ndof
    free = ng.BitArray(space.FreeDofs())
    fixed = space.components[1].GetDofs(mesh.Boundaries("ahead"))
    offset = space.components[0].ndof
    for k in range(len(fixed)):
        if fixed[k]:
            free.Clear(offset + k)
    beta = 0.25 * dt**2
    effective = mass.mat.CreateMatrix()
    effective.AsVector().data = mass.mat.AsVector() + beta * stiffness.mat.AsVector()
    solver = effective.Inverse(free, inverse="sparsecholesky")
    Q, R, K = as_scipy(form, n), as_scipy(inertia, n), as_scipy(stiffness, n)
    on = np.unique(np.concatenate([Q.nonzero()[0], R.nonzero()[0], Q.nonzero()[1], R.nonzero()[1]]))
    Q, R = Q[on][:, on], R[on][:, on]
    load, right, left = f.vec.FV().NumPy(), f.vec.CreateVector(), f.vec.CreateVector()
    start = mass.mat.Inverse(free, inverse="sparsecholesky")
    right.data = start * f.vec
    w, velocity, a = np.zeros(n), np.zeros(n), right.FV().NumPy().copy()
    clock.append(time.process_time())
    steps = round(1.2 * WITHIN / dt)
    behind = offset + max((v.point[0], v.nr) for v in mesh.vertices if abs(v.point[1]) < 1e-9 and v.point[0] < TIP - 1e-9)[1]  # opens or closes
    j, measuring = [0.0], 0.0
    for _ in range(steps):
        w += dt * velocity + 0.25 * dt**2 * a
        velocity += 0.5 * dt * a
        right.FV().NumPy()[:] = load - K @ w
        left.data = solver * right
        a = left.FV().NumPy().copy()
        w += beta * a
        velocity += 0.5 * dt * a
        begin = time.process_time()
        near = w[on]
        j.append(math.copysign(2, w[behind]) * (near @ (Q.T @ near) + near @ (R.T @ a[on])))
        measuring += time.process_time() - begin
    clock.append(time.process_time())
    reference = 12 * TIP**2 / (young * THICK**2 * DEPTH**3)
    at = np.arange(steps + 1) * dt
    within = at <= WITHIN
    exact = lowpass(at, np.interp(at, times, exact), CUT)[within]
    found = lowpass(at, np.array(j) / reference, CUT)[within]
    parts = np.diff(clock)
    return 100 * np.sqrt(np.mean((found - exact)**2)) / np.max(np.abs(exact)), n, [parts[0], parts[1], parts[2] - measuring, measuring]


# --- beside the program ---------------------------------------------------------------------------------------------

REST = [(layers, order) for layers in (2, 3, 4) for order in (4, 5, 6)]
MOTION = [(layers, order, dt) for layers in (2, 3) for order in (3, 4) for dt in (1e-6, 0.5e-6, 0.25e-6)]
PARTS = {"rest": (rest, REST, {0.05: "slanted 0.05 %", 0.005: "slanted 0.005 %"}),
         "motion": (motion, MOTION, {0.35: "G(t), 0.35 %", 0.07: "G(t), 0.07 %"})}


def error_of(history, part):
    """That of a run of the program, as of its peer [%]."""
    if part == "rest":
        row = next(row for row in rows("a2_slanted_centre_plate.csv") if row["case"] == "beta=30" and row["tip"] == "1")
        exact = np.array([float(row["K_I"]), float(row["K_II"])])
        return 100 * np.linalg.norm([history["K_I"][-1] - exact[0], history["K_II"][-1] - exact[1]]) / np.linalg.norm(exact)
    times, exact = read_curve(ROOT / "tests/reference/dcb_dynamic_undamped.csv", 1)
    at, reference = history["time"], 12 * TIP**2 / (ALUMINIUM[0] * THICK**2 * DEPTH**3)
    exact = lowpass(at, np.interp(at, times, exact), CUT)[at <= WITHIN]
    found = lowpass(at, history["G"] / reference, CUT)[at <= WITHIN]
    return 100 * np.sqrt(np.mean((found - exact)**2)) / np.max(np.abs(exact))


def start_of(program):
    """Processor time of a start [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, "--version"], capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    ng.SetNumThreads(1)
    arguments = command_line(__doc__, list(PARTS), "results/p_version", turns=(5, "runs of each"))
    table = [["part", "program", "settings", "unknowns", "error [%]", "time [s]", "by part [s]"]]
    for part in arguments.part:
        solve, settings, questions = PARTS[part]
        for choice in settings:
            turns = [solve(*choice) for _ in range(arguments.turns)]
            times = [statistics.median(turn[2][k] for turn in turns) for k in range(len(turns[0][2]))]
            table.append([part, "NGSolve", " ".join(f"{value:g}" for value in choice), turns[0][1], f"{turns[0][0]:.4f}",
                          f"{statistics.median(sum(turn[2]) for turn in turns):.3f}", " ".join(f"{value:.3f}" for value in times)])
            print(*table[-1], sep="  ", flush=True)
        for name in questions.values():
            with tempfile.TemporaryDirectory() as folder:
                turns = [run(arguments.program.resolve(), QUESTIONS[name], Path(folder)) for _ in range(arguments.turns)]
            start = statistics.median(start_of(arguments.program) for _ in range(arguments.turns))
            spent = statistics.median(turn[0] for turn in turns) - start
            table.append([part, "hampm", name, "", f"{error_of(turns[0][1], part):.4f}", f"{spent:.3f}", ""])
            print(*table[-1], sep="  ", flush=True)
    write(table, "p_version", arguments.output)


if __name__ == "__main__":
    main()
