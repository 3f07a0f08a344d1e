"""Names of version 1: tools/upgrade.py rewrites them, the program refuses them by their new names, and nothing in this repository has them."""

import json
import re
import subprocess
import sys

import pytest
from base_case import GOOD

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))
import upgrade

NAMELIST = """\
! dilatation = 'cell' &method mass='full' /
&RUN TITLE = 'it''s ! & / mass = ' end_time = 1 / &METHOD MASS = 'FULL'  BLEND = 0.3 / ! full
&material
   name = 'full'           ! full
   dilatation = 'cell'     ! one a cell
   kinematic = 1e9 /
&material name = "a" dilatation = "point" law='x'/
&body part='a' material = 'joined' /
&contact bodies = 'joined' /
&load kind = 'point' /
&method
   functions =
      'cpdi'
   mass = 'blend' blend=0.3
   full_lower = 2*0
/
&constraint push_only = .true. /
&energy_release
   estimators = 'nodal_force', 'energy_balance',   ! two
                'domain_integral'                  ! three
   radii = 1, 2
/
&energy_release estimators = 'energy_balance' /
&energy_release estimators = 'energy_balance', 'nodal_force' radii = 1 /
&energy_release estimators = 1*'crack_closure' reference = 'dcb'
"""
UPGRADED = """\
! dilatation = 'cell' &method mass='full' /
&RUN TITLE = 'it''s ! & / mass = ' end_time = 1 / &METHOD MASS = 'CONSISTENT'  LUMPED_FRACTION = 0.3 / ! full
&material
   name = 'full'           ! full
   volumetric = 'b_bar'    ! one a cell
   kinematic_hardening = 1e9 /
&material name = "a" volumetric = "standard" law='x'/
&body contact_group='a' material = 'joined' /
&contact bodies = 'bonded' /
&load kind = 'point' /
&method
   shape_functions =
      'cpdi'
   mass = 'weighted' lumped_fraction=0.3
   consistent_lower = 2*0
/
&constraint unilateral = .true. /
&energy_release
   estimators = 'vcct',   ! two
                'domain_integral'                  ! three
   energy_balance = .true.
   radii = 1, 2
/
&energy_release energy_balance = .true. /
&energy_release estimators = 'vcct'  energy_balance = .true. radii = 1 /
&energy_release estimators = 1*'domain_integral' reference = 'dcb'
"""
SWEEP = """\
# mass: full
namelist: full.nml   # full
output: ../results/full
product:
  method.mass, method.solver:   # full
    - [full, umfpack]
    - ["lumped", Banded]
  load.kind, Material(2).dilatation: [[point, point], [body, cell]]
  energy_release.estimators:
    - nodal_force
    - [nodal_force, energy_balance]
    - "crack_closure,energy_balance"
    - energy_balance
  method.full_region:
  - box
cases:
  - {method.scheme: usl, method.mass: full, energy_release.estimators: "nodal_force, energy_balance"}
  - method.mass: blend
    method.blend: 0.4
    energy_release.estimators: [energy_balance]
    contact.bodies: ${HAMPM_BODIES}
columns: [G_nodal_force_I, "G_crack_closure*", J_spread_tip2, distance_from_rest, J]
"""
UPGRADED_SWEEP = """\
# mass: full
namelist: full.nml   # full
output: ../results/full
product:
  method.mass, method.solver:   # full
    - [consistent, direct]
    - ["lumped", direct]
  load.kind, Material(2).volumetric: [[point, standard], [body, b_bar]]
  energy_release.estimators, energy_release.energy_balance:
    - [vcct, .false.]
    - [[vcct], .true.]
    - ["domain_integral", .true.]
    - ["", .true.]
  method.consistent_region:
  - box
cases:
  - {method.scheme: usl, method.mass: consistent, energy_release.estimators: "vcct", energy_release.energy_balance: .true.}
  - method.mass: weighted
    method.lumped_fraction: 0.4
    energy_release.estimators: ""
    energy_release.energy_balance: .true.
    contact.bodies: ${HAMPM_BODIES}
columns: [G_vcct_I, "G_domain*", J_domain_dependence_tip2, distance_to_equilibrium, J]
"""
OLD_VALUES = [(group, key, old, new) for (group, key), values in upgrade.VALUES.items() for old, new in values.items()]
OLD = re.compile(
    r"\bG_(nodal_force|crack_closure)|\bnodal_force\b|\bpush_only\b|\bfull_(region|lower|upper)\b|\bdistance_from_rest\b|\bJ_spread\b"
    r"|\bdilatation *= *'|(?<!_)\bfunctions *= *'(cpdi|linear)'|\bmass *= *'(full|blend)'|\bmass=(full|blend)|\bblend = [.\d]"
    r"|\bmethod\.mass: [^\n]*\b(full|blend)\b|\bbodies *= *'joined'|`(full|blend|functions|dilatation|part|joined|kinematic|crack_closure|series_fit)`|estimators\b[^/\n]*\benergy_balance'")
