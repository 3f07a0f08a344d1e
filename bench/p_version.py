"""The work for the same numbers beside p-version finite elements (NGSolve): K of a slanted crack at rest, G(t) of the beam of the paper.

Elements of a high order on a mesh that is graded in rings around the tips are the best that is known for bodies like these. Both programs
have one thread and the same domain integral. `work` is processor time without the start of a program, median of the turns; `process` is
that of a whole process from its start, the least of the turns. NGSolve has its work by part: mesh, matrix and solution, steps, integrals.
Its integral of G(t) is a quadratic form of the nodal values, which is assembled once; its steps are Newmark's, or its modes are those of
ARPACK with the static part of the rest, as in hampm. The table `least` has the least work that reaches each error.

Run by `make -C bench p_version`, which installs NGSolve in an environment of its own; or for one part: build/ngsolve/bin/python bench/p_version.py rest
"""

import math
import os
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
from cracks import MODULUS, PLATE, POISSON, SIGMA, YOUNG, direction, rows, scene
from netgen.meshing import Element1D, Element2D, FaceDescriptor, MeshPoint, Pnt
from netgen.meshing import Mesh as Points
from ngsolve import Grad, Id, IfPos, InnerProduct, Trace, dx, x, y
from scipy.sparse.linalg import LinearOperator, eigsh
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

    return opened(mesh, None, edge, lambda point: np.linalg.norm(point - [TIP, 0]) < radius - 1e-9)


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

def error_of_k(found):
    """Of the first tip, over its size [%]."""
    row = next(row for row in rows("a2_slanted_centre_plate.csv") if row["case"] == "beta=30" and row["tip"] == "1")
    exact = np.array([float(row["K_I"]), float(row["K_II"])])
    return 100 * np.linalg.norm(found - exact) / np.linalg.norm(exact)


def rest(layers, order):
    """Error of K of the first tip over its size [%], unknowns, and processor time by part [s]."""
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
    return error_of_k(k[0]), space.ndof, np.diff(clock)


# --- in motion ------------------------------------------------------------------------------------------------------

def as_scipy(form, size):
    i, j, values = form.mat.COO()
    return sparse.csr_matrix((values, (i, j)), shape=(size, size))


def error_of_g(at, found):
    """Of G(t) over G_ref below 50 kHz, rms over the peak [%]."""
    times, exact = read_curve(ROOT / "tests/reference/dcb_dynamic_undamped.csv", 1)
    within = at <= WITHIN
    exact, found = (lowpass(at, curve, CUT)[within] for curve in (np.interp(at, times, exact), found))
    return 100 * np.sqrt(np.mean((found - exact)**2)) / np.max(np.abs(exact))


class Beam:
    """Matrices of the beam, its load, and J = sum of u.Q u + a.R u, with u,1 along the crack: Moran & Shih (1987), a tip that stays."""

    def __init__(self, layers, order):
        self.clock = [time.process_time()]
        mesh = beam(layers)
        self.clock.append(time.process_time())
        young, poisson, density = ALUMINIUM
        _, stress = law(young, poisson, "stress")
        space = ng.VectorH1(mesh, order=order)
        u, v = space.TnT()
        grad_u, grad_v = Grad(u), Grad(v)
        self.stiffness = ng.BilinearForm(InnerProduct(stress(symmetric(grad_u)), symmetric(grad_v)) * dx, symmetric=True).Assemble()
        self.mass = ng.BilinearForm(density * u * v * dx, symmetric=True).Assemble()
        self.load = ng.LinearForm(v[1] / (DEPTH * THICK) * ng.ds("end")).Assemble().vec
        # between the two smallest discs: the inertia of a larger domain brings in waves, and 0.18 % of error of G(t) below 50 kHz
        q = weight(mesh, (TIP, 0.0), *((1.3e-3, 7.9e-3) if layers < 3 else (0.19e-3, 1.19e-3)))
        slope, first = Grad(q), ng.CF((grad_v[0, 0], grad_v[1, 0]))
        energy = 0.5 * InnerProduct(stress(symmetric(grad_u)), symmetric(grad_v))
        form, inertia = ng.BilinearForm(space), ng.BilinearForm(space)
        form += (InnerProduct(stress(symmetric(grad_u)) * first, slope) - energy * slope[0]) * dx("ring", bonus_intorder=1)
        inertia += density * q * InnerProduct(u, first) * dx(bonus_intorder=1)
        self.n, self.free, offset = space.ndof, ng.BitArray(space.FreeDofs()), space.components[0].ndof
        fixed = space.components[1].GetDofs(mesh.Boundaries("ahead"))
        for k in np.flatnonzero([bool(fixed[k]) for k in range(len(fixed))]):
            self.free.Clear(offset + int(k))
        Q, R, self.K = (as_scipy(each, self.n) for each in (form.Assemble(), inertia.Assemble(), self.stiffness))
        self.on = np.unique(np.concatenate([*Q.nonzero(), *R.nonzero()]))
        self.Q, self.R = (each[self.on][:, self.on] for each in (Q, R))
        # opens or closes the crack
        self.behind = offset + max((v.point[0], v.nr) for v in mesh.vertices if abs(v.point[1]) < 1e-9 and v.point[0] < TIP - 1e-9)[1]

    def factor(self, mass, stiffness, free=None):
        """A solution by the factor of the sum of both matrices with these factors, of and to an array."""
        both = self.mass.mat.CreateMatrix()
        both.AsVector().data = mass * self.mass.mat.AsVector() + stiffness * self.stiffness.mat.AsVector()
        inverse = both.Inverse(free or self.free, inverse="sparsecholesky")
        right, left = self.load.CreateVector(), self.load.CreateVector()

        def solve(b):
            right.FV().NumPy()[:] = b
            left.data = inverse * right
            return left.FV().NumPy().copy()
        return solve

    def result(self, at, j, measuring=0.0):
        """Error, unknowns, and time by part: mesh, matrices and factors or modes, steps, integrals."""
        young = ALUMINIUM[0]
        parts = np.diff(self.clock)
        error = error_of_g(at, np.array(j) / (12 * TIP**2 / (young * THICK**2 * DEPTH**3)))
        return error, self.n, [parts[0], parts[1], parts[2] - measuring, measuring]


