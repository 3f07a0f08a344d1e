"""The reference pages say what the program does: keys, rules between keys, columns of the history, exit codes."""

import json
import re
import sys

import h5py
import pytest
from base_case import GOOD, LINE, REFINE

from paths import INPUT, ROOT, SOLID_PROGRAM

sys.path.insert(0, str(ROOT / "tools"))

from python_groups import columns_in_tables  # noqa: E402
from schema import Schema  # noqa: E402

DOCS = ROOT / "docs/reference"


def rows(page, head):
    """The cells of the tables that begin with a head, without the marks of code."""
    tables = [part.split("\n\n")[0] for part in (DOCS / page).read_text().split(head)[1:]]
    return [[cell.strip().replace("`", "") for cell in line.strip("|").split("|")] for table in tables for line in table.splitlines()[2:]]


@pytest.fixture(scope="module")
def reference(run_hampm, tmp_path_factory):
    """What `--keys` prints."""
    result = run_hampm("--keys", cwd=tmp_path_factory.mktemp("keys"))
    assert result.returncode == 0
    return result.stdout


@pytest.fixture(scope="module")
def choices(reference):
    """By group and key: the texts that are allowed."""
    found = {}
    for section in reference.split("\n## &")[1:]:
        for line in section.splitlines():
            if row := re.match(r"\| `(\w+)` \|[^|]*\|[^|]*\|[^|]*\|([^|]*)\|", line):
                found[section.split("\n")[0], row[1]] = set(re.findall(r"`(\w+)`", row[2]))
    return found


def test_page_of_the_keys_is_what_the_program_prints(reference):
    assert (DOCS / "keys.md").read_text() == reference, "build/release/hampm --keys > docs/reference/keys.md"


def test_page_of_the_rules_is_what_the_program_prints(hampm):
    assert (DOCS / "key_rules.md").read_text() == hampm("--rules").stdout, "build/release/hampm --rules > docs/reference/key_rules.md"


def test_rules_are_counted_and_the_same_for_programs(hampm):
    """As many sentences as rows; those whose reason is that something is not built are counted."""
    page, table = hampm("--rules").stdout, json.loads(hampm("--rules", "--json").stdout)
    assert max(map(len, page.splitlines())) <= 118
    assert len(re.findall(r"^- ", page, re.MULTILINE)) == len(table)
    page = " ".join(page.split())
    assert f"Of {len(table)} rules {sum(row['verdict'] in ('not allowed with', 'requires') for row in table)} refuse a model" in page
    assert page.count("(not built)") - 1 == sum(row["basis"] == "not built" for row in table) > 0
    assert {row["basis"] for row in table} == {"mechanics", "not built", "meaning of the keys"}


def test_reference_has_a_row_for_each_key_of_the_template(reference, hampm):
    keys = re.findall(r"^(?:! )?   (\w+) =", hampm("--template").stdout, re.MULTILINE)
    assert re.findall(r"^\| `(\w+)` \|", reference, re.MULTILINE) == keys


def test_each_key_gives_its_value_to_the_scene(choices):
    """A key that nothing takes from what was written would be allowed, documented, and without effect: those that the schema leaves to modules."""
    groups = Schema(ROOT / "src/input/schema").groups
    assert {(group, key) for group, of in groups.items() for key in of["keys"]} == set(choices)
    sources = "".join(path.read_text() for path in sorted((ROOT / "src/input").glob("*.f90")))
    fills = re.findall(r"subroutine fill_.*?end subroutine", sources, re.DOTALL)
    shared = {name: re.search(rf"(?:subroutine|function) {name}\(.*?\n   end ", sources, re.DOTALL)[0]
              for name in ("fill_history", "fill_factors", "take_ring", "is_hole")}
    for group, of in groups.items():
        source = "".join(fill for fill in fills if f"settings%find('{group}'" in fill or fill.startswith(f"subroutine fill_{group}("))
        source += "".join(text for name, text in shared.items() if f"{name}(" in source)
        assert set(of.get("by_hand", [])) <= set(re.findall(r"settings%\w+\([^']*(?:'\w+', [1ik]\), )?'(\w+)'", source) + re.findall(r"%key = '(\w+)'", source)), group


def test_examples_together_are_a_scene(reference, hampm, tmp_path):
    groups = re.findall(r"```fortran\n(.*?)```", reference, re.DOTALL)
    # those of a crack of kind 'path' are of other scenes
    (tmp_path / "case.nml").write_text("".join(group for group in groups if not group.startswith(("&growth", "&nucleation", "&cohesive", "&control", "&cycles"))))
    result = hampm("case.nml", "--check")
    assert result.returncode == 0, result.stderr


