"""Scenes in which a key does nothing, or a group is dropped: refused or warned of by name, from the table of rules."""

import re

import h5py
import pytest

HISTORIES = [("history_keys_ignored_table", ["&load times", "&load factors"], "history = 'table'"),
             ("history_keys_ignored_rise", ["&load rise_time"], "history = 'ramp' or 'smooth_ramp'"),
             ("history_keys_ignored_constraint", ["&constraint times", "&constraint factors"], "history = 'table'")]


@pytest.mark.parametrize(("name", "keys", "missing"), HISTORIES, ids=[row[0] for row in HISTORIES])
def test_keys_of_another_history_are_refused_with_the_one_that_is_missing(case, name, keys, missing):
    result = case(name)
    assert result.code == 2
    for key in keys:
        assert re.search(rf"{name}\.nml:\d+: {key} = [^=]* requires {re.escape(missing)}$", result.stderr, re.MULTILINE), result.stderr


@pytest.mark.parametrize(("key", "needed"), [("rise_time", "ramp"), ("frequency", "sine"), ("times", "table"), ("factors", "table")])
@pytest.mark.parametrize("history", ["step", "ramp", "sine", "table"])
def test_every_key_of_a_history_is_refused_with_every_other_history(case, text_of, key, needed, history):
    """In the second of two loads, which the message names by its number."""
    own = {"step": "", "ramp": "rise_time=1e-7", "sine": "frequency=1e6", "table": "times=0,1e-6 factors=0,1"}[history]
    extra = "" if key in own else f"{key}=1.0"
    load = re.search(r"&load.*", text_of("history_keys_ignored_rise"))[0]
    second = load.replace("rise_time=1e-7", f"history='{history}' {own} {extra}").replace("8e-3,8e-3 upper=8e-3,8e-3", "8e-3,-8e-3 upper=8e-3,-8e-3")
    text = text_of("history_keys_ignored_rise").replace(load, load.replace(" rise_time=1e-7", "") + "\n" + second)
    result = case("second", "--check", text=text)
    if needed == history:
        assert result.code == 0, result.stderr
    else:
        assert result.code == 2
        assert f"&load(2) {key} = 1.0 requires history = '{needed}'" in result.stderr
        assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize("second", ["kind='line' tip=0.0,3e-3", "kind='path' points=-9e-3,3.2e-3,0.0,3.3e-3", "kind='line' tip=0.0,3.3e-3 direction=1.0,0.1"])
def test_a_second_crack_of_any_kind_is_not_dropped(case, text_of, second):
    text = text_of("second_line_crack_dropped").replace("kind='line' tip=0.0,3e-3", second)
    result, alone = case("two", text=text), case("alone", text=text.replace(f"&crack {second} /\n", ""))
    assert result.code == alone.code == 0, result.stderr
    assert {"J", "J_tip2"} <= set(result.row)
    assert "J_tip2" not in alone.row


def test_a_crack_beside_one_on_a_symmetry_plane_is_refused(case, text_of):
    result = case("others", text=text_of("second_line_crack_dropped").replace("kind='line' tip=0.0,3e-3", "kind='symmetry' tip=0.0,-8e-3"))
    assert result.code == 2
    assert "&crack(2) kind = 'symmetry' is not allowed with several cracks" in result.stderr


def test_refinement_without_an_indicator(case):
    result = case("refine_without_indicator", "--check")
    assert result.code == 0
    assert "warning: &refine max_level = 3 has no effect without indicator = " in result.stderr
    assert "warning: &refine rings = 8 has no effect without indicator = 'tip'" in result.stderr


def test_what_is_printed_of_a_scene_has_no_key_without_effect(case, text_of):
    """`--check` prints every key with its value: those that are defaults say nothing."""
    text = text_of("refine_without_indicator").replace("&refine max_level=3 rings=8 /", "")
    printed = case("given", "--check", text=text)
    again = case("again", "--check", text=printed.stdout)
    assert printed.stderr == again.stderr == ""


