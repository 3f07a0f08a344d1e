"""The program and finite elements say the same of random static scenes, within both errors, but for what is known."""

import sys

import pytest

from paths import PROGRAM, ROOT

pytest.importorskip("ngsolve")
sys.path.insert(0, str(ROOT / "tests/second_opinion"))

from judge import judge  # noqa: E402
from opinion_compare import table  # noqa: E402
from opinion_scene import Outside, read  # noqa: E402
from trial import Trial  # noqa: E402

PARTS, SCENES = 10, 60    # that are drawn, of which about a half are judged
AGREE = 0.85              # of the quantities with an estimated error: bars held for 0.93 of 292 of the seeds 4 and 5
PLATE = """\
&run plane = 'strain'  thickness = 0.01  end_time = 1.0 /
&grid lower = -0.001, -0.001  cell = 0.001  cells = 22, 42 /
&material name = 'm'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'm'  lower = 0.0, 0.0  upper = 0.02, 0.04 /
&constraint lower = 0.0, 0.0  upper = 0.02, 0.0  fix = 'xy'  name = 'foot' /
&load kind = 'traction'  lower = 0.0, 0.04  upper = 0.02, 0.04  force = 20.0, 100.0 /
&method time = 'static' /
&refine indicator = 'tip'  max_level = 2  rings = 6 /
&energy_release estimators = 'domain_integral' /
"""
CRACKS = {"inner": "&crack kind = 'path'  points = 0.0081, 0.0183, 0.0137, 0.0212 /\n", "edge": "&crack kind = 'path'  points = 0.0, 0.0197, 0.0076, 0.0213 /\n",
          "pressed": "&crack kind = 'path'  points = 0.0081, 0.0183, 0.0137, 0.0212 /\n&load kind = 'pressure'  on = 'crack'  pressure = 1e6 /\n"}


def test_of_two_supports_of_the_same_nodes_the_last_one_holds(tmp_path):
    """Which also moves them once: reactions, work and displacements."""
    path = tmp_path / "model.nml"
    again = "&constraint lower = 0.0, 0.0  upper = 0.02, 0.0  fix = 'xy'  name = '{}'  displacement = 0.0, 1e-6 /\n&constraint lower = 0.0, 0.04  upper = 0.02, 0.04  fix = 'xy'  name = 'top' /\n"
    text = "".join(line for line in PLATE.splitlines(keepends=True) if not line.startswith(("&constraint", "&load", "&refine")))
    path.write_text(text.replace("estimators = 'domain_integral'", "estimators =") + again.format("foot") + again.format("last").splitlines(keepends=True)[0])
    rows = {row.column: row for row in judge(path, 3, PROGRAM)[0]}
    assert {"reaction_foot_y", "reaction_last_y", "external_work"} <= set(rows)
    assert all(row.verdict == "agree" for row in rows.values())
    assert rows["reaction_foot_y"].own == 0 and abs(rows["reaction_last_y"].own) > 1


@pytest.mark.parametrize("lower, upper, judged", [((0.0, 0.0), (0.0, 0.01), False), ((0.0, 0.0), (0.02, 0.0), True)])
def test_a_support_along_an_axis_is_not_judged(lower, upper, judged, tmp_path):
    """A line holds no area there: finite elements of any order have a reaction of their own."""
    path = tmp_path / "model.nml"
    ring = PLATE.replace("plane = 'strain'  thickness = 0.01", "plane = 'axisymmetric'").replace("lower = -0.001, -0.001", "lower = 0.0, -0.001")
    path.write_text(ring.replace("lower = 0.0, 0.0  upper = 0.02, 0.0  fix", f"lower = {lower[0]}, {lower[1]}  upper = {upper[0]}, {upper[1]}  fix"))
    if judged:
        read(path)
    else:
        with pytest.raises(Outside, match="has no area"):
            read(path)


def test_a_value_that_two_sizes_of_cells_share_by_chance():
    """Energies of a model with three slanted cracks, whose first two sizes differ by 0.26 % as its error is 2.5 %: a third size tells. Both sizes tell the same of first order."""
    found = {"strain_energy": ("energy", 7.591, 0.001, 7.591, 0.0), "stress": ("stress", 1.0, 0.0, 0.0, 0.0)}
    row = {"strain_energy": 7.4087, "stress": 1.4}
    verdicts = [[one.verdict for one in table(found, row, finer)] for finer in ({2: {"strain_energy": 7.4277}}, {2: {"strain_energy": 7.4277}, 4: {"strain_energy": 7.57245}})]
    assert verdicts == [["disagree"], ["agree"]]
    bars = [table(found, row, {times: {"stress": 1 + 0.4 / times}})[0].program_error for times in (2, 4)]
    assert bars == pytest.approx([0.6, 0.6])
    assert table(found, row, {}) == []


def test_totals_tell_how_many_models_stand_behind_values():
    """Three of four values that one model misses are one model of two."""
    trial = Trial(PROGRAM, 3, print)
    trial.barred["several cracks", "J"] = [(2.0, (7, 1))] * 3 + [(0.5, (7, 2))]
    assert "| several cracks: J, G | 4 | 2 | 25% | 50% | 0.5 |" in trial.totals().splitlines()


@pytest.mark.parametrize("crack", ["inner", *(pytest.param(name, marks=pytest.mark.verify) for name in CRACKS if name != "inner")])
def test_a_cracked_plate(crack, tmp_path):
    """K, G, J, energy, work and reactions, as both find them."""
    path = tmp_path / "model.nml"
    path.write_text(PLATE + CRACKS[crack])
    rows, unknown, _, _ = judge(path, 3, PROGRAM)
    assert not unknown and {"K_I", "K_II", "J", "G", "strain_energy", "external_work", "reaction_foot_y"} <= {row.column for row in rows}
    assert [row.column for row in rows if row.verdict != "agree"] == []


@pytest.mark.verify
@pytest.mark.parametrize("part", range(PARTS))
def test_random_scenes(part):
    """Of all that have an estimated error it holds for nearly all."""
    trial = Trial(PROGRAM, 3, print)
    for number in range(part * SCENES, (part + 1) * SCENES):
        trial.case(7, number)
    print(trial.totals())
    assert trial.ends["judged"] >= SCENES / 4
    barred = [row for _, _, row, _ in trial.faults if row.has_bar]
    judged = sum(count for (kind, _), count in trial.kinds.items() if kind in ("J", "G", "K_I", "K_II") or kind.startswith("G_"))
    assert len(barred) <= (1 - AGREE) * judged