def newmark(layers, order, dt):
    """Error of G(t) below 50 kHz, rms over the peak [%], unknowns, and processor time by part [s]."""
    b = Beam(layers, order)
    load, beta = b.load.FV().NumPy(), 0.25 * dt**2
    solve = b.factor(1.0, beta)
    w, velocity, a = np.zeros(b.n), np.zeros(b.n), b.factor(1.0, 0.0)(load)
    b.clock.append(time.process_time())
    j, measuring = [0.0], 0.0
    for _ in range(round(1.2 * WITHIN / dt)):
        w += dt * velocity + 0.25 * dt**2 * a
        velocity += 0.5 * dt * a
        a = solve(load - b.K @ w)
        w += beta * a
        velocity += 0.5 * dt * a
        begin = time.process_time()
        near = w[b.on]
        j.append(math.copysign(2, w[b.behind]) * (near @ (b.Q.T @ near) + near @ (b.R.T @ a[b.on])))
        measuring += time.process_time() - begin
    b.clock.append(time.process_time())
    return b.result(np.arange(len(j)) * dt, j, measuring)


def modes(layers, order, number):
    """The same by modes, each in closed form under the sudden load, with what the load does to the others statically; rows each 1 us."""
    b = Beam(layers, order)
    load, M = b.load.FV().NumPy(), as_scipy(b.mass, b.n)
    free = np.flatnonzero([bool(b.free[k]) for k in range(b.n)])
    shift = (0.1 * math.sqrt(ALUMINIUM[0] / 2.6 / ALUMINIUM[2]) / LENGTH)**2
    solve = b.factor(shift, 1.0)

    def inverse(right):
        whole = np.zeros(b.n)
        whole[free] = right
        return solve(whole)[free]

    K, M = b.K[free][:, free], M[free][:, free]
    square, shape = eigsh(K, number, M, sigma=-shift, OPinv=LinearOperator(K.shape, inverse), tol=1e-8)
    strained = square > 1e-6 * shift
    square, x = square[strained], np.zeros((b.n, strained.sum()))
    x[free] = shape[:, strained]
    pull = load @ x
    held = ng.BitArray(b.free)
    held.Clear(0)                                # along the crack, where nothing pulls
    rest_of_load = b.factor(0.0, 1.0, held)(load) - x @ (pull / square)
    b.clock.append(time.process_time())
    at = np.arange(round(1.2 * WITHIN / 1e-6) + 1) * 1e-6
    swing = np.cos(np.outer(at, np.sqrt(square))) * pull
    u = (pull - swing) / square @ x.T + rest_of_load
    near, acceleration = u[:, b.on], swing @ x[b.on].T
    j = np.copysign(2, u[:, b.behind]) * (np.sum(near * (near @ b.Q), axis=1) + np.sum(near * (acceleration @ b.R), axis=1))
    j[0] = 0.0
    b.clock.append(time.process_time())
    return b.result(at, j)


# --- hampm ----------------------------------------------------------------------------------------------------------

QUADRATIC = ("grid.order=2", "body.points_per_cell=3", "refine.indicator=tip")
G_OF_T = ("method.frame=total", "energy_release.energy_balance=.false.", "output.snapshot_interval=0", "output.history_interval=1e-6",
          "damping.rate=0", "energy_release.estimators=vcct", "run.end_time=7.2e-4", "refine.rings=1")


def slanted(cells, levels, rings):
    """A slanted crack of 30 degrees in the middle of a plate, the largest cell so many times in its half-length."""
    return scene([[-A * direction(30), A * direction(30)]], A / cells, levels=levels, rings=rings), (*QUADRATIC, f"refine.max_level={levels}")


def dcb(cells, levels, *method):
    """G(t) of the beam of the paper, undamped, so many cells an arm."""
    return ROOT / "input/dcb.nml", (*QUADRATIC, *G_OF_T, f"refine.max_level={levels}", f"grid.cell={DEPTH / cells!r}", f"grid.cells={10 * cells},{cells + 1}", *method)