@pytest.mark.parametrize("points", ["-8e-3,-8e-3,0.0,0.0,8e-3,8e-3", "-8e-3,-8e-3,0,0,8e-3,8e-3,2e-3,2e-3", "0,0,1e-3,1e-3,3e-3,3e-3,2e-3,2e-3",
                                    "-8e-3,1e-3,0,1e-3,8e-3,1e-3", "0,0,3e-4,1e-4,6e-4,2e-4", "0,0,8e-3,0,8e-3,1e-13"])
def test_a_polygon_without_an_area(case, text_of, points):
    text = text_of("body_without_area")
    result = case("body_without_area", "--check", text=text.replace("-8e-3,-8e-3,0.0,0.0,8e-3,8e-3", points))
    assert result.code == 2
    assert "&body points" in result.stderr
    assert case("body_without_area", "--check", text=text.replace("-8e-3,-8e-3,0.0,0.0,8e-3,8e-3", "-8e-3,-8e-3,0.0,0.5e-3,8e-3,8e-3")).code == 0


def test_a_material_that_no_body_is_of_is_not_asked(case, text_of):
    """The speed of Rayleigh waves in rubber is below that of this crack. The step, too, is that of the plate alone."""
    result = case("unused_material_asked", "--check")
    assert result.code == 0
    assert "&material 'rubber, in no body' has no effect without a body of it" in result.stderr
    text = re.sub(r"&material name='rubber.*\n", "", text_of("unused_material_asked"))
    alone = case("alone", "--check", text=text)
    assert alone.code == 0 and alone.stderr == ""
    steps = [re.search(r"^! time step.*", run.stdout, re.MULTILINE)[0] for run in (result, alone)]
    assert steps[0] == steps[1]


@pytest.mark.parametrize("other", ["law='j2_plastic' yield_stress=1e6", "law='orthotropic'", "law='viscoelastic'", "volumetric='b_bar'"])
def test_whatever_law_a_material_has_that_no_body_is_of(case, text_of, other):
    """Constants of its own that are missing are a mistake of the user, and told; what it does not go with is not."""
    text = text_of("unused_material_asked").replace("name='rubber, in no body'", f"name='other' {other}")
    result = case("other", "--check", text=text)
    if "j2" in other or "volumetric" in other:
        assert result.code == 0, result.stderr
    else:
        assert result.code == 2
        assert all("&material 'other'" in line for line in result.stderr.splitlines())


def test_the_reference_is_that_of_the_material_of_the_beam(case):
    """12 P2 a2/(E b2 h3) with P = 1 N, a = 50 mm, b = h = 10 mm and the modulus of the beam, 70 GPa, in plane stress."""
    result = case("reference_of_other_material")
    assert result.code == 0, result.stderr
    with h5py.File(result.path) as file:
        assert file["history"].attrs["G_ref"] == pytest.approx(12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3), rel=1e-12)
    assert "&material 'unused' has no effect without a body of it" in result.stderr


def test_advice_may_be_taken(case, text_of):
    """What would halve the error of a lumped mass matrix is advised, and is accepted where the edges move."""
    result = case("advice_that_is_refused", "--check", "--set", "grid.cell=0.5e-3", "--set", "grid.cells=64,34", "--set", "method.mass=lumped")
    assert result.code == 0, result.stderr
    assert "&method mass = 'lumped' with &growth law = 'toughness'" in result.stdout
    assert "weighted" in result.stdout.split("! note:")[1]
    assert case("taken", "--check", "--set", "method.mass=weighted", text=text_of("advice_that_is_refused")).code == 0


def test_advice_is_given_where_it_may_be_taken(case, text_of):
    loads = "&load kind = 'traction' lower = 0.0, 8e-3 upper = 32e-3, 8e-3 force = 0.0, 1.0 /\n&crack"
    text = re.sub(r"&constraint(?:.*\n){3}", "", text_of("advice_that_is_refused")).replace("&crack", loads)
    coarse = ("--set", "grid.cell=1e-3", "--set", "grid.cells=32,17")
    advised = case("advised", "--check", *coarse, "--set", "method.mass=lumped", text=text)
    assert advised.code == 0, advised.stderr
    assert "; use &method mass = 'weighted'" in advised.stdout
    assert case("taken", "--check", *coarse, "--set", "method.mass=weighted", text=text).code == 0


