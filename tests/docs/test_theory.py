"""The theory names files and procedures that there are, and its drawings are those of the script."""

import re
import sys

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from theory_figures import FIGURES, FOLDER  # noqa: E402

TABLE = (ROOT / "docs/explanation/procedures.md").read_text()


def test_every_equation_is_where_the_notes_say():
    rows = [re.findall(r"`([^`]+)`", line) for line in TABLE.splitlines() if "`src/" in line]
    assert len(rows) > 30
    for row in rows:
        source = "".join((ROOT / word).read_text() for word in row if word.startswith("src/"))
        for name in row:
            if not name.startswith("src/"):
                assert re.search(rf"^ *(?!end|!)[\w (),]*\b(subroutine|function) {name}\b", source, re.MULTILINE), f"{name} in {row}"


def test_every_source_file_that_a_page_names_exists():
    """Or is made by a change that the page shows, or by a solution of an exercise."""
    solved = {name for patch in (ROOT / "docs").rglob("*.patch") for name in re.findall(r"^\+\+\+ b/(\S+)$", patch.read_text(), re.MULTILINE)}
    for page in sorted((ROOT / "docs").rglob("*.md")):
        made = solved | set(re.findall(r"(?:^```(?:fortran|toml) |\[`)(src/\S+?)(?:$|`\]\(extending/)", page.read_text(), re.MULTILINE))
        for name in re.findall(r"\b(?:(?:python/)?src|tests|bench|postprocess|input|tools)/[\w/]+\.(?:f90|py|nml|toml|csv|sh)\b", page.read_text()):
            assert name in made or (ROOT / name).exists(), f"{page.name}: {name}"


def test_the_drawings_are_those_of_the_script():
    for name, draw in FIGURES.items():
        assert (FOLDER / f"{name}.svg").read_text(encoding="utf-8") == draw().svg(), "tools/theory_figures.py"
        assert any(f"](../images/{name}.svg)" in page.read_text() for page in (ROOT / "docs/explanation").glob("*.md"))
