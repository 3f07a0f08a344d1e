"""What equation (14) of Tan & Nairn needs to be right: with the tractions that balance the reactions of the constraint through the consistent
mass matrix of the line ahead of the crack it is virtual crack closure (VCCT), and so as near to G as that is.

The reactions of the nodes are those of constraints, one a node, which do not look at the crack; the line's mass matrix is made here.
"""

import h5py
import numpy as np
import pytest

from paths import INPUT

ARM, TIP, END, THICKNESS = 10e-3, 50e-3, 100e-3, 10e-3
CONVERGED = 1.28737  # G/G_ref, tests/reference/dcb_static.csv


def scene(text, nodes):
    """The double cantilever beam of input/dcb.nml with a constraint of its own for each node ahead of the crack."""
    start = text.index("&constraint")
    end = text.index("\n/", start) + 3
    held = "".join(f"&constraint\n   lower = {x!r}, 0.0\n   upper = {x!r}, 0.0\n   fix = 'y'\n   name = 'n{k}'\n/\n" for k, x in enumerate(nodes))
    return text[:start] + held + text[end:]


def line_mass(number, cell):
    """The consistent mass matrix of a line of linear elements, per density: integrals of N_i N_j over the area [m2]."""
    element = cell * THICKNESS / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
    mass = np.zeros((number, number))
    for k in range(number - 1):
        mass[k:k + 2, k:k + 2] += element
    return mass


@pytest.fixture(scope="module", params=[5e-3, 2.5e-3, 1.25e-3], ids=["5 mm", "2.5 mm", "1.25 mm"])
def beam(request, run_hampm, tmp_path_factory):
    """Cell, reactions of the nodes ahead of the crack [N], columns and attributes at rest."""
    folder, cell = tmp_path_factory.mktemp("beam"), request.param
    nodes = [float(x) for x in np.linspace(TIP, END, round((END - TIP) / cell) + 1)]
    (folder / "beam.nml").write_text(scene((INPUT / "dcb.nml").read_text(), nodes))
    settings = [f"grid.cell={cell}", f"grid.cells={round(END / cell)},{round(ARM / cell) + 1}", "method.time=static", "method.frame=total",
                "method.courant=0", "output.snapshot_interval=0", "output.file=out.h5",
                "energy_release.estimators='vcct','stress_closure'"]
    result = run_hampm("beam.nml", *[word for item in settings for word in ("--set", item)], cwd=folder)
    assert result.returncode == 0, result.stderr
    with h5py.File(folder / "out.h5") as file:
        columns = {name: values[-1] for name, values in file["history"].items()} | dict(file["history"].attrs)
    return cell, np.array([columns[f"reaction_n{k}_y"] for k in range(len(nodes))]), columns


def tractions(reactions, cell):
    """Nodal tractions that balance the reactions, which act on the body against the stress [Pa]."""
    return np.linalg.solve(line_mass(reactions.size, cell), -reactions)


def test_the_force_at_the_tip_is_that_of_the_tractions(beam):
    """F = B da (2 sigma(2) + sigma(3))/6."""
    cell, reactions, _ = beam
    sigma = tractions(reactions, cell)
    assert THICKNESS * cell * (2 * sigma[0] + sigma[1]) / 6 == pytest.approx(-reactions[0], rel=1e-12)
    assert np.sum(line_mass(reactions.size, cell) @ sigma) == pytest.approx(-np.sum(reactions), rel=1e-12)


def test_equation_14_with_these_tractions_is_virtual_crack_closure(beam):
    cell, reactions, columns = beam
    sigma = tractions(reactions, cell)
    g = columns["crack_opening"] / 2 * (2 * sigma[0] + sigma[1]) / 6
    assert g == pytest.approx(columns["G_vcct_I"], rel=1e-9)
    assert g / columns["G_ref"] == pytest.approx(CONVERGED, rel=0.07 * cell / 5e-3)


def test_equation_14_with_stress_smoothed_from_particles_is_not(beam):
    """A third of G with the lumped mass matrix, and no nearer on finer cells."""
    _, _, columns = beam
    assert 0.2 < columns["G_stress_closure_I"] / columns["G_ref"] / CONVERGED < 0.35


@pytest.mark.parametrize("points, refined", [(2, False), (3, False), (2, True), (4, True)])
def test_the_ratio_of_both_mass_matrices_is_not_that_of_the_paper(run_hampm, tmp_path, points, refined):
    """Lumped over consistent by (14): factors, reference values and loads cancel in it. The paper's errors, of either sign, need 0.67 or more on regular
    cells (24 and 14 %), and 0.94 on adaptive ones (5 and 1 %)."""
    g = []
    for mass in ("lumped", "consistent"):
        settings = [f"method.mass={mass}", "method.time=static", "method.frame=total", "method.courant=0", "output.snapshot_interval=0",
                    f"body.points_per_cell={points}", "grid.cell=2.5e-3", "grid.cells=40,5", "output.file=out.h5",
                    "energy_release.estimators='stress_closure'", *["refine.indicator=tip", "refine.max_level=2"] * refined]
        result = run_hampm(INPUT / "dcb.nml", "--force", *[word for item in settings for word in ("--set", item)], cwd=tmp_path)
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / "out.h5") as file:
            g.append(file["history/G_stress_closure_I"][-1])
    print(g[0] / g[1])
    assert (0.49 if refined else 0.31) < g[0] / g[1] < 0.65
    assert g[0] / g[1] < ((1 - 0.05) / (1 + 0.01) if refined else (1 - 0.24) / (1 + 0.14))


def test_the_tractions_are_no_stress_of_particles(beam):
    """They alternate: the line's inverse mass matrix makes that of the tip larger than the mean force on its cell, and of the next smaller."""
    cell, reactions, _ = beam
    sigma = tractions(reactions, cell)
    print(sigma[:4] * THICKNESS * cell / -reactions[0])
    assert sigma[0] > 2 * -reactions[0] / (THICKNESS * cell)
    assert sigma[1] < sigma[0] / 2


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
def test_equation_14_on_quadratic_cells_tends_to_more_of_g(run_hampm, tmp_path, mass):
    """Fields near the tip look alike at any size of cells: the part of J that is found settles as the cell, to the first order."""
    parts = []
    for k in (1, 2, 4):
        settings = [f"method.mass={mass}", "method.solver=direct", "method.time=static", "method.frame=total", "method.courant=0", "output.snapshot_interval=0",
                    "body.points_per_cell=3", "grid.order=2", f"grid.cell={2.5e-3 / k}", f"grid.cells={40 * k},{4 * k + 1}", "output.file=out.h5",
                    "energy_release.estimators='stress_closure','domain_integral'"]
        result = run_hampm(INPUT / "dcb.nml", "--force", *[word for item in settings for word in ("--set", item)], cwd=tmp_path)
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / "out.h5") as file:
            parts.append(file["history/G_stress_closure_I"][-1] / file["history/J"][-1])
    order = np.log2((parts[1] - parts[0]) / (parts[2] - parts[1]))
    print(parts, order)
    assert 0.8 < order < 1.4
    assert parts[-1] > (0.65 if mass == "lumped" else 0.74)