LATE = """\
&run end_time = 1e-6 /
&grid lower = -10e-3, -10e-3  cell = 1e-3  cells = 20, 20 /
&material name = 'm'  young = 100e9  poisson = 0.1  density = 5000.0 /
&body material = 'm'  lower = -8e-3, -8e-3  upper = 8e-3, 8e-3 /
&constraint lower = -8e-3, -8e-3  upper = 8e-3, -8e-3  fix = 'xy' /
&output history_interval = 1e-7 /
"""
LOAD = "&load kind = 'traction'  lower = -8e-3, 8e-3  upper = 8e-3, 8e-3  force = 0.0, 1e3"
PATH = "&crack kind = 'path'  points = -4e-3, -1e-3, 3.1e-3, 2.2e-3 /"


@pytest.mark.parametrize(("groups", "told"), [
    (f"{LOAD}  start = 2e-6 /", "&load 1: its history begins at 2.0e-6 s"),
    (f"{LOAD}  start = 1e-6 /", "&load 1: its history begins at 1.0e-6 s"),
    ("&constraint lower = -8e-3, 8e-3  upper = 8e-3, 8e-3  fix = 'y'  velocity = 0.0, 1.0  start = 2e-6 /", "&constraint 2: its history begins at 2.0e-6 s"),
    (f"{LOAD} /\n&refine indicator = 'zz'  start = 3e-6 /", "&refine: no cell refines: start is 3.0e-6 s"),
    (f"{LOAD} /\n&refine indicator = 'gradient'  r_crit = 0.1  interval = 100000 /", "no cell has refined: &refine interval = 100000 is more than"),
    (f"{LOAD} /\n{PATH}\n&refine indicator = 'tip'  region_lower = -8e-3, 6e-3  region_upper = -6e-3, 8e-3 /", "no cell has refined: there is none within &refine rings = 4"),
    (f"{PATH}\n&growth law = 'toughness'  toughness = 10.0  start = 2e-6 /\n&energy_release estimators = 'domain_integral' /", "&growth 1: no crack grows by it"),
    (f"{LOAD} /\n&crack kind = 'path'  points = -12e-3, 1e-3, 12e-3, 1.3e-3 /\n&energy_release estimators = 'domain_integral' /", "no end of a &crack is inside the material")],
    ids=["load", "load at the end", "constraint", "refine start", "refine interval", "refine region", "growth", "estimators without a tip"])
def test_what_never_acts_is_told(case, groups, told):
    """What begins after the end, or looks where or when there is nothing to see, did nothing without a word."""
    result = case("never", text=LATE + groups + "\n")
    assert result.code == 0 and told in result.stderr


@pytest.mark.parametrize("groups", [f"{LOAD}  start = 0.9e-6 /\n&refine indicator = 'zz'  max_level = 1  start = 0.5e-6  interval = 1 /",
                                    f"{LOAD}  start = 1e-6 /\n&method time = 'static' /"], ids=["in motion", "at rest"])
def test_what_acts_late_is_not_told(case, groups):
    for options in ([], ["--check"]):
        result = case("late", *options, text=LATE.replace("&output history_interval = 1e-7 /\n", "") + groups + "\n")
        assert result.code == 0 and "begins at" not in result.stderr and "no cell" not in result.stderr


@pytest.mark.parametrize("change", [None, f"{LOAD} /", "&constraint lower = -8e-3, 8e-3  upper = 8e-3, 8e-3  fix = 'y'  displacement = 0.0, 1e-6 /",
                                    "&constraint lower = -8e-3, 8e-3  upper = 8e-3, 8e-3  fix = 'y'  velocity = 0.0, 1.0 /", "eigenstrain"],
                         ids=["nothing", "load", "displacement", "velocity", "eigenstrain"])
def test_a_static_model_that_nothing_loads_is_told(case, change):
    """It ended with zeros, without a word."""
    text = LATE + "&method time = 'static' /\n" + (change or "").replace("eigenstrain", "") + "\n"
    if change == "eigenstrain":
        text = text.replace("&body", "&body eigenstrain = 1e-4, 0.0, 0.0 ")
    for options in ([], ["--check"]):
        result = case("at_rest", *options, text=text)
        assert result.code == 0
        assert ("nothing loads the model, and all displacements stay 0" in result.stderr) == (change is None)