def test_page_of_places_names_only_groups_keys_and_choices_that_exist(choices):
    """In a section of a group, `key`, `key = 'choice'` and `'choice'` are of this group, `&other key` of another."""
    for section in (DOCS / "places.md").read_text().split("\n## &")[1:]:
        here = section.split("\n")[0]
        words = [word for word in re.findall(r"`([^`]+)`", section) if not word.startswith("-")]
        assert words
        for word in words:
            group, key, choice = re.fullmatch(r"(?:&(\w+) ?)?(\w+)?(?:(?: = )?'(\w+)')?", word).groups()
            group = group or here
            if key:
                assert (group, key) in choices, word
            else:
                assert any(group == of for of, _ in choices), word
            if choice:
                assert any(choice in texts for (of, name), texts in choices.items() if of == group and key in (None, name)), word


def test_every_column_of_the_history_is_documented(choices, hampm, tmp_path):
    documented = documented_columns("| column |")
    recorded = {}
    held = "&constraint lower = 0.1, 0.0 upper = 0.1, 0.02 fix = 'xy' name = 'grip' /\n"
    settings = ("run.end_time=1e-7", "output.history_interval=1e-7", "output.snapshot_interval=0",
                "energy_release.estimators=" + ",".join(choices["energy_release", "estimators"] - {"material_force"}))
    path = re.sub(r"&crack.*?\n/\n", "", GOOD, flags=re.DOTALL) + \
        "&crack kind = 'path' points = 0.0, 0.006, 0.05, 0.0045 contact = 'friction' friction = 0.1 /\n"
    growth = path.replace("contact = 'friction' friction = 0.1", "") + "&growth toughness = 1.0 increment = 0.01 /\n"
    running = path.replace("contact = 'friction' friction = 0.1", "") + \
        "&growth law = 'toughness' toughness = 1e6 /\n&load kind = 'absorbing' lower = 0.1, 0.0 upper = 0.1, 0.01 /\n"
    cohesive = path.replace("contact = 'friction' friction = 0.1", "") + "&cohesive from = 0.02 strength = 1e7 toughness = 1e3 /\n"
    between = LINE.replace("upper = 0.1, 0.02\n  points", "upper = 0.1, 0.01\n  points") + held + \
        "&material name = 'b' young = 1e9 density = 1000 /\n&body material = 'b' lower = 0.0, 0.01 upper = 0.1, 0.02 /\n"
    closed = path.replace("contact = 'friction' friction = 0.1", "").replace("0.0045", "0.0055")
    of_path = (*settings[:3], "energy_release.estimators=domain_integral", "energy_release.energy_balance=.true.", "energy_release.reference=none",
               "method.frame=total", "method.courant=0")
    plastic = path.replace("law = 'linear_elastic'", "law = 'j2_plastic' yield_stress = 1e9")
    viscous = path.replace("law = 'linear_elastic'", "law = 'viscoelastic' moduli = 1e9 relaxation_times = 1.0")
    meeting = re.sub(r"&(crack|energy_release).*?\n/\n", "", GOOD, flags=re.DOTALL) + "&contact bodies = 'frictionless' /\n"
    probed = [(f"probe{k}", path + held + f"&probe name = 'grip' {keys} /\n", of_path) for k, keys in enumerate((
        "quantity = 'displacement', 'velocity', 'strain', 'stress' at = 0.03, 0.003", "quantity = 'strain' at = 0.03, 0.003, 0.04, 0.003",
        "quantity = 'opening', 'volume' distance = 0.01", "quantity = 'load_line' of = 'grip'"))]
    for name, scene, asked in (("meeting", meeting, (*settings[:3], "method.frame=updated")), ("plastic", plastic, of_path), ("viscous", viscous, of_path), ("line", LINE + held + REFINE, settings),
                               ("zz", GOOD + REFINE.replace("gradient", "zz"), settings), ("path", path, of_path),
                               ("closure", closed, (*of_path, "energy_release.estimators=domain_integral,material_force",
                                                    "grid.cell=0.625e-3", "grid.cells=160,18")),
                               ("growth", growth, (*of_path, "method.time=static", "energy_release.t_stress=.true.")),
                               ("kink", growth.replace("&growth", "&growth direction = 'max_energy'"), (*of_path, "method.time=static")),
                               ("onset", growth.replace("&growth", "&nucleation"), (*of_path, "method.time=static")),
                               ("frame", growth + "&control stiffness = 1e6 /\n", (*of_path, "method.time=static")), ("interface", between, (*settings, "energy_release.phase_length=1e-3", "energy_release.reference=none")), ("running", running, of_path), ("fatigue", growth.replace("&growth", "&growth law = 'fatigue' rate_constant = 1e-30 rate_exponent = 3.0"), (*of_path, "method.time=static")),
                               ("creeps", growth.replace("&growth", "&growth law = 'subcritical' rate = 'charles' speed = 1e-3 rate_exponent = 3.0"), (*of_path, "method.time=static")),
                               ("cohesive", cohesive, of_path), *probed):
        (tmp_path / f"{name}.nml").write_text(scene)
        result = hampm(f"{name}.nml", "--set", f"output.file={name}.h5", *(f"--set={setting}" for setting in asked))
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / f"{name}.h5") as file:
            for column, data in file["history"].items():
                column = re.sub("_grip(?=_|$)", "_<name>", column)
                recorded.setdefault(column, (data.attrs["units"], re.sub("radius .* m$", "radius R m", long_name(column, data))))
    assert {column: texts for column, texts in recorded.items() if not re.fullmatch("J_[2-9]", column)} == documented


