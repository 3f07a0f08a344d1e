"""The command line and the namelist file as a user means them to work."""

import math
import re

import pytest
from base_case import GOOD, LINE, REFINE, changed


@pytest.fixture
def check(hampm, tmp_path):
    """Validate a namelist text with `--check`; returns the scene as it is understood. `idle` are the keys that it says to have no effect, `late` is whether a load
    is said to begin after the end."""

    def run(text, *arguments, idle=(), late=False):
        (tmp_path / "case.nml").write_bytes(text if isinstance(text, bytes) else text.encode())
        result = hampm("case.nml", "--check", "--quiet", *arguments)
        assert result.returncode == 0, result.stderr
        assert re.findall(r"^hampm: warning: &(?:refine|method) (\w+) = .* has no effect with.*$", result.stderr, re.MULTILINE) == list(idle)
        assert ("and the run ends at" in result.stderr) == late
        assert len(result.stderr.splitlines()) == len(idle) + late
        return result.stdout

    return run


def value_of(scene, group, key):
    """The value of a key in the first group of a name, as text."""
    return re.search(rf"&{group}\n(?:.*\n)*?   {key} = ?(.*)\n", scene)[1]


def test_help_names_every_option(hampm):
    result = hampm("--help")
    assert result.returncode == 0
    for option in ("--check", "--template", "--keys", "--set", "--output", "--threads", "--quiet", "--version", "--help",
                   "--force", "--resume", "--time-limit", "--steps"):
        assert option in result.stdout


def test_version(hampm):
    result = hampm("--version")
    assert result.returncode == 0
    assert re.fullmatch(r"hampm \d+\.\d+\.\d+\S*( \([0-9a-f]{7,40}(, modified)?\))?\n", result.stdout)


def test_template_is_a_valid_scene(hampm, check):
    template = hampm("--template")
    assert template.returncode == 0
    assert value_of(check(template.stdout), "crack", "tip") == "0.05, 0.0"


def test_template_explains_every_key(hampm):
    template = hampm("--template").stdout
    for line in template.splitlines():
        assert line in ("", "/") or " ! " in line or line.startswith("! "), line


def test_scene_as_used_reads_back_as_the_same_scene(check, hampm):
    for text in (GOOD, hampm("--template").stdout):
        scene = check(text)
        assert check(scene) == scene


def test_scene_as_used_holds_every_key_of_the_template(check, hampm):
    template = hampm("--template").stdout
    names = re.compile(r"^(?:&\w+|   \w+ =)", re.MULTILINE)
    assert names.findall(check(template)) == names.findall(template)


def test_check_tells_what_a_run_would_do_below_the_scene(check):
    scene, summary = check(GOOD).rsplit("/\n", 1)
    assert "!" not in scene
    assert all(line.startswith("! ") for line in summary.splitlines())
    longest_step = 0.1 * 1.25e-3 / math.sqrt(70e9 / 2.6 / 2700)
    facts = {line[2:18].strip(): line[18:].split() for line in summary.splitlines()}
    assert facts["particles"] == ["2560"]
    assert facts["cells"][0] == "720," and facts["cells"][-1] == "640"
    assert float(facts["time step"][0]) == pytest.approx(longest_step, rel=1e-12)
    assert int(facts["steps"][0]) == math.ceil(1.5e-3 / longest_step)
    assert float(facts["G_ref"][0]) == pytest.approx(12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3), rel=1e-12)


def test_check_tells_how_cells_refine_and_how_deep(check):
    def refinement(text, idle=()):
        return [line[18:] for line in check(text, idle=idle).splitlines() if line.startswith("! refinement ")]

    assert refinement(GOOD) == []
    assert refinement(GOOD + REFINE.replace("gradient", "none"), ["region_lower", "region_upper", "interval"]) == []
    (line,) = refinement(GOOD + REFINE.replace("gradient", "zz"))
    assert re.match(r"zz, at most 4 levels, to cells of (\S+) m", line)
    assert float(line.split()[-2]) == 1.25e-3 / 2**4


def test_check_counts_a_cell_beside_finer_ones_once(check):
    """The beam fills 8 rows of 9, and refinement at the tip stays away from the empty one."""
    (cells, occupied), = re.findall(r"^! cells +(\d+), of which occupied (\d+)$",
                                    check(GOOD + REFINE.replace("gradient", "tip").replace("rings = 4", "rings = 2"), idle=["interval"]), re.MULTILINE)
    assert int(cells) - int(occupied) == 80


def crack_facts(checked):
    """What `--check` tells of a crack, by name."""
    return dict(re.findall(r"^! (crack|cells at tip|domain radii) +(.*) m$", checked, re.MULTILINE))


