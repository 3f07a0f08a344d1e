"""The page of promises: each number stands on the page that is named, and each test or part of a release that holds one is there."""

import re
import tomllib

import pytest

from paths import ROOT

PAGE = ROOT / "docs/evidence/promises.md"
PARTS = {part["name"] for part in tomllib.loads((ROOT / "tools/release_parts.toml").read_text())["part"]}
HEAD = ["promise", "number", "page", "held by", "fails beyond"]


def rows():
    found = []
    for table in re.findall(r"(?:^\|.*\n)+", PAGE.read_text(), re.MULTILINE):
        head, _, *lines = ([cell.strip() for cell in line.strip().strip("|").split("|")] for line in table.splitlines())
        found += lines if head == HEAD else []
    return found


ROWS = rows()


def test_there_are_promises_of_each_kind():
    assert len(ROWS) > 35 and all(len(row) == len(HEAD) for row in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_a_number_stands_on_its_page(row):
    page = (PAGE.parent / re.search(r"\]\((.*)\)", row[2])[1]).resolve()
    text = " ".join(page.read_text().replace("*", "").split())
    for number in row[1].split(", "):
        assert re.search(rf"(?<![\d.]){re.escape(number)}(?!\d|\.\d)", text), number


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_what_holds_it_is_there(row):
    tests = re.findall(r"`(\w+)::(\w+)`", row[3])
    for file, name in tests:
        [path] = (ROOT / "tests").rglob(f"{file}.py")
        assert re.search(rf"^def {name}\(", path.read_text(), re.MULTILINE), f"{file}::{name}"
    parts = set(re.findall(r"\*([\w-]+)\*", row[3]))
    assert parts - {"nothing"} <= PARTS and bool(tests or parts) and ("nothing" not in parts or not tests)
    assert row[4] or not tests, "a test fails beyond something"
