"""Every procedure, type and module of src/ says above itself what it is; the API pages are made of that."""

import re

import pytest

from paths import ROOT

DEFINITION = re.compile(r"(?!end|!)(?:(?:pure|elemental|recursive|integer|logical|character|real|type)(?:\([^)]*\))? +)*"
                        r"(?:(?:subroutine|function|module|program) (?!procedure\b)(\w+)|type(?:, *\w+)* *:: *(\w+))")
SOURCES = sorted((ROOT / "src").glob("**/*.f90"))
FOREIGN = re.compile(r"^ *interface *$.*?^ *end interface *$", re.MULTILINE | re.DOTALL)


def undocumented(source):
    """Names of what a source defines without a docstring; interfaces of foreign procedures need none."""
    lines = FOREIGN.sub("", source).splitlines()
    found = [(DEFINITION.match(line.strip()), before.strip()) for before, line in zip(["", *lines], lines)]
    return [name[1] or name[2] for name, before in found if name and not before.startswith("!>")]


@pytest.mark.parametrize(("source", "missing"), [("!> What.\nmodule a\n", []), ("module a\n", ["a"]),
                                                 ("!> What.\npure real(dp) function f(x)\nend function f\nsubroutine s()", ["s"]),
                                                 ("type :: t\nend type t\ntype(t) :: v\n", ["t"]),
                                                 ("interface\n subroutine c()\n end subroutine c\nend interface\n", [])])
def test_definitions_without_a_docstring_are_found(source, missing):
    assert undocumented(source) == missing


def test_everything_has_a_docstring():
    assert len(SOURCES) > 90
    assert {path.name: names for path in SOURCES if (names := undocumented(path.read_text()))} == {}


def test_no_docstring_begins_with_a_word_and_a_colon():
    """ford takes such a line for metadata and leaves it out."""
    begin = re.compile(r"^(?! *!>).*\n *!> [\w-]+: ", re.MULTILINE)
    assert [path.name for path in SOURCES if begin.search("\n" + path.read_text())] == []


def test_lines_are_short():
    """As CONTRIBUTING.md says, comments too."""
    long = [f"{path.name}:{number}" for path in SOURCES for number, line in enumerate(path.read_text().splitlines(), 1) if len(line) > 132]
    assert long == []


def test_headers_of_modules_are_short():
    """A header says what a module is for and where its theory stands; the theory itself is in docs/explanation."""
    heads = {path.name: len(re.match(r"(?:!.*\n)*", path.read_text())[0].splitlines()) for path in SOURCES}
    assert {name: lines for name, lines in heads.items() if lines > 12} == {}