def by_steps(cells, levels, dt):
    return dcb(cells, levels, "method.time=implicit", "method.courant=0", f"method.time_step={dt!r}")


def by_modes(cells, levels, number):
    return dcb(cells, levels, "method.time=modal", "method.courant=0", f"method.modes={number}")


def spent(command, folder):
    """Processor time of a process [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    end = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True, env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if end.returncode:
        sys.exit(f"{command} has ended with {end.returncode}: {end.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def of_hampm(program, part, scene_of, choice, turns):
    """Error [%], unknowns, work by turn, processes by turn."""
    source, settings = scene_of(*choice)
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(source, str):
            text, source = source, Path(folder) / "scene.nml"
            source.write_text(text)
        words = [program, source, *(word for setting in (*settings, "output.file=run.h5") for word in ("--set", setting)),
                 "--force", "--quiet", "--threads", "1", "--output", folder]
        starts, runs = zip(*((spent([program, "--version"], folder), spent(words, folder)) for _ in range(turns)))
        with h5py.File(Path(folder) / "run.h5") as file:
            history = {name: column[...] for name, column in file["history"].items()}
    if part == "rest":
        error = error_of_k(np.array([history["K_I"][-1], history["K_II"][-1]]))
    else:
        error = error_of_g(history["time"], history["G_vcct_I"] / (12 * TIP**2 / (ALUMINIUM[0] * THICK**2 * DEPTH**3)))
    return error, "", [[run - start] for start, run in zip(starts, runs)], runs


def of_ngsolve(part, solve, choice, turns):
    """The same."""
    found = [solve(*choice) for _ in range(turns)]
    command = [sys.executable, "-c", f"import sys; sys.path[:0] = {sys.path!r}; import p_version as p; p.ng.SetNumThreads(1); p.{solve.__name__}(*{choice!r})"]
    return found[0][0], found[0][1], [turn[2] for turn in found], [spent(command, ROOT) for _ in range(turns)]


PARTS = {  # how each program solves, by which settings; errors that are asked [%]
    "rest": ([(rest, [(layers, order) for layers in (2, 3, 4) for order in (4, 5, 6)])],
             [(slanted, [(2, 3, 1), (2, 4, 1), (2, 4, 2), (4, 6, 1), (6, 5, 1), (6, 5, 2), (6, 6, 2), (8, 8, 2)])], (0.05, 0.005, 0.001)),
    "motion": ([(newmark, [(layers, order, dt) for layers in (2, 3) for order in (3, 4) for dt in (1e-6, 0.5e-6, 0.25e-6)]),
                (modes, [(2, 3, 16), (2, 4, 16), (2, 4, 32), (3, 4, 16), (3, 4, 32), (3, 5, 32)])],
               [(by_steps, [(2, 4, 0.5e-6), (4, 6, 0.25e-6)]), (by_modes, [(2, 4, 16), (3, 5, 16), (4, 6, 16), (5, 6, 16), (6, 6, 16)])], (0.35, 0.07))}


def main():
    ng.SetNumThreads(1)
    arguments = command_line(__doc__, list(PARTS), "results/p_version", turns=(5, "runs of each"))
    program = arguments.program.resolve()
    table = [["part", "program", "by", "settings", "unknowns", "error [%]", "work [s]", "process [s]", "by part [s]"]]
    least = [["part", "error at most [%]", "program", "by", "settings", "error [%]", "work [s]", "process [s]", "work over NGSolve", "process over NGSolve"]]
    for part in arguments.part:
        of_others, of_own, asked = PARTS[part]
        rows = []
        for name, ways in (("NGSolve", of_others), ("hampm", of_own)):
            for way, settings in ways:
                for choice in settings:
                    error, unknowns, work, runs = of_hampm(program, part, way, choice, arguments.turns) if name == "hampm" else of_ngsolve(part, way, choice, arguments.turns)
                    rows.append([part, name, way.__name__, " ".join(f"{value:g}" for value in choice), unknowns, float(error),
                                 statistics.median(map(sum, work)), min(runs), " ".join(f"{statistics.median(times):.3f}" for times in zip(*work)) if name == "NGSolve" else ""])
                    table.append([*rows[-1][:5], f"{error:.4f}", f"{rows[-1][6]:.3f}", f"{rows[-1][7]:.3f}", rows[-1][8]])
                    print(*table[-1], sep="  ", flush=True)
        for error in asked:
            best = {}
            for name in ("NGSolve", "hampm"):
                reached = [row for row in rows if row[1] == name and row[5] <= error]
                if reached:
                    best[name] = min(reached, key=lambda row: row[6])
                    row = best[name]
                    over = [f"{row[k] / best['NGSolve'][k]:.2f}" for k in (6, 7)] if name == "hampm" and "NGSolve" in best else ["", ""]
                    least.append([part, error, *row[1:4], f"{row[5]:.4f}", f"{row[6]:.3f}", f"{row[7]:.3f}", *over])
                else:
                    least.append([part, error, name, "none of these", "", "", "", "", "", ""])
    write(table, "p_version", arguments.output)
    write(least, "least", arguments.output)


if __name__ == "__main__":
    main()
