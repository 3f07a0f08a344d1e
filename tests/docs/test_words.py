"""The sources, messages and pages have the terms of the field, not the words that version 1 had of its own.

The words are the left column of the glossary that the project made for version 2 (docs/reference/glossary.md gives the term for each).
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted((ROOT / "src").rglob("*.f90"))
PAGES = [*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]

# Parts of identifiers, between underscores.
IN_NAMES = {"scene", "scenes", "whereabouts", "guards", "caveats", "mistake", "mistakes", "doubt", "doubts", "setback", "crowded",
            "sheet", "sheets", "twist", "twists", "pin", "pins", "driven", "bond", "bonds", "leavers", "remember", "remembers",
            "remembering", "said", "told", "views", "rubber", "settle", "lag", "past", "litter"}
# Whole identifiers.
NAMES = {"conjugate_stress", "conjugate_change", "out_of_balance", "distance_from_rest", "drive_t", "on_trial", "let_go", "lets_go",
         "outer_nodes", "needs_t", "keep", "look_at", "hosts", "closing_t", "at_rest"}
# Words and phrases of messages, comments and pages.
PHRASES = (r"scenes?|mistakes?|mistaken|caveats|whereabouts|sheets?|crowded|leavers|setback|bonds?|let go|lets go|out of balance|"
           r"outer nodes?|foretold|foretell|through each other|by luck|must be others than|must be left out of|go(es)? with \S+ only|"
           r"has no meaning|have no meaning|comes at once|laws that remember|sudden strains|moduli at once|modulus at once|"
           r"energy audit|keeps? itself")

# Where a word stands for another thing, with the reason.
NAMES_ALLOWED = {
    "litter_t": "the children of one particle, before they are in the arrays", "litter": "the same",
    "a_pin_without_an_axis": "a feature, by its name in messages",
}
FILES_ALLOWED = {
    "docs/reference/glossary.md": "is the table of these words",
}
TEXTS_ALLOWED = {
    "scene": "is the name of an item in checkpoints",
}


def parts(line):
    """(code, texts, comment) of a line of Fortran."""
    code, texts, rest = "", [], line
    while found := re.search(r"['\"!]", rest):
        code, rest = code + rest[:found.start()], rest[found.start():]
        if rest[0] == "!":
            return code, texts, rest
        end = rest.find(rest[0], 1)
        texts, rest = [*texts, rest[1:end]], rest[end + 1:]
    return code + rest, texts, ""


def prose_of(page):
    """(number, line) of a page without code: names in it are held where they stand."""
    fenced = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        fenced ^= line.startswith("```")
        if not (fenced or line.startswith("    ")):
            yield number, re.sub(r"`[^`]*`|\]\([^)]*\)", "", line)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT / "src")))
def test_a_source_has_the_terms_of_the_field(path):
    """In its names, its messages and its comments."""
    found = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        code, texts, comment = parts(line)
        for name in re.findall(r"[a-z]\w*", code.lower()):
            if name not in NAMES_ALLOWED and (name in NAMES or IN_NAMES & set(name.split("_"))):
                found.append(f"{number}: {name}")
        for text in [*texts, comment]:
            if (match := re.search(rf"\b({PHRASES})\b", text, re.IGNORECASE)) and text not in TEXTS_ALLOWED:
                found.append(f"{number}: {match[0]!r} in {text.strip()}")
    assert found == [], "docs/reference/glossary.md has the term for each"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_page_has_the_terms_of_the_field(path):
    """In its prose, headings and tables."""
    name = str(path.relative_to(ROOT))
    if name in FILES_ALLOWED:
        return
    found = [f"{number}: {match[0]!r}" for number, line in prose_of(path)
             if (match := re.search(rf"\b({PHRASES})\b", line, re.IGNORECASE))]
    assert found == [], "docs/reference/glossary.md has the term for each"


def test_names_of_sources_have_the_terms_of_the_field():
    assert [path.name for path in SOURCES if path.stem in NAMES or IN_NAMES & set(path.stem.split("_"))] == []
