"""The JSON schema of models: what the programs say of their keys, and what `Scene.mistakes` and `run` make of it."""

import json
import random
import subprocess
import sys

import hampm as package
import pytest
from paths import INPUT, ROOT

MODELS = sorted(INPUT.glob("*.nml")) + sorted((INPUT / "solid").glob("*.nml"))
FILE = ROOT / "python/src/hampm/model.schema.json"


def as_f90nml_reads(model):
    """{group: its keys, or a list of such}."""
    groups = {}
    for group in model._written():
        values = dict(group.items())
        before = groups.get(group._name)
        groups[group._name] = values if before is None else [*(before if isinstance(before, list) else [before]), values]
    return groups


@pytest.fixture(scope="module")
def validator():
    return pytest.importorskip("jsonschema").Draft202012Validator(json.loads(FILE.read_text()))


def test_schema_is_what_the_programs_say():
    printed = subprocess.run([sys.executable, ROOT / "tools/python_groups.py", "--schema"], capture_output=True, text=True, check=True).stdout
    assert FILE.read_text() == printed, "tools/python_groups.py --schema > python/src/hampm/model.schema.json"


def test_all_models_are_as_the_schema_has_them(validator):
    validator.check_schema(validator.schema)
    for path in MODELS:
        model = package.Scene(path)
        assert model.mistakes() == [], path
        assert list(validator.iter_errors(as_f90nml_reads(model))) == [], path


@pytest.mark.parametrize(("group", "key", "value", "said"), [
    ("grid", "cell", -1.0, "&grid cell = -1.0: must be in (0, inf) [m]"), ("grid", "cell", 0, "&grid cell = 0: must be in (0, inf) [m]"),
    ("grid", "order", 3, "&grid order = 3: must be an integer in [1, 2]"), ("grid", "order", 1.5, "must be an integer in [1, 2]"),
    ("grid", "cells", [4], "&grid cells = 4: must be 2 to 3 values, each an integer in [1, inf)"), ("run", "title", 5, "&run title = 5: must be text"),
    ("run", "plane", "strian", "must be 'stress', 'strain' or 'axisymmetric'"), ("method", "courant", 1000.5, "must be in [0, 1000]"),
    ("energy_release", "energy_balance", "yes", "must be true or false"), ("method", "courant", True, "must be in [0, 1000]"),
    ("energy_release", "estimators", ["vcct", "vvct"], "values, each "), ("energy_release", "radii", [1e-3] * 11, "must be 0 to 10 values, each in (0, inf) [m]")])
def test_a_value_that_its_key_refuses(validator, group, key, value, said):
    model = package.Scene(INPUT / "dcb.nml")
    model[group][key] = value
    told, = model.mistakes()
    assert (told.group, told.key) == (group, key) and said in str(told)
    assert len(list(validator.iter_errors(as_f90nml_reads(model)))) == 1
    with pytest.raises(package.ModelError, match=f"&{group} {key}"):     # in the words of the program, with file and line
        package.run(model, progress=False)


@pytest.mark.parametrize(("group", "key", "value"), [("grid", "cell", 1e-99), ("grid", "cell", 1e99), ("run", "plane", "STRESS"), ("grid", "order", 1),
                                                     ("run", "stop_when", None), ("energy_release", "estimators", "vcct"), ("energy_release", "radii", [])])
def test_a_value_that_its_key_takes(group, key, value):
    model = package.Scene(INPUT / "dcb.nml")
    model[group][key] = value
    assert model.mistakes() == []


def test_groups_and_keys_that_are_missing():
    said = list(map(str, package.Scene(text="&run title = 'a' /\n&material name = 'b' young = 1.0 /").mistakes()))
    assert said == ["&grid: the group &grid is missing: the lattice of square root cells that the material moves through",
                    "&body: the group &body is missing: a piece of material, or a hole in one; bodies must not overlap",
                    "&run end_time: is missing: the run goes from time 0 to this time [s]",
                    "&material density: is missing: mass per undeformed volume [kg/m3]"]


def test_the_program_refuses_what_the_schema_does():
    """Random values of random keys; the other way round the program also knows what keys need of each other."""
    draw = random.Random(7)
    refused = 0
    for _ in range(40):
        model = package.Scene(draw.choice([path for path in MODELS if path.parent == INPUT]))
        group = draw.choice([group for group in model._written()])
        key = draw.choice(sorted(group._keys))
        group[key] = draw.choice([-1.0, 0.0, 0.3, 2, 1e9, "none", "path", True, [0.1, 0.2], [1, 2, 3]])
        if not model.mistakes():
            continue
        refused += 1
        with pytest.raises(package.ModelError, match=f"&{group._name}.* {key}"):
            model.check(warn=False)
    assert refused > 10