@pytest.mark.parametrize("method", ["explicit", "static"])
def test_a_peak_of_a_table_within_its_first_step(case, method):
    """Only corners a whole step after the first one were looked at: a pulse in the first step was passed by without a word."""
    pulse = f"{LOAD}  history = 'table'  times = 0.0, 1e-8, 2e-8  factors = 0.0, 1.0, 0.0 /\n&method time = '{method}' /\n"
    assert "may pass by its factor at 1.0e-8 s" in case("pulse", text=LATE + pulse).stderr
    assert "may pass by" not in case("ramp", text=LATE + pulse.replace("1.0, 0.0 /", "1.0, 1.0 /")).stderr


def test_a_first_factor_that_acts_for_a_whole_step(case):
    """A table that begins at 1 and is 0 after a hundredth of a step gave a hundred times its impulse without a word, or was passed by where it begins later."""
    pulse = LATE + f"{LOAD}  history = 'table'  times = 0.0, 1e-10  factors = -1.0, 0.0 /\n"
    told = "its factor of -1.0 at the start acts for a whole step of"
    assert told in case("pulse", text=pulse).stderr
    assert told in case("implicit", text=pulse + "&method time = 'implicit'  time_step = 2e-8 /\n").stderr
    for right in (pulse.replace("-1.0, 0.0 /", "0.0, 1.0 /"), pulse.replace("1e-10", "5e-7"), pulse + "&method start = 'static' /\n"):
        assert "its factor" not in case("right", text=right).stderr
    late = pulse.replace("history = 'table'", "history = 'table'  start = 3.3e-7")
    assert "may pass by its factor at 0.0 s" in case("late", text=late).stderr


def test_a_tip_without_a_load_does_not_wait(case):
    """Before its load began it was said that nothing opens the tip in the direction that it would take, and to let it go straight on."""
    text = LATE.replace("end_time = 1e-6", "end_time = 1.0").replace("&output history_interval = 1e-7 /\n", "") + f"""\
{LOAD}  start = 0.5  history = 'ramp'  rise_time = 0.5 /
&crack kind = 'path'  points = -4e-3, -1e-3, 3.1e-3, 2.2e-3 /
&method time = 'static'  load_steps = 4 /
&refine indicator = 'tip'  max_level = 1 /
&growth toughness = 10.0  increment = 1e-3 /
&energy_release estimators = 'domain_integral' /
"""
    result = case("late_load", text=text)
    assert result.code == 0 and "has waited" not in result.stderr
    assert result.row["crack_length"][-1] > result.row["crack_length"][0]


@pytest.mark.parametrize(("steps", "told"), [(4, False), (8, False), (2, False), (3, True), (1, True)])
def test_a_peak_that_a_load_step_meets_is_not_passed_by(case, steps, told):
    """Load steps are at equal parts of the end time: one of four is just at the peak, and it was said that they may pass by it."""
    peak = f"{LOAD}  history = 'table'  times = 0.0, 0.25e-6, 0.5e-6, 0.75e-6  factors = 0.0, 0.0, 1.0, 0.0 /\n"
    result = case("peak", text=LATE.replace("&output history_interval = 1e-7 /\n", "") + peak + f"&method time = 'static'  load_steps = {steps} /\n")
    assert result.code == 0 and ("may pass by" in result.stderr) == told


PROFILE = """\
&run plane = 'strain'  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 10, 10 /
&material name = 'a'  young = 1e9  poisson = 0.3  density = 1000 /
&body material = 'a'  lower = 0.0, 0.0  upper = 10e-3, 10e-3  eigenstrain = 1e-3, 1e-3, 0.0  profile_at = 0.0, 10e-3  profile_direction = 1.0, 0.0  {factors} = 2.0 /
"""


@pytest.mark.parametrize("factors", ["profile_stiffness", "profile_density", "profile_eigenstrain"])
def test_a_profile_without_a_factor_for_each_place_is_refused(case, factors):
    """The largest time step is found beside other errors: it asked factors of places that have none."""
    result = case("profile", "--check", text=PROFILE.format(factors=factors))
    assert result.code == 2
    assert f"{factors} = 2.0: must have one value for each of the 2 places of profile_at, not 1" in result.stderr
