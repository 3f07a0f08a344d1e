"""The evidence pages: tables say where they come from, and numbers that a test measures are those that it measured.

A table is generated, between two lines of comment, or has a line `<!-- source: ... -->` before it that names what gives it: files, folders and targets of
make that there are. Numbers in tables written by hand are held to docs/evidence/verification_values.csv by `TIES`.
"""

import csv
import re
import sys

import pytest

from paths import BENCH, ROOT

sys.path.insert(0, str(BENCH))

import extremes  # noqa: E402

FOLDER = ROOT / "docs/evidence"
PAGES = sorted(FOLDER.glob("*.md"))
MEASURED = re.compile(r"\d\.\d|\d %|\de-?\d")  # a number that somebody measured
LONGEST = 20, 132  # rows of a table, characters of a line of prose


def blocks(page):
    """(line before it that is not empty, rows) of each table."""
    found, before, rows = [], "", []
    for line in [*re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL).splitlines(), ""]:
        if line.startswith("|"):
            rows.append(line)
            continue
        if rows:
            found.append((before, rows))
            rows = []
        before = line or before
    return found


def cells(line):
    return [cell.strip(" *") for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_tables_say_where_they_come_from(page):
    text, targets = page.read_text(), re.findall(r"^(\w+):", "\n".join((ROOT / name).read_text() for name in ("Makefile", "bench/Makefile")), re.MULTILINE)
    for before, rows in blocks(page):
        if before.startswith("<!-- ") and (f"<!-- end of {before[5:-4]} -->" in text or before.startswith("<!-- make verify: begin")):
            continue
        if rows[0].startswith("| other tests that take long |"):
            continue  # the second table of `make verify`
        if before.startswith("<!-- source: "):
            for name in re.findall(r"[\w./]+/[\w./]+", before):
                assert (ROOT / name).exists() or name == "build/release/hampm" or name.startswith("build/"), f"{before}: {name}"
            for words in re.findall(r"make ((?:-C bench )?[\w ]+)", before):
                assert set(words.removeprefix("-C bench ").split()) <= {*targets, "seed", "100"}, before
            continue
        measured = [line for line in rows[2:] if any(MEASURED.search(re.sub(r"`[^`]*`|\[[^\]]*\]\([^)]*\)", "", cell)) for cell in cells(line)[1:])]
        assert measured == [], f"no source: {rows[0]}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_tables_and_lines_are_short_and_the_result_comes_first(page):
    text = page.read_text()
    assert all(len(rows) - 2 <= LONGEST[0] for _, rows in blocks(page))
    assert [line for line in text.splitlines() if len(line) > LONGEST[1] and not line.startswith("|")] == []
    assert re.match(r"# .+\n\n(?:The paper's|This page) ", text) or "This page is for " in text[:400]
    first = text.partition("\n## ")[0]
    assert "\n|" in first or "](../images/" in first, "no table or picture before the first section"
    assert "To run it again" in text and "```" in text


ERROR = "error"   # percent of the asked value; else what the measured value is multiplied by
TIES = [  # page, first cells of the row, column (and which of several numbers in it), run, quantity, factor
    *[("verification", (f"refined, {plane}",), column, f"dcb_static {plane}-refined", what, factor) for plane in ("stress", "strain") for column, what, factor in [
        ("VCCT", "VCCT, G/G_ref", ERROR), ("J", "J, G/G_ref", ERROR), ("K_I^2/E'", "stress intensity factor, K_I**2/(E' G_ref)", ERROR),
        ("spread of J, 4 to 8 mm", "spread of J over the domains of 4, 6 and 8 mm, over J", 100)]],
    *[("verification", (row,), column, f"dcb_dynamic {run}", what, factor)
      for row, run in [("uniform, none", "undamped"), ("uniform, alpha = 10000 1/s", "alpha10000"), ("refined, none", "undamped-refined"),
                       ("refined, alpha = 10000 1/s", "alpha10000-refined")]
      for column, what, factor in [("VCCT", "VCCT: rms difference below 50 kHz over the peak, 0 to 0.6 ms", 100), ("J", "J: rms difference below 50 kHz over the peak, 0 to 0.6 ms", 100),
                                   ("K_I^2/E'", "K_I**2/E': rms difference below 50 kHz over the peak, 0 to 0.6 ms", 100),
                                   ("largest spread of J", "largest spread of J over the domains of 4, 6 and 8 mm, over the peak of J", 100)]],
    ("verification", ("uniform, none",), "f_1 (2549.4 Hz)", "dcb_dynamic undamped", "first natural frequency [Hz]", ERROR),
    ("verification", ("refined, none",), "f_1 (2549.4 Hz)", "dcb_dynamic undamped-refined", "first natural frequency [Hz]", ERROR),
    *[("verification", (row,), column, f"freund {run}", what, 100) for row, run in [("0.1", "0.1mm"), ("0.2, refined once, 12 rings", "refined")]
      for column, what in [("error of K_I, rms [%]", "rms relative error of K_I, 1.2 to 2.6 arrival times"), ("spread of J [%]", "spread of J over four radii, over the largest J")]],
    *[("verification", (row,), column, f"chen {run}", what, 100) for row, run in [("0.2", "0.2mm"), ("0.1", "0.1mm"), ("0.1, refined once, 12 rings", "refined")]
      for column, what in [("error of K_I, rms [%]", "rms error of K_I over 0.2 us, over the peak"), ("largest [%]", "largest error of K_I over 0.2 us, over the peak"),
                           ("spread of J [%]", "spread of J over four radii, over the largest J")]],
    *[("verification_modes", ("one", "0.625"), column, "mixed_mode mixed-0.625mm", what, ERROR) for column, what in [
        ("G_I, G_II by VCCT#0", "G_I, VCCT"), ("G_I, G_II by VCCT#1", "G_II, VCCT"), ("J", "J"), ("G_I, G_II by J#0", "G_I, part of J"), ("G_I, G_II by J#1", "G_II, part of J"),
        ("K_I, K_II#0", "K_I"), ("K_I, K_II#1", "K_II")]]]


def shown(page, label, column):
    """The texts that stand in the column of the rows that begin with these cells, in tables that have such a column."""
    name, _, part = column.partition("#")
    for _, rows in blocks(FOLDER / f"{page}.md"):
        head = cells(rows[0])
        for row in map(cells, rows[2:]):
            if name in head and tuple(row[:len(label)]) == label:
                yield row[head.index(name)].split(", ")[int(part or 0)]


@pytest.mark.parametrize(("page", "label", "column", "run", "quantity", "factor"), TIES, ids=[f"{tie[0]}-{tie[3]}-{tie[4]}" for tie in TIES])
def test_a_number_in_a_table_is_that_which_was_measured(page, label, column, run, quantity, factor):
    with open(FOLDER / "verification_values.csv", newline="") as file:
        [row] = [row for row in csv.DictReader(file) if (row["run"], row["quantity"]) == (run, quantity)]
    measured, asked = float(row["measured"]), float(row["asked"])
    value = 100 * (measured / asked - 1) if factor == ERROR else factor * measured
    texts = list(shown(page, label, column))
    assert texts
    digits = [len(text.partition(".")[2]) for text in texts]
    assert any(abs(float(text) - value) <= 0.5001 * 10**-d for text, d in zip(texts, digits)), f"{texts} for {value:.4g}"


def test_the_atlas_of_extremes_is_what_the_writer_makes_of_the_files_beside_it(tmp_path):
    def table(name):
        with open(FOLDER / f"stability_{name}.csv", newline="") as file:
            return list(csv.reader(file))
    tables = {name: table(name) for name in ("atlas", "quantities", "messages")}
    page = (FOLDER / "stability.md").read_text()
    assert extremes.written(tables, page, tmp_path) == page
    assert {row[0] for row in tables["atlas"][1:]} == {row[0] for row in tables["quantities"][1:]} == set(extremes.PARTS)
    defects = sum(int(row[tables["atlas"][0].index("defect")]) for row in tables["atlas"][1:])
    assert defects == len(extremes.KNOWN)
    total, stable = (sum(int(row[k]) for row in tables["atlas"][1:]) for k in (1, 2))
    assert f"of {total} small models" in " ".join(page.split()) and f"{stable} ran" in " ".join(page.split())
