"""Estimates of errors, and what they are of: each column lies within its estimate of the truth, or has none."""

import numpy as np
import pytest

TIP = {"K_I": 556149.0, "K_II": -70536.0, "J": 1.4299}  # an edge crack in a plate, by an integral equation
BEAMS = 45.635             # what the two beams release, by beam theory
BEAM_AT_REST = 1.28737     # J/G_ref of the double cantilever beam, converged


def last(row):
    """The last values of the columns."""
    return {name: values[-1] for name, values in row.items()}


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_tip_just_before_a_grid_line(case, text_of, mirrored):
    """Where the cut ended at an edge with a node behind the tip, both faces shared that node, and the crack was a cell too short."""
    text = text_of("tip_before_grid_line")
    if mirrored:
        text = text.replace("0.0041216, -0.0021543, 3.2e-06", "-0.0041216, -0.0021543, -3.2e-06")
    row = last(case("tip_before_grid_line", text=text).row)
    for column, known in TIP.items():
        known = -known if mirrored and column == "K_II" else known
        assert row[column] == pytest.approx(known, rel=2e-3), column
        assert abs(row[column] - known) <= row[column + "_error"], column
    assert row["G"] == pytest.approx(TIP["J"], rel=2.5e-3)


def test_the_parts_at_an_interface_sum_up_to_what_is_released(case, text_of):
    """Parts are works there, and one may be below 0, whichever way the faces move."""
    for text in (None, text_of("sign_of_mode_parts").replace("3e-3, 3e-3, 0.0", "-3e-3, -3e-3, 0.0")):
        row = last(case("sign_of_mode_parts", text=text).row)
        assert row["G_vcct_I"] + row["G_vcct_II"] == pytest.approx(BEAMS, rel=2e-3)
        assert row["J"] == pytest.approx(BEAMS, rel=2e-3)


def test_no_error_is_promised_where_material_yields(case):
    run = case("zero_error_promised", "--check")
    line = next(line for line in run.stdout.splitlines() if "expected error" in line)
    assert "%" not in line and "not known" in line


def test_the_vcct_among_cells_divided_in_motion(case, text_of):
    """It is off by 7 %: within what it differs by from J, and without J nothing is said of it. The progress line shows G, by J."""
    text = text_of("error_bar_gradient_refinement").replace("cell = 1.25e-3  cells = 80, 9", "cell = 2.5e-3  cells = 40, 5").replace(
        "interval = 2000", "interval = 400  max_level = 2").replace("start = 1.5e-3", "start = 1.2e-3").replace("end_time = 3.5e-3", "end_time = 1.8e-3")
    row = last(case("error_bar_gradient_refinement", text=text).row)
    assert row["tip_cell"] < 2e-3
    known = BEAM_AT_REST * 12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3)
    assert abs(row["G_vcct_I"] - known) <= row["G_vcct_I_error"] + row["J_error"]
    assert row["G"] == row["J"]
    alone = last(case("error_bar_gradient_refinement", text=text.replace("'stress_closure', 'vcct', 'domain_integral'", "'vcct'")).row)
    assert np.isnan(alone["G_vcct_I_error"]) and np.isnan(alone["G_error"])


@pytest.mark.parametrize(("poisson", "tip", "length", "load", "most"), [(0.49, "13.0, 10.0", 6.0, "shear", 2), (0.3, "17.0, 6.0", 10.0, "pull", 3)], ids=["nearly incompressible", "hardly there"])
def test_the_error_of_mode_II_of_a_centre_crack(case, poisson, tip, length, load, most):
    """Of a body that only tractions load K does not depend on Poisson's ratio: quadratic cells in plane stress know it. VCCT was taken to lack of mode II in nearly incompressible cells
    as much more as of mode I, a third of it, and of a mode that is hardly there what it lacks of the other: estimates were 0.9 and 0.4 of the error."""
    def row_of(name, keys, order, more):
        fx, fy = (100.0, 0.0) if load == "shear" else (0.0, 100.0)
        edges = f"""\
&load kind = 'traction'  lower = 0.0, 20.0  upper = 20.0, 20.0  force = {fx}, {fy} /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 20.0, 0.0  force = {-fx}, {-fy} /
"""
        if load == "shear":
            edges += """\
&load kind = 'traction'  lower = 20.0, 0.0  upper = 20.0, 20.0  force = 0.0, 100.0 /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 20.0  force = 0.0, -100.0 /
"""
        return last(case(name, text=f"""\
&run {keys[0]}  end_time = 1.0 /
&grid lower = -1.0, -1.0  cell = 1.0  cells = 22, 22  order = {order} /
&material name = 'm'  young = 1e6  poisson = {keys[1]}  density = 1000.0 /
&body material = 'm'  lower = 0.0, 0.0  upper = 20.0, 20.0  points_per_cell = {order + 1} /
&crack kind = 'line'  tip = {tip}  direction = 1.0, 0.0  length = {length} /
&method time = 'static' /
&energy_release estimators = 'domain_integral', 'vcct' /
{more}{edges}""").row)
    row = row_of("bilinear", ("plane = 'strain'", poisson), 1, "")
    known = row_of("quadratic", ("plane = 'stress'", 0.3), 2, "&refine indicator = 'tip'  max_level = 2  rings = 4 /\n")["K_II"]**2 / 1e6 * (1 - poisson**2)
    off = abs(abs(row["G_vcct_II"]) - known)
    assert off > 0.05 * known and off <= row["G_vcct_II_error"] <= most * off
