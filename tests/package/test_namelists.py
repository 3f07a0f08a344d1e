"""What f90nml reads and writes is the same model: the namelists of this repository, and what the program prints."""

import re

import pytest

import hampm as package
from paths import INPUT, ROOT

FENCED = re.compile(r"^```(?:fortran|text)?\n(&\w.*?)^```", re.MULTILINE | re.DOTALL)
FILES = sorted(path for folder in (INPUT, ROOT / "tests/cases", ROOT / "tests/regression", ROOT / "docs") for path in folder.rglob("*.nml"))
OF_PAGES = [(f"{path.name} {number}", text) for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
            for number, text in enumerate(FENCED.findall(path.read_text()))]
NAMELISTS = [pytest.param(path.read_text(), id=str(path.relative_to(ROOT))) for path in FILES] + [pytest.param(text, id=name) for name, text in OF_PAGES]


def as_used(hampm, text, name="case.nml"):
    """What --check prints of a namelist, or why it is refused, without where and the times that steps have taken, numbers in one form."""
    (hampm.folder / name).write_text(text)
    run = hampm("--check", "--quiet", name)
    return re.sub(r"(about|took) [\d.]+ \w+", "", run.stdout) or re.sub(r"(?<![\w.])-?\d+(\.\d*)?(e-?\d+)?\b", lambda found: repr(float(found[0])), re.sub(rf"{name}(:\d+)?", "", run.stderr))


def through_f90nml(text):
    return str(package.Scene(text=text))


def test_there_are_namelists():
    assert len(FILES) > 60 and len(OF_PAGES) > 3


@pytest.mark.parametrize("text", NAMELISTS)
def test_a_namelist_comes_back_from_f90nml_as_the_same_model(hampm, text):
    assert as_used(hampm, through_f90nml(text)) == as_used(hampm, text)
    assert package.Scene(text=through_f90nml(text)) == package.Scene(text=text)


def test_template_and_check_come_back_with_the_same_results(hampm):
    """The template runs; what --check prints of it, and both through f90nml, give the same history to the byte."""
    template = hampm("--template").stdout
    printed = as_used(hampm, template)
    short = ("--set", "run.end_time=2e-5", "--set", "output.history_interval=1e-7", "--set", "output.file=result.h5", "--force", "--quiet")
    results = []
    for text in (template, printed, through_f90nml(template), through_f90nml(printed)):
        (hampm.folder / "case.nml").write_text(text)
        assert hampm("case.nml", *short).returncode == 0
        results.append(package.History(hampm.folder / "result.h5"))
    assert all(package.compare(results[0], other, exact=True) for other in results[1:])


MODEL = """&run end_time = 1e-6 {run} /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 10, 10 /
&material name = 'a'  young = 1e9  density = 1000 {material} /
&body material = 'a'  lower = 0.0, 0.0  upper = 5e-3, 5e-3  {body} /
"""


@pytest.mark.parametrize("unset", [{"material": "moduli ="}, {"material": "moduli = ,"}, {"material": "moduli = , ,"}, {"material": "moduli = 2*"},
                                   {"run": "plane = ,"}, {"run": "plane ="}, {"run": "thickness = , title ="}, {"body": "velocity = ,"},
                                   {"body": "velocity = 2*"}, {"body": "points = , center = , hole = , spin ="}])
def test_null_values_are_unset(hampm, unset):
    empty = {"run": "", "material": "", "body": ""}
    assert as_used(hampm, MODEL.format(**empty | unset)) == as_used(hampm, MODEL.format(**empty))


def test_a_null_value_among_others_is_the_default(hampm):
    """As the reader of Fortran leaves what an item had before."""
    with_null, without = (as_used(hampm, MODEL.format(run="", material="", body=body)) for body in ("velocity = , 2.0", "velocity = 0.0, 2.0"))
    assert with_null == without and "velocity = 0.0, 2.0" in without


@pytest.mark.parametrize(("text", "reason"), [
    (MODEL.format(run="", material="young_1 = ", body="").replace("1e9", ""), "young"),
    (MODEL.format(run="", material="", body="").replace("1000", ","), "density: is missing"),
    (MODEL.format(run="", material="law = 'viscoelastic' poisson = 0.3 moduli = 1e8, , 1e7 relaxation_times = 1.0, 2.0, 3.0", body=""),
     "is missing and has no default")])
def test_a_null_value_of_what_is_needed_is_an_error(hampm, text, reason):
    assert reason in as_used(hampm, text)
