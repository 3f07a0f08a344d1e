"""The mixed-mode bending specimen of input/laminate_mmb.nml by finite elements of its own: writes mmb.csv beside this file, in a minute.

Eight-node quadrilaterals with 3 x 3 points of integration, plane stress, nodes of both faces apart; G_I and G_II by the virtual crack closure
of quadratic elements (Krueger 2004, equation 6). Loads are uniform over 1 mm, as in the namelist. Needs scipy.
"""

import csv
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

E1, E2, G12, NU12 = 140e9, 10e9, 5e9, 0.3
LOWER, UPPER, HEIGHT, TIP, MIDDLE, WIDTH = -5e-3, 105e-3, 4e-3, 25e-3, 2e-3, 1e-3
# middle of the loaded millimetre, at the upper surface or not, force upwards [N]
LOADS = ((0.0, True, 7.2), (0.0, False, 0.4), (50e-3, True, -15.2), (100e-3, False, 7.6))
PLACES = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]])


def stiffness(cell):
    """Of an element with edges `cell`, (16, 16) [N/m]."""
    nu21 = NU12 * E2 / E1
    c = np.array([[E1, nu21 * E1, 0], [nu21 * E1, E2, 0], [0, 0, G12 * (1 - NU12 * nu21)]]) / (1 - NU12 * nu21)
    k = np.zeros((16, 16))
    for x, wx in zip(*np.polynomial.legendre.leggauss(3)):
        for y, wy in zip(*np.polynomial.legendre.leggauss(3)):
            g = np.empty((8, 2))
            for i, (a, b) in enumerate(PLACES):
                if a * b:
                    g[i] = a * (1 + b * y) * (2 * a * x + b * y) / 4, b * (1 + a * x) * (2 * b * y + a * x) / 4
                elif a == 0:
                    g[i] = -x * (1 + b * y), b * (1 - x * x) / 2
                else:
                    g[i] = a * (1 - y * y) / 2, -y * (1 + a * x)
            g *= 2 / cell
            b = np.zeros((3, 16))
            b[0, 0::2], b[1, 1::2], b[2, 0::2], b[2, 1::2] = g[:, 0], g[:, 1], g[:, 1], g[:, 0]
            k += wx * wy * cell**2 / 4 * WIDTH * b.T @ c @ b
    return k


def rates(cell):
    """G_I and G_II [J/m2]."""
    columns, rows = round((UPPER - LOWER) / cell), round(HEIGHT / cell)
    tip, middle = round((TIP - LOWER) / cell), rows // 2
    number = {}

    def node(x, y, above):                                   # in half cells
        on_face = y == 2 * middle and x < 2 * tip and above
        return number.setdefault((x, y, on_face), len(number))

    elements = np.array([[node(2 * i + 1 + a, 2 * j + 1 + b, j >= middle) for a, b in PLACES] for i in range(columns) for j in range(rows)])
    k = stiffness(cell)
    dof = (2 * elements[:, :, None] + np.arange(2)).reshape(len(elements), 16)
    matrix = coo_matrix((np.tile(k.ravel(), len(elements)), (np.repeat(dof, 16, axis=1).ravel(), np.tile(dof, (1, 16)).ravel()))).tocsc()
    force = np.zeros(2 * len(number))
    for place, at_top, value in LOADS:
        first, count = round((place - 0.5e-3 - LOWER) / cell), round(1e-3 / cell)
        for i in range(first, first + count):
            for x, part in ((2 * i, 1 / 6), (2 * i + 1, 2 / 3), (2 * i + 2, 1 / 6)):
                force[2 * number[x, 2 * rows if at_top else 0, False] + 1] += part * value / count
    assert abs(force.sum()) < 1e-9
    held = [2 * number[2 * tip, 0, False], 2 * number[2 * tip, 0, False] + 1, 2 * number[2 * columns, 0, False] + 1]
    free = np.setdiff1d(np.arange(len(force)), held)
    u = np.zeros_like(force)
    u[free] = splu(matrix[free][:, free]).solve(force[free])
    below = elements.reshape(columns, rows, 8)[:, middle - 1]
    pull = np.zeros_like(force)                              # of the lower half on the nodes of the line
    for e in below[tip - 1:tip + 1]:
        of_nodes = (2 * e[:, None] + np.arange(2)).ravel()
        pull[of_nodes] += k @ u[of_nodes]
    g = np.zeros(2)
    for ahead, behind in ((2 * tip, 2 * tip - 2), (2 * tip + 1, 2 * tip - 1)):
        n = number[ahead, 2 * middle, False]
        gap = [u[2 * number[behind, 2 * middle, True] + d] - u[2 * number[behind, 2 * middle, False] + d] for d in range(2)]
        g += [pull[2 * n + d] * gap[d] / (2 * WIDTH * cell) for d in (1, 0)]
    return g


if __name__ == "__main__":
    with open(Path(__file__).with_name("mmb.csv"), "w", newline="") as file:
        file.write("# input/laminate_mmb.nml by mmb.py: eight-node elements, virtual crack closure [J/m2]\n")
        table = csv.writer(file)
        table.writerow(["cell_mm", "G_I", "G_II"])
        for cell in (1e-3, 0.5e-3, 0.25e-3, 0.125e-3, 0.0625e-3):
            g = rates(cell)
            print(cell, g)
            table.writerow([f"{cell * 1e3:g}", *(f"{value:.3f}" for value in g)])
