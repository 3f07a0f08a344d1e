"""The step of src/time/reference_step.f90 in numpy, by the same names and in the same order, for the models of lessons 1 to 5 and 7.

    .venv/bin/python docs/lessons/mpm.py docs/lessons/3_energy.nml method.scheme=usf > usf.csv
    .venv/bin/python docs/lessons/mpm.py docs/lessons/7_energy_release_rate.nml grid.cell=2.5e-3 grid.cells=40,5 > beam.csv

The functions of all nodes at all particles are one matrix, N[p, i] = N_i(x_p), and their gradients two, dN[j, p, i]: mapping to the nodes is a
product with the transpose, mapping to the particles one with the matrix. Nearly all of it is zero, which is why hampm does not do it that way.
"""

import sys
from types import SimpleNamespace

import f90nml
import numpy as np

CORNERS = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])


def reference_step(m, dt):
    """Advance the particles by one step, and book the work of the loads."""
    p = m.particles
    N, dN = functions_at(m, place(m), m.cell)
    for load in m.loads:
        place_load(m, load)
    external = sum(load.N.T @ np.outer(load.fraction, load.force) * factor(load, m.time) for load in m.loads)
    A = inverse_mass(m, N)
    v = map_velocity(m, N, A)
    if m.scheme in ("usf", "usavg"):
        strain(m, dN, v, dt if m.scheme == "usf" else dt / 2)
    a = divide_by_mass(A, map_force(m, dN) + external) - m.damping_rate * v  # (5)
    v_next = v + a * dt
    p.velocity += dt * N @ a
    if m.scheme == "usl":
        strain(m, dN, v_next, dt)
    if m.scheme in ("musl", "usavg"):                                      # of usf and usl no work is booked here
        v_mapped = map_velocity(m, N, A)
        strain(m, dN, v_mapped, dt if m.scheme == "musl" else dt / 2)
        for load in m.loads:
            mean = (factor(load, m.time) + factor(load, m.time + dt)) / 2
            m.external_work += mean * dt * load.fraction @ load.N @ v_mapped @ load.force
    p.displacement += dt * N @ v_next
    m.time += dt
    m.cell = np.floor((place(m) - m.lower) / m.h).astype(int)


def place(m):
    """Where the particles are in the grid: in the total frame they stay at their first places."""
    return m.particles.reference + (0 if m.total else m.particles.displacement)


def functions_at(m, x, cell):
    """The bilinear functions of the nodes of some cells at places x (n, 2), and their gradients."""
    N, dN = np.zeros((len(x), m.n_points)), np.zeros((2, len(x), m.n_points))
    xi = (x - m.lower) / m.h - cell
    row = np.arange(len(x))
    for corner in CORNERS:
        node = (cell + corner) @ [1, m.cells[0] + 1]
        along, slope = np.where(corner == 1, xi, 1 - xi), (2 * corner - 1) / m.h
        N[row, node] = along[:, 0] * along[:, 1]
        dN[0][row, node], dN[1][row, node] = slope[0] * along[:, 1], slope[1] * along[:, 0]
    return N, dN


def inverse_mass(m, N):
    """What stands for the inverse of M_ij = sum m_p N_i N_j (6), for each direction with the nodes that it moves: by the lumped masses
    D_i = sum m_p N_i (9) D**-1, or M**-1, its first two terms by D (fmpm), or that of a mean of D and M (weighted)."""
    mass, A = m.particles.mass @ N, []
    for fixed in m.fixed.T:
        free = np.flatnonzero((mass > 0) & ~fixed)
        D, S = np.diag(mass[free]), N[:, free]
        M = D if m.mass == "lumped" else S.T * m.particles.mass @ S
        if m.mass in ("lumped", "fmpm"):
            A.append((free, (2 * D - M) / np.outer(mass[free], mass[free])))
        else:
            A.append((free, np.linalg.inv(m.lumped_fraction * D + (1 - m.lumped_fraction) * M)))
    return A


def divide_by_mass(A, x):
    """Nodal sums over the masses; 0 where a component is fixed, and at nodes without mass."""
    found = np.zeros_like(x)
    for d, (free, inverse) in enumerate(A):
        found[free, d] = inverse @ x[free, d]
    return found


def map_velocity(m, N, A):
    """P2G. The momenta p_i = sum m_p v_p N_i, and the velocities that follow (8), (10)."""
    return divide_by_mass(A, N.T * m.particles.mass @ m.particles.velocity)


