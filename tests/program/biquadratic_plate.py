"""Linear finite elements for half of a symmetric plate in plane stress, independent of hampm: biquadratic rectangles of a graded lattice, scipy's direct solver."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

GAUSS = np.polynomial.legendre.leggauss(3)


def functions(x):
    """The quadratic functions of -1, 0 and 1 and their derivatives."""
    return np.array([x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2]), np.array([x - 0.5, -2 * x, x + 0.5])


def stiffness(a, b, young, poisson):
    """Of a rectangle a by b; its nodes row by row, two components each."""
    law = young / (1 - poisson**2) * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    k = np.zeros((18, 18))
    for x, wx in zip(*GAUSS):
        for y, wy in zip(*GAUSS):
            (nx, dx), (ny, dy) = functions(x), functions(y)
            gx, gy = np.outer(ny, dx).ravel() * 2 / a, np.outer(dy, nx).ravel() * 2 / b
            strain = np.zeros((3, 18))
            strain[0, 0::2], strain[1, 1::2], strain[2, 0::2], strain[2, 1::2] = gx, gy, gy, gx
            k += wx * wy * a * b / 4 * strain.T @ law @ strain
    return k


def bent_beam(x, y, crack, load, young, poisson):
    """Compliance of a beam of unit thickness bent at three points [m/N]: the right half by symmetry, its lattice lines `x` from 0 and `y`, a crack from (0, 0) up to (0, `crack`), and
    a `load`: half the width of the patch in the middle of the top and the ends of that on the support, on lattice lines each. The displacement is the mean over the first less that
    over the second."""
    n, m = len(x) - 1, len(y) - 1
    columns, rows = 2 * n + 1, 2 * m + 1
    at = [(2 * j + q) * columns + 2 * i + p for j in range(m) for i in range(n) for q in range(3) for p in range(3)]
    nodes = np.reshape(at, (-1, 9))
    dofs = (2 * nodes[:, :, None] + np.arange(2)).reshape(len(nodes), 18)
    sizes = [(a, b) for b in np.diff(y) for a in np.diff(x)]
    values = np.array([stiffness(a, b, young, poisson) for a, b in sizes])
    shape = 2 * columns * rows
    k = coo_matrix((values.ravel(), (np.repeat(dofs, 18, axis=1).ravel(), np.tile(dofs, (1, 18)).ravel())), (shape, shape)).tocsr()

    def patch(row, first, last):
        """Parts of a force, spread evenly from `first` to `last`, that nodes of a row take."""
        part = np.zeros(shape)
        for i in range(n):
            if first - 1e-9 < x[i] and x[i + 1] < last + 1e-9:
                part[2 * (row * columns + 2 * i + np.arange(3)) + 1] += np.array([1, 4, 1]) / 6 * (x[i + 1] - x[i]) / (last - first)
        assert abs(part.sum() - 1) < 1e-9
        return part

    top, support = patch(rows - 1, 0.0, load[0]), patch(0, load[1], load[2])
    heights = np.interp(np.arange(rows) / 2, np.arange(m + 1), y)
    held = [2 * j * columns for j in range(rows) if heights[j] >= crack - 1e-9]
    held.append(2 * (rows // 2 * columns + columns - 1) + 1)            # one node against rising; the loads are in balance
    free = np.setdiff1d(np.arange(shape), held)
    u = np.zeros(shape)
    u[free] = spsolve(k[free][:, free].tocsc(), (0.5 * support - 0.5 * top)[free])
    return float(support @ u - top @ u)