def test_check_tells_where_the_crack_is_and_where_its_energy_release_rate_is_looked_for(check):
    assert crack_facts(check(GOOD[: GOOD.index("&crack")])) == {}
    assert crack_facts(check(GOOD)) == {"crack": "symmetry, tip (0.05, 0.0), mouth (0.0, 0.0)", "cells at tip": "0.00125"}
    assert crack_facts(check(LINE + REFINE.replace("gradient", "tip"), idle=["interval"])) == {
        "crack": "line, tip (0.05, 0.01) m at its last point, length 0.05 m, mouth (0.0, 0.01)", "cells at tip": "7.8125e-5", "domain radii": "0.004, 0.006, 0.008"}
    assert crack_facts(check(changed(("length = 0.0", "length = 0.02"), scene=LINE)))["crack"] == (
        "line, tip (0.03, 0.01) m at its first point, length 0.02")


@pytest.mark.parametrize(("grid", "expected"), [("cell = 1.25e-3 cells = 80, 17", "0.004, 0.006, 0.008"),
                                                ("cell = 2.5e-3 cells = 40, 9", "0.005, 0.0065, 0.008"),
                                                ("cell = 5e-3 cells = 20, 5", "0.01")])
def test_default_radii_fit_where_there_are_few_cells(check, grid, expected):
    """0.4, 0.6 and 0.8 of what fits, but no less than two of the finest cells; one radius where there is no room for more."""
    scene = changed(("cell = 1.25e-3\n  cells = 80, 17", grid), ("radii = 4e-3, 6e-3, 8e-3", ""), scene=LINE)
    assert crack_facts(check(scene))["domain radii"] == expected


@pytest.mark.parametrize("indicator", ["none", "gradient", "zz", "tip"])
def test_refinement_by_every_indicator(check, indicator):
    idle = {"none": ["region_lower", "region_upper", "interval"], "tip": ["interval"]}.get(indicator, [])
    scene = check(GOOD + REFINE.replace("gradient", indicator), idle=idle)
    assert value_of(scene, "refine", "indicator") == f"'{indicator}'"
    assert check(scene, idle=idle) == scene


def test_the_mass_matrix_may_be_full_where_cells_refine(check):
    method = ("'musl'", "'musl' mass = 'partial' consistent_region = 'refined'")
    scene = check(changed(method, scene=GOOD + REFINE))
    assert value_of(scene, "method", "consistent_region") == "'refined'"
    assert value_of(check(GOOD), "method", "consistent_region") == "'box'"
    assert check(scene) == scene


def test_the_region_of_another_mass_matrix_has_no_effect(check):
    check(changed(("'musl'", "'musl' consistent_region = 'refined'")), idle=["consistent_region"])


def test_refinement_has_defaults_and_no_region(check):
    scene = check(GOOD + "&refine /\n")
    assert value_of(scene, "refine", "indicator") == "'none'"
    assert value_of(scene, "refine", "region_lower") == value_of(scene, "refine", "region_upper") == ""
    assert value_of(scene, "refine", "interval") == "100"
    assert int(value_of(scene, "refine", "max_particles")) == 1_000_000
    assert check(scene) == scene


@pytest.mark.parametrize(
    "limit", ["region_lower = 0.05, -1", "region_upper = 0.05, 1", "max_particles = 2000000000", "max_particles = 2560"]
)
def test_a_region_may_be_open_and_limits_may_be_reached(check, limit):
    scene = check(GOOD + f"&refine indicator = 'gradient' {limit} /\n")
    assert check(scene) == scene


@pytest.mark.parametrize(
    ("keys", "idle"),
    [
        ("indicator = 'none' max_particles = 1 region_lower = 1, 1 region_upper = 0, 0 r_coarsen = 1",
         ["region_lower", "region_upper", "max_particles", "r_coarsen"]),
        ("indicator = 'tip' r_coarsen = 1 max_level = 0", ["r_coarsen"]),
        ("indicator = 'zz' r_coarsen = 1 max_level = 0", ["r_coarsen"]),
    ],
)
def test_keys_that_an_indicator_does_not_use_have_no_effect(check, keys, idle):
    check(changed(("points_per_cell = 2", "points_per_cell = 3")) + f"&refine {keys} /\n", idle=idle)


def test_values_that_stand_for_others_are_resolved(check):
    scene = check(changed(("  file = 'beam.h5'\n", ""), ("history_interval = 1e-6", "history_interval = 0"),
                          ("direction = 1.0, 0.0", "direction = 3.0, 0.0")))  # fmt: skip
    assert value_of(scene, "output", "file") == "'case.h5'"
    assert float(value_of(scene, "output", "history_interval")) == pytest.approx(1.5e-6, rel=1e-15)
    assert value_of(scene, "crack", "direction") == "1.0, 0.0"