def map_force(m, dN):
    """P2G. The internal forces f_i = -sum V_p T_p grad N_i (7), T being the Kirchhoff stress, in the total frame the first Piola stress."""
    T = m.particles.volume[:, None, None] * stress(m.particles)
    return -sum(dN[j].T @ T[:, :, j] for j in range(2))


def strain(m, dN, v, dt):
    """Strain the particles. H <- H + dt L (I + H), L being the gradient of a nodal velocity; in the total frame H <- H + dt L."""
    L = np.stack([dN[j] @ v for j in range(2)], axis=2)
    m.particles.gradient += dt * (L if m.total else L @ (np.eye(2) + m.particles.gradient))


def stress(p):
    """Linear elasticity, lambda tr(H) I + mu (H + H^T)."""
    H = p.gradient
    return (p.lame * np.trace(H, axis1=1, axis2=2))[:, None, None] * np.eye(2) + p.mu[:, None, None] * (H + H.swapaxes(1, 2))


def place_load(m, load):
    """Where the points of a load are, each of which hangs on a particle: x_p + (I + H) dX, in the total frame X_p + dX."""
    p, at = m.particles, load.particle
    x = place(m)[at] + load.offset + (0 if m.total else np.einsum("pij,pj->pi", p.gradient[at], load.offset))
    load.N = functions_at(m, x, m.cell[at])[0]


def factor(load, time):
    """By what the force of a load is multiplied at a time."""
    return np.sin(2 * np.pi * load.frequency * time) if load.history == "sine" else 1.0


def energies(m):
    """Kinetic energy, strain energy, and the work of the loads so far [J]."""
    p = m.particles
    return np.sum(p.mass @ p.velocity**2) / 2, np.sum(p.volume @ (stress(p) * p.gradient).sum(axis=2)) / 2, m.external_work


def closure(m):
    """G of a crack along the lower edge of the body by virtual crack closure (11), signed like the opening: the force of the node at its tip,
    which the other half answers, times the opening of the node one cell behind it, over twice the area of a cell's face."""
    N, dN = functions_at(m, place(m), m.cell)
    return abs(map_force(m, dN)[m.tip, 1]) * 2 * displacement_of(m, N, m.tip - 1) / (2 * m.h * m.thickness)


def displacement_of(m, N, node):
    """The displacement of a node, upwards, with which the functions of its cells fit those of the particles there best."""
    p, at = m.particles, N[:, node] > 0
    nodes, weight = np.flatnonzero(N[at].any(axis=0)), np.sqrt(p.mass[at])
    fitted = np.linalg.lstsq(weight[:, None] * N[np.ix_(at, nodes)], weight * p.displacement[at, 1], rcond=None)[0]
    return fitted[nodes == node][0]


# --- the model: what hampm reads of it, for rectangles of linear material on uniform cells, tractions, forces on bodies and supports ---

READS = {"run": "title end_time plane thickness", "grid": "lower cell cells", "material": "name law young poisson density",
         "body": "material lower upper velocity", "constraint": "lower upper fix", "load": "kind lower upper force history frequency",
         "damping": "rate", "crack": "kind tip", "method": "frame courant mass scheme wave_speed lumped_fraction"}
CHOICES = {"plane": "stress strain", "law": "linear_elastic", "history": "step sine", "frame": "total updated",
           "mass": "lumped consistent fmpm weighted", "scheme": "usf usl musl usavg"}
KINDS = {"load": "body traction", "crack": "symmetry"}


def refuse_others(scene):
    """Refuse what would be another model without what is not read here. Of what is measured and written nothing changes the motion."""
    for name in sorted(scene.keys() - {"output", "energy_release"}):
        for group in groups(scene, name):
            for key, value in vars(group).items():
                choices = KINDS.get(name, "") if key == "kind" else CHOICES.get(key)
                if key not in READS.get(name, "").split() or choices is not None and value not in choices.split():
                    raise ValueError(f"mpm.py does not know &{name} {key} = {value}")


def groups(scene, name):
    """All groups of a name, each with lower and upper as arrays."""
    found = scene.get(name, [])
    return [SimpleNamespace(**{key: np.array(value) if isinstance(value, list) else value for key, value in group.items()})
            for group in (found if isinstance(found, list) else [found])]


