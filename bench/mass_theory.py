"""The critical time step of a mass matrix and a scheme, from the matrices of a small body that stays where it is.

In cells of size 1, density 1 and dilatational wave speed 1, a time step is a courant number. With the particles' shape
functions S, their masses m, M = S^T m S, its row sums D, the stiffness K of the particles and the matrix A that the run
takes for the inverse of M (D^-1, a series, or the inverse of a consistent, partial or weighted matrix), a step changes the
nodal momentum p = S^T m v and the sum u of the strain displacements by

    p <- p - dt M A K u,    u <- u + dt w,

with w = A p from before or after the change of p: `usf`, `musl` and `usavg` are leapfrog schemes of omega^2 = A M A K,
with the limit omega dt = 2. `usl` strains with w = A p - dt A K u instead. Momentum is mapped to the grid and back, and so
the squared frequency carries the factor M A, which is 1 for the consistent matrix only.
"""

import numpy as np

FLOOR = {1: 0.05, 2: 0.02}  # least eigenvalue of D^-1 M of a cell of each order that is used as it is, see src/element/mass_matrix.f90


def functions(order, a):
    """The shape functions of a cell in one direction, at the coordinate a from 0 to 1, and their derivatives."""
    if order == 1:
        return np.array([1 - a, a]), np.array([-1.0, 1.0])
    return np.array([(1 - a) * (1 - 2 * a), 4 * a * (1 - a), a * (2 * a - 1)]), np.array([4 * a - 3, 4 - 8 * a, 4 * a - 1])


def weights(order, points):
    """Parts of a cell that its particles stand for, along one direction: of quadratic cells those nearest to equal ones that integrate
    1, a and a^2 exactly."""
    equal = np.full(points, 1 / points)
    if order == 1:
        return equal
    a = (np.arange(points) + 0.5) / points
    powers = np.array([a**0, a, a**2])
    return equal + np.linalg.pinv(powers) @ ([1, 1 / 2, 1 / 3] - powers @ equal)


class Block:
    """A block of nx x ny cells with particles on a lattice, shifted by part of a cell against that of the cells.

    poisson     plane strain; with 0 also plane stress
    held_left   whether both components are held on the line x = 0
    held_y      whether the y component is held everywhere
    order       1: bilinear cells; 2: biquadratic ones of nine nodes, without a shift
    points      particles of a cell in each direction
    """

    def __init__(self, nx, ny, poisson, shift=(0.0, 0.0), held_left=True, held_y=False, order=1, points=2):
        rows = order * (ny + (1 if shift[1] > 0 else 0)) + 1
        columns = order * (nx + (1 if shift[0] > 0 else 0)) + 1
        n = rows * columns
        self.floor = FLOOR[order]
        part, each = weights(order, points), (order + 1) ** 2
        modulus = poisson / (1 - poisson)
        shear = (1 - 2 * poisson) / (2 - 2 * poisson)
        elastic = np.array([[1, modulus, 0], [modulus, 1, 0], [0, 0, shear]])
        self.middles, cells = [], {}
        stiffness = np.zeros((2 * n, 2 * n))
        for k, x in enumerate((np.arange(nx * points) + 0.5) / points + shift[0]):
            for m, y in enumerate((np.arange(ny * points) + 0.5) / points + shift[1]):
                weight = part[k % points] * part[m % points]
                i, j = int(x), int(y)
                (along, slope), (across, rise) = functions(order, x - i), functions(order, y - j)
                nodes = [(order * j + b) * columns + order * i + a for b in range(order + 1) for a in range(order + 1)]
                shape, dx, dy = np.outer(across, along).ravel(), np.outer(across, slope).ravel(), np.outer(rise, along).ravel()
                strain = np.zeros((3, 2 * each))
                strain[0, :each], strain[1, each:], strain[2, :each], strain[2, each:] = dx, dy, dy, dx
                both = np.array(nodes + [node + n for node in nodes])
                stiffness[np.ix_(both, both)] += weight * strain.T @ elastic @ strain
                cell = cells.setdefault((i, j), (nodes, np.zeros((each, each))))
                cell[1][:] += weight * np.outer(shape, shape)
        self.n, self.cells, self.middle = n, cells, nx / 2
        x = np.tile(np.arange(columns), rows)
        used = np.zeros(n, dtype=bool)
        for nodes, _ in cells.values():
            used[nodes] = True
        left = (x == 0) if held_left else np.zeros(n, dtype=bool)
        self.free = [np.flatnonzero(used & ~left), np.flatnonzero(used & ~left & (not held_y))]
        both = np.concatenate([self.free[0], self.free[1] + n])
        self.stiffness = stiffness[np.ix_(both, both)]
        self.mass = self._both(self._assembled(lambda cell, part: cell[1]))
        self.lumped = self._both(self._assembled(lambda cell, part: np.diag(cell[1].sum(axis=1))))

    def _assembled(self, matrix):
        total = np.zeros((self.n, self.n))
        for part, cell in self.cells.items():
            total[np.ix_(cell[0], cell[0])] += matrix(cell, part)
        return total

    def _both(self, matrix):
        """A nodal matrix for the free x components, then the free y components."""
        first, second = (matrix[np.ix_(free, free)] for free in self.free)
        zero = np.zeros((len(first), len(second)))
        return np.block([[first, zero], [zero.T, second]])

    def inverse(self, mass, order=2, lumped_fraction=0.5):
        """The matrix A of a kind of mass matrix; 'partial' is consistent in the left half."""
        if mass == "lumped":
            return np.linalg.inv(self.lumped)
        if mass == "fmpm":
            inverse = np.linalg.inv(self.lumped)
            rest = np.eye(len(inverse)) - inverse @ self.mass
            return sum(np.linalg.matrix_power(rest, k) for k in range(order)) @ inverse

        def prepared(cell, part):
            lumping = {"consistent": 0, "weighted": lumped_fraction, "partial": 0 if part[0] + 0.5 <= self.middle else 1}[mass]
            diagonal = np.diag(cell[1].sum(axis=1))
            matrix = (1 - lumping) * cell[1] + lumping * diagonal
            if np.linalg.eigvalsh(matrix - self.floor * diagonal)[0] <= 0:
                matrix = (1 - self.floor) * matrix + self.floor * diagonal
            return matrix

        return np.linalg.inv(self._both(self._assembled(prepared)))

    def limit(self, scheme, a):
        """Largest stable courant number (of the dilatational wave speed) of a scheme with the matrix A."""
        if scheme != "usl":
            return 2 / np.sqrt(np.linalg.eigvals(a @ self.mass @ a @ self.stiffness).real.max())
        low, high = 0.0, self.node_limit(a) * 2
        while high - low > 2e-4 * high:
            middle = (low + high) / 2
            low, high = (middle, high) if self._radius_of_usl(middle, a) < 1 + 1e-7 else (low, middle)
        return low

    def node_limit(self, a):
        """The limit of finite elements with the inverse mass matrix A: omega^2 = A K."""
        return 2 / np.sqrt(np.linalg.eigvals(a @ self.stiffness).real.max())

    def _radius_of_usl(self, dt, a):
        force = a @ self.stiffness
        eye = np.eye(len(a))
        step = np.block([[eye, -dt * self.mass @ force], [dt * a, eye - dt**2 * force]])
        return np.abs(np.linalg.eigvals(step)).max()
