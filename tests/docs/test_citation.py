"""The version is the same everywhere, and the citation file has what its format asks for."""

import json
import re

import pytest

from paths import ROOT

CITATION = (ROOT / "CITATION.cff").read_text()
VERSION = (ROOT / "VERSION").read_text().splitlines()[0]


def value(key):
    """The value of a key of the citation at the outermost level."""
    return re.search(rf"^{key}: *(.*)$", CITATION, re.MULTILINE)[1]


def test_citation_has_the_required_keys():
    assert value("cff-version") == "1.2.0"
    assert value("message") and value("title")
    assert re.search(r"^authors:\n  - name: \S", CITATION, re.MULTILINE)


def test_citation_names_this_version_and_its_licence():
    assert value("version") == VERSION
    assert value("license") == (ROOT / "LICENSE").read_text().split()[0] == "MIT"


def test_metadata_of_the_software_agree_with_the_citation():
    """codemeta.json, which catalogues of software read."""
    found = json.loads((ROOT / "codemeta.json").read_text())
    assert (found["version"], found["dateModified"]) == (VERSION, value("date-released")) and found["license"].endswith("/MIT")
    assert all((ROOT / found[name]).exists() for name in ("readme", "buildInstructions", "softwareHelp"))


@pytest.mark.parametrize("file, pattern", [
    ("python/src/hampm/__init__.py", r'^__version__ = "(.*)"$'), ("recipes/conda/recipe.yaml", r'^  version: "(.*)"$'),
    ("recipes/spack/package.py", r'^    version\("(.*)"\)$'), ("recipes/spack/package.py", r"hampm@([\w.]+)")])
def test_what_names_the_version_names_this_one(file, pattern):
    assert re.findall(pattern, (ROOT / file).read_text(), re.MULTILINE) == [VERSION]


def test_the_package_takes_its_version_from_the_file_of_the_repository():
    text = (ROOT / "python/pyproject.toml").read_text()
    assert 'dynamic = ["version"]' in text and '[tool.hatch.version]\npath = "../VERSION"' in text and VERSION not in text
    pattern = re.search(r"^pattern = '(.*)'$", text, re.MULTILINE)[1]
    assert re.search(pattern, (ROOT / "VERSION").read_text(), re.MULTILINE)["version"] == VERSION


def test_changelog_begins_with_this_version():
    """Changes that are not released yet may stand above."""
    versions = re.findall(r"^## \[(.*?)\](?: - (.*))?$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert [entry for entry in versions if entry[0] != "Unreleased"][0] == (VERSION, value("date-released"))


def test_contributing_names_files_that_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    for name in re.findall(r"\b(?:(?:python/)?src|tests|tools|docs)/[\w/-]+(?:\.(?:f90|py|sh|md|nml|toml))?(?![\w/<*.])", text):
        assert (ROOT / name).exists(), name


# --- the paper --------------------------------------------------------------------------------------------------------

PAPER, BIBLIOGRAPHY = ((ROOT / "paper" / name).read_text() for name in ("paper.md", "paper.bib"))
NUMBERS = [("evidence/estimates.md", ["249", "2.4 times", "96 %"]), ("how-to/accuracy.md", ["121 of 121", "141 of 143"]),
           ("evidence/benchmarks.md", ["| numbers | 344 |", "| suites | 33 |", "together | 304 |", "by hampm | 1 |"]),
           ("evidence/performance.md", ["beyond 2.4 times as much", "to 0.05 % hampm takes 0.9 of", "takes 3 ns a particle"])]


def test_the_paper_has_the_form_of_its_journal():
    """Of JOSS: a head, two sections by name, 250 to 1000 words, and a list of references that are all cited."""
    head, _, body = PAPER.removeprefix("---\n").partition("\n---\n")
    assert all(re.search(rf"^{key}:", head, re.MULTILINE) for key in ("title", "tags", "authors", "affiliations", "date", "bibliography"))
    assert {"Summary", "Statement of need", "References"} <= set(re.findall(r"^# (.*)$", body, re.MULTILINE))
    assert 250 <= len(body.split()) <= 1000
    assert set(re.findall(r"@(\w+(?::\d+)?)", body)) == set(re.findall(r"^@\w+\{([\w:]+),", BIBLIOGRAPHY, re.MULTILINE))


@pytest.mark.parametrize(("page", "numbers"), NUMBERS, ids=[page for page, _ in NUMBERS])
def test_numbers_of_the_paper_stand_on_their_pages(page, numbers):
    text = " ".join((ROOT / "docs" / page).read_text().split())
    assert [number for number in numbers if number not in text] == []
    digits = set(re.findall(r"\d[\d.]*\d|\d", " ".join(numbers)))
    assert digits - set(re.findall(r"\d[\d.]*\d|\d", PAPER.replace("four of them", "4"))) == set()