WITH_OLD = "upgrading.md", "test_words.py", "test_upgrade.py", "test_same_numbers.py", "test_history.py"  # which are about old names


def tool(*arguments):
    """The tool as users call it, by a Python that has nothing installed."""
    return subprocess.run([sys.executable, "-I", "-S", ROOT / "tools/upgrade.py", *arguments], capture_output=True, text=True)


@pytest.mark.parametrize(("name", "old", "new"), [("case.nml", NAMELIST, UPGRADED), ("sweep.yaml", SWEEP, UPGRADED_SWEEP)])
def test_files_are_rewritten_once(tmp_path, name, old, new):
    file = tmp_path / name
    file.write_bytes(old.replace("\n", "\r\n").encode())
    assert tool(file).stdout == new and file.read_bytes() == old.replace("\n", "\r\n").encode()
    for _ in range(2):
        assert (tool("--in-place", file).returncode, file.read_bytes().decode()) == (0, new.replace("\n", "\r\n"))
    assert [item.name for item in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(("old", "new"), [
    ("&method\n   mass = 'full'\n   time_steps = 'local'\n   courant = 0.5\n/\n", "&method\n   mass = 'consistent'\n   courant = 0.5\n/\n"),
    ("&method\n   time_steps = 'local'   ! as cells differ\n/\n", "&method\n   ! as cells differ\n/\n"),
    ("&method time_steps='global', mass = 'full' /\n", "&method mass = 'consistent' /\n"), ("&method frame = 'total' time_steps = 'local' /\n", "&method frame = 'total' /\n")])
def test_a_key_that_is_gone_is_left_out_and_told(tmp_path, old, new):
    (tmp_path / "case.nml").write_text(old)
    done = tool(tmp_path / "case.nml")
    assert done.stdout == new and done.stderr == f"upgrade.py: {tmp_path}/case.nml: &method time_steps is left out: version 3 has one step for all cells\n"


def test_a_key_that_is_gone_is_told_in_sweeps(tmp_path):
    (tmp_path / "sweep.yaml").write_text("product:\n  method.mass, method.time_steps: [[full, local]]\ncases:\n  - {method.time_steps: local}\n")
    done = tool(tmp_path / "sweep.yaml")
    assert "[[consistent, local]]" in done.stdout and done.stderr.count("method.time_steps: take it out") == 2


RELEASE_2 = "25183e6e"    # the commit of version 2.0.0
MADE_TO_BE_REFUSED = {"tests/cases/body_without_area.nml", "tests/cases/fpe_expected_error.nml", "tests/cases/sine_not_resolved.nml",
                      *(f"tests/cases/history_keys_ignored_{name}.nml" for name in ("constraint", "rise", "table"))}


@pytest.fixture(scope="module")
def version_2(tmp_path_factory):
    """The files of version 2.0.0."""
    archive = subprocess.run(["git", "archive", RELEASE_2, "input", "docs/lessons", "tests"], cwd=ROOT, capture_output=True)
    if archive.returncode:
        pytest.skip("the history has no version 2.0.0 here")
    folder = tmp_path_factory.mktemp("version_2")
    subprocess.run(["tar", "-x"], cwd=folder, input=archive.stdout, check=True)
    return folder


@pytest.mark.verify
def test_all_models_of_version_2_are_taken(hampm, version_2):
    models = {str(path.relative_to(version_2)): path for path in sorted(version_2.rglob("*.nml"))}
    assert len(models) > 100 and tool("--in-place", *models.values()).returncode == 0
    refused = {name: result.stderr for name, path in models.items() if (result := hampm(path.name, "--check", cwd=path.parent)).returncode}
    assert refused.keys() == MADE_TO_BE_REFUSED, refused


def test_all_sweeps_of_version_2_have_present_names(version_2):
    sweeps = sorted((version_2 / "input").glob("*.yaml"))
    assert sweeps and tool("--in-place", *sweeps).returncode == 0
    assert not [path.name for path in sweeps if OLD.search(path.read_text())]


def test_columns_are_listed():
    names = json.loads(tool("--columns").stdout)
    assert {"G_nodal_force_I": "G_vcct_I", "G_crack_closure_II_error_tip3": "G_domain_II_error_tip3", "J_spread": "J_domain_dependence",
            "distance_from_rest": "distance_to_equilibrium"}.items() <= names.items() and "J" not in names


def test_what_cannot_be_read_is_told(tmp_path):
    assert tool().returncode == 2
    result = tool(tmp_path / "none.nml")
    assert result.returncode == 1 and result.stderr.startswith("upgrade.py: ") and "none.nml" in result.stderr


@pytest.mark.parametrize(("group", "key", "new"), [(*place, new) for place, new in upgrade.KEYS.items()])
def test_an_old_key_is_refused_by_its_new_name(hampm, tmp_path, group, key, new):
    (tmp_path / "case.nml").write_text(f"{GOOD}&{group}\n  {key} = 1 /\n")
    line = GOOD.count("\n") + 2
    told = f"&{group} has no key '{key}'; it is called {new} now"
    assert f"case.nml:{line}: {told}" in hampm("case.nml").stderr
    (tmp_path / "case.nml").write_text(GOOD)
    assert told in hampm("case.nml", "--set", f"{group}.{key}=1").stderr


@pytest.mark.parametrize(("group", "key", "old", "new"), [*OLD_VALUES, (*upgrade.ESTIMATORS, upgrade.BALANCE, "energy_balance = .true.")])
def test_an_old_value_is_refused_by_its_new_name(hampm, tmp_path, group, key, old, new):
    (tmp_path / "case.nml").write_text(f"&{group}\n  {key} = '{old}' /\n")
    new = new if " " in new else f"'{new}'"
    assert re.search(rf"^hampm: case\.nml:2: &{group} {key} = '{old}': .*; it is called {new} ", hampm("case.nml").stderr, re.MULTILINE)


def test_all_old_values_of_a_list_are_told_at_once(hampm, tmp_path):
    (tmp_path / "case.nml").write_text("&energy_release estimators = 'nodal_force', 'vcct', 'energy_balance' /\n")
    told = next(line for line in hampm("case.nml").stderr.splitlines() if "estimators" in line)
    assert re.findall(r"value (\d) must be [^;]*; it is called (.*?) now: ", told) == [("1", "'vcct'"), ("3", "energy_balance = .true. beside the estimators")]


def test_the_program_knows_no_other_old_names():
    table = (ROOT / "src/input/keys.f90").read_text().split(":: renames(*)")[1].split("contains")[0]
    rows = {row for row in re.findall(r"renamed_t\('(\w+)', '(\w+)', '(\w*)'", table)}
    assert rows - {(*place, "") for place in upgrade.REMOVED} == {(*place, "") for place in upgrade.KEYS} | {(group, key, old) for group, key, old, _ in OLD_VALUES} | {(*upgrade.ESTIMATORS, upgrade.BALANCE)}


def test_no_old_name_is_left():
    files = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    files += [path for part in ("docs", "input", "tests", "bench", "batch", "postprocess") for path in (ROOT / part).rglob("*")
              if path.suffix in (".md", ".nml", ".yaml", ".toml", ".py", ".csv", ".sh", ".gp") and path.name not in WITH_OLD]
    left = [f"{path.relative_to(ROOT)}: {found[0]}" for path in files if (found := OLD.search(path.read_text()))]
    assert not left
    for path in files:
        if path.suffix in (".nml", ".yaml"):
            assert upgrade.upgraded(path.read_text(), path.suffix == ".yaml") == path.read_text(), path
