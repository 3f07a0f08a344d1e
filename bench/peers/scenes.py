"""The scenes of `bench_step` for those who compute the same motion by other means (plain_scene.f90)."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
CELL, DENSITY, POISSON = 1e-3, 2700.0, 0.3


class Body:
    """The particles of a plain scene, four a cell in the order of the cells, plane stress."""

    def __init__(self, cells, motion):
        young = 70e9 if motion == "smooth" else 70e6
        first, last = (0, cells) if motion == "smooth" else (cells // 8, 3 * cells // 4)
        columns, rows = np.meshgrid(np.arange(first, last), np.arange(first, last))
        corners = np.stack([columns.ravel(), rows.ravel()], axis=1)
        places = np.array([[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]])
        self.x = ((corners[:, None, :] + places) * CELL).reshape(-1, 2)
        self.v = 1e-3 * np.sin(200 * self.x)
        if motion == "turning":
            centre = 0.4375 * cells * CELL
            self.v += [3.0, 2.0] + 300 * np.stack([centre - self.x[:, 1], self.x[:, 0] - centre], axis=1)
        self.n, self.cells = len(self.x), cells
        self.volume = np.full(self.n, CELL**2 / 4)
        self.mass = DENSITY * self.volume
        self.mu = young / 2 / (1 + POISSON)
        self.lam = young * POISSON / (1 - POISSON**2)
        self.dt = 0.1 * CELL / np.sqrt(self.mu / DENSITY)

    def energies(self, v, h):
        """Kinetic and strain energy [J] of velocities and of displacement gradients as 11, 12, 21, 22 in any order of the particles, which
        are all alike."""
        strain = self.lam / 2 * (h[:, 0] + h[:, 3])**2 + self.mu * (h[:, 0]**2 + h[:, 3]**2 + (h[:, 1] + h[:, 2])**2 / 2)
        return self.mass[0] / 2 * np.sum(v**2), self.volume[0] * np.sum(strain)


class InC:
    """Steps by step.c, or by element_step.c."""

    def __init__(self, body, library):
        self.body, self.library = body, library
        particles = np.zeros((body.n, 10))
        particles[:, :2], particles[:, 2:4], particles[:, 8], particles[:, 9] = body.x, body.v, body.mass, body.volume
        self.state = ctypes.c_void_p(library.new_body(
            body.n, particles.ctypes.data_as(ctypes.c_void_p), body.cells, body.cells,
            *map(ctypes.c_double, (CELL, body.lam, body.mu, body.dt))))

    def steps(self, count):
        self.library.steps(self.state, count)

    def energies(self):
        particles = np.ctypeslib.as_array(self.library.particles_of(self.state), shape=(self.body.n, 10))
        return self.body.energies(particles[:, 2:4], particles[:, [4, 6, 5, 7]])


class ByElements(InC):
    """Central differences by element_step.c: another motion, for the time only."""

    def steps(self, count):
        self.library.leap(self.state, count)


class InNumba:
    """Steps by step_numba.py."""

    def __init__(self, body):
        from step_numba import steps
        nodes = (body.cells + 1)**2
        self.body, self.function = body, steps
        self.h = np.zeros((body.n, 4))
        self.arguments = [body.x.copy(), body.v.copy(), self.h, body.mass, body.volume, np.zeros(nodes), np.zeros((nodes, 2)),
                          np.zeros((nodes, 2)), body.cells, CELL, body.lam, body.mu, body.dt]
        steps(0, *self.arguments)                # compiles

    def steps(self, count):
        self.function(count, *self.arguments)

    def energies(self):
        return self.body.energies(self.arguments[1], self.h)


def library_in_c(folder, source="step", compiler="cc"):
    """A source in C, compiled into a folder and loaded."""
    path = Path(folder) / f"{source}.so"
    subprocess.run([compiler, "-O3", "-march=native", "-mprefer-vector-width=256", "-shared", "-fPIC", "-o", path,
                    FOLDER / f"{source}.c"], check=True)
    library = ctypes.CDLL(str(path))
    library.new_body.restype = ctypes.c_void_p
    library.particles_of.restype = ctypes.POINTER(ctypes.c_double)
    return library