def test_smallest_scene_gets_the_defaults(check):
    scene = check("&run end_time = 1 /\n&grid cell = 1 cells = 2, 2 /\n&material name = 'a' young = 1 density = 1 /\n"
                  "&body material = 'a' lower = 0, 0 upper = 1, 1 /\n")  # fmt: skip
    assert value_of(scene, "run", "thickness") == "1.0"
    assert value_of(scene, "method", "scheme") == "'musl'"
    assert value_of(scene, "method", "frame") == "'total'"
    assert value_of(scene, "energy_release", "estimators") == ""
    assert "&crack" not in scene
    assert "&load" not in scene


@pytest.mark.parametrize(("mass", "frame", "courant"), [
    ("lumped", "updated", "0.1"), ("fmpm", "updated", "0.1"), ("weighted", "updated", "0.1"), ("consistent", "updated", "0.05"),
    ("partial", "updated", "0.05")])  # fmt: skip
def test_the_time_step_is_safe_by_default(check, mass, frame, courant):
    method = (f"--set method.mass={mass} --set method.frame={frame} --set method.consistent_lower=0,0 "
              "--set method.consistent_upper=0.05,0.01").split()  # fmt: skip
    left_out = changed(("  courant = 0.1\n", ""))
    idle = [] if mass == "partial" else ["consistent_upper"]
    assert value_of(check(left_out, *method, idle=idle), "method", "courant") == courant
    assert value_of(check(GOOD, *method, "--set", "method.courant=0", idle=idle), "method", "courant") == courant
    assert value_of(check(GOOD, *method, idle=idle), "method", "courant") == "0.1"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("young = 70e9", "young = 70d9"),
        ("young = 70e9", "YOUNG=+7.D+10"),
        ("young = 70e9", "young = 70000000000."),
        ("young = 70e9", "young = 70e9,"),
        ("young = 70e9", "young\n=\n70e9 ! of / 'aluminium' &here"),
        ("young = 70e9", "young = .7e11"),
        ("young = 70e9\n", "young\t=\t70e9\t"),
        ("velocity = 0.0, 0.0", "velocity = 2*0.0"),
        ("velocity = 0.0, 0.0", "velocity = -0.0 0"),
        ("cells = 80, 9", "cells = 80 , 9"),
        ("'musl'", '"MUSL"'),
        ("'vcct', 'stress_closure'", "'vcct' \"stress_closure\""),
        ("&damping", "&DAMPING"),
        ("/\n&damping\n", "/ &damping "),
        ("  rate = 1e4\n/", "  rate = 1e4/"),
    ],
)
def test_all_spellings_of_a_namelist_mean_the_same(check, old, new):
    assert check(changed((old, new))).replace("-0.0", "0.0") == check(GOOD)


@pytest.mark.parametrize(
    "text",
    [
        GOOD.replace("\n", "\r\n").encode(),
        b"\xef\xbb\xbf" + GOOD.encode(),
        GOOD.rstrip("\n").encode(),
        GOOD.replace("  ", "\t").encode(),
        ("! a scene\n\n" + GOOD + "\n! the end").encode(),
        b" ".join(line.strip().encode() for line in GOOD.splitlines()),
    ],
    ids=["CRLF", "byte order mark", "no final newline", "tabs", "comments", "one line"],
)
def test_all_layouts_of_a_file_mean_the_same(check, text):
    assert check(text) == check(GOOD)


@pytest.mark.parametrize("title", ["it's", 'say "A"', "a / b & c ! d = 1, 2", "Träger, β", "3*4", "''"])
def test_text_is_kept_as_it_is(check, title):
    scene = check(changed(("'beam'", "'" + title.replace("'", "''") + "'")))
    assert value_of(scene, "run", "title") == "'" + title.replace("'", "''") + "'"
    assert check(scene) == scene


@pytest.mark.parametrize("number", ["0.1", "1e-99", "1e-100", "1.7976931348623157e99", "3.141592653589793", "123456.789", "2.0e-5", "1e22"])
def test_numbers_are_kept_to_the_last_bit(check, number):
    scene = check(GOOD, "--set", f"load.start={number}", late=float(number) > 1e-3)
    assert float(value_of(scene, "load", "start")) == float(number)


def test_set_replaces_a_value(check):
    scene = check(GOOD, "--set", "material.young=1e9", "--set=method.scheme=usl", "--set", "GRID.lower = 0.0 , 0.0")
    assert float(value_of(scene, "material", "young")) == 1e9
    assert value_of(scene, "method", "scheme") == "'usl'"


