"""The plain scene of `bench_step` for those who compute the same motion by other means (plain_scene.f90)."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
CELL, YOUNG, DENSITY, POISSON = 1e-3, 70e9, 2700.0, 0.3


class Body:
    """The particles of the plain scene, four a cell in the order of the cells, plane stress."""

    def __init__(self, cells):
        columns, rows = np.meshgrid(np.arange(cells), np.arange(cells))
        corners = np.stack([columns.ravel(), rows.ravel()], axis=1)
        places = np.array([[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]])
        self.x = ((corners[:, None, :] + places) * CELL).reshape(-1, 2)
        self.v = 1e-3 * np.sin(200 * self.x)
        self.n, self.cells = len(self.x), cells
        self.volume = np.full(self.n, CELL**2 / 4)
        self.mass = DENSITY * self.volume
        self.mu = YOUNG / 2 / (1 + POISSON)
        self.lam = YOUNG * POISSON / (1 - POISSON**2)
        self.dt = 0.1 * CELL / np.sqrt(self.mu / DENSITY)

    def energies(self, v, h):
        """Kinetic and strain energy [J] of velocities and of displacement gradients as 11, 12, 21, 22 in any order of the particles, which
        are all alike."""
        strain = self.lam / 2 * (h[:, 0] + h[:, 3])**2 + self.mu * (h[:, 0]**2 + h[:, 3]**2 + (h[:, 1] + h[:, 2])**2 / 2)
        return self.mass[0] / 2 * np.sum(v**2), self.volume[0] * np.sum(strain)


class InC:
    """Steps by element_step.c."""

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


def library_in_c(folder, compiler="cc"):
    """The source in C, compiled into a folder and loaded."""
    path = Path(folder) / "element_step.so"
    subprocess.run([compiler, "-O3", "-march=native", "-mprefer-vector-width=256", "-shared", "-fPIC", "-o", path,
                    FOLDER / "element_step.c"], check=True)
    library = ctypes.CDLL(str(path))
    library.new_body.restype = ctypes.c_void_p
    library.particles_of.restype = ctypes.POINTER(ctypes.c_double)
    return library