def build(scene):
    """The particles, loads and supports of a model at the start."""
    refuse_others(scene)
    grid, method, plane = groups(scene, "grid")[0], scene["method"], scene["run"].get("plane", "stress")
    m = SimpleNamespace(h=grid.cell, cells=grid.cells, lower=getattr(grid, "lower", np.zeros(2)), time=0.0, external_work=0.0, loads=[],
                        scheme=method.get("scheme", "musl"), mass=method.get("mass", "lumped"), lumped_fraction=0.0,
                        total=method.get("frame", "total") == "total", thickness=scene["run"].get("thickness", 1.0),
                        damping_rate=sum(damping.rate for damping in groups(scene, "damping")))
    if m.mass == "weighted":
        m.lumped_fraction = method.get("lumped_fraction", 0.2778)
    node = m.lower + m.h * np.array([[i, j] for j in range(m.cells[1] + 1) for i in range(m.cells[0] + 1)])
    m.n_points, m.fixed, parts, speed = len(node), np.zeros(node.shape, bool), [], 0.0
    for body in groups(scene, "body"):
        of = next(material for material in groups(scene, "material") if material.name == body.material)
        nu, mu = getattr(of, "poisson", 0.0), of.young / 2 / (1 + getattr(of, "poisson", 0.0))
        lame = of.young * nu / (1 - nu**2 if plane == "stress" else (1 + nu) * (1 - 2 * nu))
        n = np.rint(2 * (body.upper - body.lower) / m.h).astype(int)
        x = body.lower + (0.5 + np.array([[i, j] for j in range(n[1]) for i in range(n[0])])) * (body.upper - body.lower) / n
        volume = np.prod((body.upper - body.lower) / n) * m.thickness
        parts.append([x, np.tile(getattr(body, "velocity", np.zeros(2)), (len(x), 1)),
                      *(np.full(len(x), value) for value in (volume, volume * of.density, lame, mu))])
        speed = max(speed, np.sqrt((lame + 2 * mu if method.get("wave_speed") == "dilatational" else mu) / of.density))
    x, v, volume, mass, lame, mu = map(np.concatenate, zip(*parts))
    m.particles = SimpleNamespace(reference=x, displacement=np.zeros_like(x), velocity=v, gradient=np.zeros((len(x), 2, 2)), volume=volume,
                                  mass=mass, lame=lame, mu=mu)
    m.cell, m.longest_step = np.floor((x - m.lower) / m.h).astype(int), method["courant"] * m.h / speed    # (31)
    for crack in groups(scene, "crack"):
        m.tip = np.argmin(np.linalg.norm(node - crack.tip, axis=1))
    for box in groups(scene, "constraint"):
        m.fixed[is_inside(node, box)] |= ["x" in box.fix, "y" in box.fix]
    for load in groups(scene, "load"):
        if load.kind == "body":                                            # on all particles in a box
            load.particle = np.flatnonzero(is_inside(x, load))
            load.offset, load.fraction = np.zeros((len(load.particle), 2)), mass[load.particle] / mass[load.particle].sum()
        else:                                                              # a traction, on points along an edge
            n = int(np.rint(2 * max(load.upper - load.lower) / m.h))
            at = load.lower + (0.5 + np.arange(n))[:, None] / n * (load.upper - load.lower)
            load.particle = np.array([np.argmin(np.linalg.norm(x - point, axis=1)) for point in at])
            load.offset, load.fraction = at - x[load.particle], np.full(n, 1 / n)
        load.history = getattr(load, "history", "step")
        m.loads.append(load)
    return m


def is_inside(x, box):
    return np.all((x >= box.lower - 1e-9) & (x <= box.upper + 1e-9), axis=1)


def run(path, *settings):
    """Run a model with settings such as 'method.scheme=usf': time, energies and, of a crack, G of its samples, and what it has become."""
    scene = f90nml.read(path)
    for setting in settings:
        key, _, value = setting.partition("=")
        scene.patch(f90nml.reads(f"&{key.replace('.', ' ', 1)} = {value} /"))
    m, interval, end = build(scene), scene["output"]["history_interval"], scene["run"]["end_time"]
    def sample():
        return (m.time, *energies(m), closure(m) if "crack" in scene else 0.0)
    samples = [sample()]
    while m.time < end - 1e-9 * interval:
        time = min(len(samples) * interval, end) - m.time
        steps = int(np.ceil(time / m.longest_step - 1e-9))                 # equal ones that end at the sample
        for _ in range(steps):
            reference_step(m, time / steps)
        samples.append(sample())
    return np.array(samples), m


if __name__ == "__main__":
    np.savetxt(sys.stdout, run(*sys.argv[1:])[0], delimiter=",", header="time,kinetic_energy,strain_energy,external_work,G_vcct_I", comments="")