def test_set_replaces_a_wrong_value(check):
    assert float(value_of(check(changed(("young = 70e9", "young = -1")), "--set", "material.young=1e9"), "material", "young")) == 1e9


def test_the_last_set_wins(check):
    assert float(value_of(check(GOOD, "--set", "damping.rate=1", "--set", "damping.rate=2"), "damping", "rate")) == 2


def test_set_takes_text_and_lists_without_quotes(check):
    scene = check(GOOD, "--set", "run.title=a b, c/d", "--set", "energy_release.estimators=vcct,domain_integral")
    assert value_of(scene, "run", "title") == "'a b, c/d'"
    assert value_of(scene, "energy_release", "estimators") == "'vcct', 'domain_integral'"


def test_set_reaches_each_of_several_groups(check):
    scene = check(GOOD + "&constraint lower = 0, 0.01 upper = 0, 0.01 fix = 'x' /\n", "--set", "constraint(2).fix=xy")
    assert re.findall(r"fix = (.*)", scene) == ["'y'", "'xy'"]


def test_set_adds_a_group(check):
    start, end = GOOD.index("&crack"), GOOD.index("&energy_release")
    scene = check(GOOD[:start] + GOOD[end:], "--set", "crack.tip=0.05,0")
    assert scene == check(GOOD)


@pytest.mark.parametrize(("typed", "meant"), [("--out", "--output"), ("--temp", "--template"), ("--tim", "--time-limit"), ("--che", "--check"), ("--quite", "--quiet")])
def test_the_beginning_of_an_option_leads_to_it(hampm, typed, meant):
    assert hampm(typed).stderr.startswith(f"hampm: there is no option {typed}; did you mean '{meant}'?")


def test_options_stand_anywhere_and_end_at_two_dashes(hampm, tmp_path):
    (tmp_path / "--case.nml").write_text(GOOD)
    result = hampm("--check", "--threads=2", "--quiet", "--output", ".", "--", "--case.nml")
    assert result.returncode == 0, result.stderr


def test_a_scene_from_a_pipe(hampm):
    result = hampm("--check", "/dev/stdin", input=GOOD)
    assert result.returncode == 0, result.stderr


def test_bodies_may_touch(check):
    bodies = changed(("reference = 'dcb'", "reference = 'none'"), ("upper = 0.1, 0.01", "upper = 0.07, 0.01"))
    check(bodies + "&body material = 'aluminium' lower = 0.07, 0.0 upper = 0.1, 0.01 /\n")


@pytest.mark.parametrize(
    "load",
    [
        "kind = 'point' lower = 0.05, 0.01 upper = 0.05, 0.01",
        "kind = 'body' lower = 0.0, 0.0 upper = 1.0, 1.0",
        "kind = 'traction' lower = 0.02, 0.01 upper = 0.03, 0.01",
        "kind = 'traction' lower = 0.1, 0.0 upper = 0.1, 0.005",
        "kind = 'point' lower = 0, 0 upper = 0, 0 history = 'ramp' rise_time = 1e-4",
        "kind = 'point' lower = 0, 0 upper = 0, 0 history = 'sine' frequency = 1e4 start = -1e-5",
        "kind = 'point' lower = 0, 0 upper = 0, 0 history = 'table' times = 0, 1e-4, 1 factors = 0, 1, 0",
    ],
)
def test_loads_of_all_kinds(check, load):
    scene = check(GOOD + f"&load {load} force = 0, -1 /\n")
    assert check(scene) == scene


def test_a_table_of_a_thousand_values(check):
    times = ", ".join(f"{i}e-6" for i in range(1000))
    scene = check(GOOD + "&load kind = 'point' lower = 0, 0 upper = 0, 0 force = 0, 1 history = 'table'\n"
                  f"times = {times}\nfactors = 500*0.0, 500*1.0 /\n")  # fmt: skip
    assert check(scene) == scene


def test_a_crack_along_the_other_axis(check):
    text = """\
&run end_time = 1e-3 /
&grid lower = -0.01, -0.1 cell = 1e-3 cells = 20, 200 /
&material name = 'a' young = 70e9 density = 2700 /
&body material = 'a' lower = 0.0, -0.1 upper = 0.01, 0.1 /
&constraint lower = 0.0, -0.1 upper = 0.0, 0.0 fix = 'x' /
&load kind = 'traction' lower = 0.0, 0.1 upper = 0.01, 0.1 force = 1.0, 0.0 /
&crack tip = 0.0, 0.0 direction = 0.0, -2.0 /
&energy_release estimators = 'vcct' reference = 'dcb' /
"""
    assert value_of(check(text), "crack", "direction") in ("0.0, -1.0", "-0.0, -1.0")