def documented_columns(head, where=""):
    """Unit and long name of the columns in the tables with this head; estimated errors of a column are told by ± behind its name."""
    return {name: (unit, long_name(name, meaning)) for of, name, unit, meaning, recorded in columns_in_tables((DOCS / "results.md").read_text())
            if of.startswith(head) and where in recorded and not re.fullmatch("J_[2-9]", name)}


def long_name(column, text):
    """The long name of a column, from its dataset or the page; all estimated errors have the same."""
    text = (text if isinstance(text, str) else text.attrs["long_name"]).replace(" of grip", " of <name>")
    return "estimated error" if column.endswith("_error") and text.startswith("estimated error of ") else text


SOLID = """
&run end_time = 1e-7 /
&grid lower = 0.0, 0.0, 0.0  cell = 0.05  cells = 4, 3, 3 /
&material name = 'a'  young = 1e9  poisson = 0.3  density = 1e3 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.1, 0.1, 0.1 /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 0.1, 0.1  fix = 'xyz'  name = 'grip' /
&load kind = 'traction'  lower = 0.1, 0.0, 0.0  upper = 0.1, 0.1, 0.1  force = 1.0, 1.0, 1.0 /
&method frame = 'updated' /
&probe name = 'grip'  {} /
&output history_interval = 1e-7 /
"""


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
def test_every_column_of_solids_is_documented(hampm, tmp_path):
    """What a plane does not have, in tables of its own; those along fronts among them."""
    documented, of_solids = documented_columns("| column |"), documented_columns("| column of solids |")
    along_fronts = documented_columns("| of solids |", "/history")
    recorded = {}
    for name, text in (("points", SOLID.format("quantity = 'displacement', 'velocity', 'strain', 'stress'  at = 0.03, 0.03, 0.03")),
                       ("loads", SOLID.format("quantity = 'load_line'  of = 'grip'")), ("front", (INPUT / "solid/penny.nml").read_text()),
                       ("ball", (INPUT / "solid/ball.nml").read_text().replace("8e-5", "1e-6").replace("2e-5", "1e-6")),
                       ("growing", (INPUT / "solid/penny.nml").read_text().replace("time = 'static'", "time = 'explicit'").replace("= 1.0\n", "= 1e-6\n", 1)
                        .replace("snapshot_interval = 1.0", "history_interval = 1e-6")
                        + "&growth law = 'prescribed'  speed = 1.0  direction = 'straight' /\n")):
        (tmp_path / f"{name}.nml").write_text(text)
        result = hampm(f"{name}.nml", "--set", f"output.file={name}.h5", program=SOLID_PROGRAM)
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / f"{name}.h5") as file:
            for column, data in file["history"].items():
                recorded[re.sub("_(grip|table)(?=_|$)", "_<name>", column)] = (data.attrs["units"], long_name(column, data))
    assert set(of_solids) <= set(recorded)
    texts = documented | of_solids | along_fronts
    assert recorded == {column: texts.get(column) for column in recorded}


def test_every_exit_code_is_documented():
    source = (ROOT / "src/base/failure.f90").read_text() + (ROOT / "src/processor.c").read_text()
    assert [row[0] for row in rows("results.md", "| code |")] == re.findall(r"\bexit_\w+ = (\d)", source)
