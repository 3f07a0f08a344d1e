"""Faces and bodies that press on each other."""

import pytest


def words(text):
    """A text with one blank between its words."""
    return " ".join(text.split())


@pytest.mark.parametrize("name, indicator", [("friction_zz_motion", "zz"), ("friction_zz_static", "zz"), ("friction_zz_static", "gradient")])
def test_friction_on_a_mesh_that_changes_is_refused(case, text_of, name, indicator):
    """A new mesh forgets how far faces have slid: K_II came out with the wrong sign, the friction loss fell."""
    text = text_of(name).replace("indicator='zz'", f"indicator='{indicator}'")
    run = case(name, "--check", text=text)
    assert run.code == 2
    assert "&crack contact" in run.stderr and f"'{indicator}'" in run.stderr and "forget" in run.stderr and "'tip'" in run.stderr


def test_friction_goes_with_cells_that_stay(case):
    """Cells refined at the tips do not change in the run."""
    run = case("friction_zz_static", "--check", "--set", "refine.indicator=tip")
    assert run.code == 0, run.stderr


def test_meeting_bodies_know_no_unit_of_length(case):
    """Lengths and times 200 times those of another scene, young and density the same: energies are 200**3 times those."""
    reference = case("contact_unit_reference", "--set", "run.end_time=0.06")
    large = case("contact_unit_of_length", "--set", "run.end_time=12.0")
    assert reference.code == large.code == 0
    for column in "contact_loss", "kinetic_energy", "strain_energy":
        assert large.row[column][-1] == pytest.approx(200**3*reference.row[column][-1], rel=1e-9), column
    assert reference.row["contact_loss"][-1] == pytest.approx(0.0295352, rel=1e-5)


def test_faces_that_overlap_are_told_by_the_name_of_their_crack(case, text_of):
    """Contact of one crack says nothing about another, whichever comes first."""
    text = text_of("overlap_of_second_crack")
    run = case("overlap_of_second_crack", text=text)
    assert run.code == 0
    assert "the faces of the crack 'b' have gone through each other" in words(run.stderr)
    assert "crack 'a'" not in words(run.stderr)
    unnamed = case("overlap_of_second_crack", text=text.replace("contact='frictionless' name='a'", "contact='frictionless'").replace("  name='b'", ""))
    assert "the faces of the crack number 2 have gone through each other" in words(unnamed.stderr)
    both = case("overlap_of_second_crack", text=text.replace("contact='frictionless' ", ""))
    assert all(f"the faces of the crack '{name}' have gone through" in words(both.stderr) for name in "ab")


@pytest.mark.parametrize("indicator, friction", [("none", 0.4), ("tip", 0.2), ("none", 1.5)])
def test_friction_finds_equilibrium(case, text_of, indicator, friction):
    """Faces of a kinked crack into a hole stick, slide and part: what the load does is stored or rubbed away. Forces grew by ten in each iteration."""
    refused = case("fpe_diverged_friction")
    assert refused.code == 2 and "'zz'" in refused.stderr
    run = case("fpe_diverged_friction", "--set", f"refine.indicator={indicator}", "--set", f"crack.friction={friction}")
    assert run.code == 0, run.stderr
    work, stored, lost = (run.row[name][-1] for name in ("external_work", "strain_energy", "friction_loss"))
    assert work == pytest.approx(stored + lost, rel=1e-6)
    assert 1.43 < work < 1.51                              # of a crack that sticks, and of one without friction
