"""End-notched flexure and the end-loaded split of tests/benchmarks/laminates by finite elements of their own: writes flexure.csv beside this file.

Square elements with eight nodes; G is the change of energy as the crack grows by an edge to each side. Without friction the faces of ENF press within some mm of
the support alone: their normal displacement is tied there (tied over the whole crack, G is the same within 1e-6); those of ELS do not press. Half of what G
lacks is left by each halving of the elements. G of the fully sized problem: extrapolate."""

import csv
from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

COMPLIANCE = np.array([[1/140e9, -0.3/140e9, 0], [-0.3/140e9, 1/10e9, 0], [0, 0, 1/5e9]])   # plane stress, fibres along x
THICKNESS, DEPTH = 1e-3, 4e-3
CORNERS = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
SIDES = [(0, -1), (1, 0), (0, 1), (-1, 0)]
SIMPSON = (1/6, 4/6, 1/6)
# ends of the body, loads (from, to, edge, force), whether the right end is clamped, supports (x, direction) at the bottom, where faces press
ENF = (-5e-3, 105e-3), [(-0.5e-3, 0.5e-3, "bottom", 10.0), (99.5e-3, 100.5e-3, "bottom", 10.0), (49.5e-3, 50.5e-3, "top", -20.0)], False, \
    [(0.0, 0), (0.0, 1), (100e-3, 1)], 1.5e-3
ELS = (0.0, 80e-3), [(0.0, 0.0, "left", 5.0)], True, [], -1.0


def element_stiffness(edge):
    """Of a square element, in N/m: nodes at corners, then in the middle of sides, two directions each."""
    points, weights = np.polynomial.legendre.leggauss(3)
    total, elastic = np.zeros((16, 16)), np.linalg.inv(COMPLIANCE)
    for x, wx in zip(points, weights):
        for y, wy in zip(points, weights):
            slopes = [(a*(1 + b*y)*(2*a*x + b*y)/4, b*(1 + a*x)*(2*b*y + a*x)/4) for a, b in CORNERS]
            slopes += [(-x*(1 + b*y), b*(1 - x*x)/2) if a == 0 else (a*(1 - y*y)/2, -y*(1 + a*x)) for a, b in SIDES]
            strain = np.zeros((3, 16))
            for k, (along, up) in enumerate(np.array(slopes)*2/edge):
                strain[:, 2*k:2*k + 2] = [[along, 0], [0, up], [up, along]]
            total += wx*wy*strain.T@elastic@strain*edge**2/4*THICKNESS
    return total


def energy(crack, edge, specimen):
    """Half of the work of the loads [J] with a crack along the middle up to `crack`."""
    (left, right), loads, is_clamped, supports, presses = specimen
    nx, ny = round((right - left)/edge), round(DEPTH/edge)
    i, j = np.meshgrid(np.arange(2*nx + 1), np.arange(2*ny + 1), indexing="ij")
    is_node = (i % 2 == 0) | (j % 2 == 0)
    node = np.where(is_node, np.cumsum(is_node).reshape(is_node.shape) - 1, -1)
    open_columns = np.arange(2*round((crack - left)/edge))
    upper = is_node.sum() + open_columns
    dof = np.arange(2*(is_node.sum() + open_columns.size))
    pressed = np.abs(open_columns*edge/2 + left) <= presses
    dof[2*upper[pressed] + 1] = 2*node[open_columns[pressed], ny] + 1

    ex, ey = (side.ravel() for side in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    nodes = []
    for a, b in CORNERS + SIDES:
        column, row = 2*ex + 1 + a, 2*ey + 1 + b
        above = (row == ny) & (2*ey >= ny) & (column < open_columns.size)
        nodes.append(np.where(above, is_node.sum() + column, node[column, row]))
    nodes = np.array(nodes).T
    dofs = dof[np.stack([2*nodes, 2*nodes + 1], axis=2).reshape(-1, 16)]
    stiffness = sparse.csr_matrix((np.tile(element_stiffness(edge).ravel(), ex.size), (np.repeat(dofs, 16, axis=1).ravel(), np.tile(dofs, 16).ravel())), shape=(dof.size,)*2)

    force = np.zeros(dof.size)
    for start, end, side, load in loads:
        if side == "left":
            for row in range(0, 2*ny, 2):
                for k in range(3):
                    at = upper[0] if row + k == ny and row >= ny else node[0, row + k]
                    force[dof[2*at + 1]] += load/ny*SIMPSON[k]
        else:
            first, last = (2*round((x - left)/edge) for x in (start, end))
            for column in range(first, last, 2):
                for k in range(3):
                    force[2*node[column + k, -1 if side == "top" else 0] + 1] += 2*load/(last - first)*SIMPSON[k]
    held = [2*node[2*round((x - left)/edge), 0] + d for x, d in supports]
    if is_clamped:
        held += [2*n + d for n in node[-1, :] if n >= 0 for d in (0, 1)]
    free = np.setdiff1d(np.unique(dof), held)
    return force[free]@spsolve(stiffness[free][:, free].tocsc(), force[free])/2


def release_rate(crack, edge, specimen):
    """G [J/m2]."""
    return (energy(crack + edge, edge, specimen) - energy(crack - edge, edge, specimen))/(2*edge*THICKNESS)


def main():
    cases = [("G_ENF_25", 25e-3, ENF), ("G_ENF_30", 30e-3, ENF), ("G_ELS_40", 40e-3, ELS), ("G_ELS_50", 50e-3, ELS)]
    with open(Path(__file__).with_name("flexure.csv"), "w", newline="", encoding="utf-8") as file:
        file.write("# models of tests/benchmarks/laminates by flexure.py: eight-node elements, change of energy [J/m2]\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["cell_mm", *(name for name, *_ in cases)])
        for edge in (0.5, 0.25, 0.125):
            writer.writerow([edge, *(f"{release_rate(crack, edge*1e-3, specimen):.3f}" for _, crack, specimen in cases)])


if __name__ == "__main__":
    main()
