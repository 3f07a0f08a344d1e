"""The table of lessons says how long each takes."""

import sys

import pytest

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

import lesson_times  # noqa: E402


def test_each_lesson_has_its_times():
    """As many words as now, to a tenth, and what the lesson says itself."""
    rows = [[word.strip() for word in line.split("|")[1:-1]] for line in lesson_times.TABLE.search(lesson_times.PAGE.read_text())[2].splitlines()[2:]]
    pages = lesson_times.pages()
    assert [int(row[0]) for row in rows] == list(pages)
    for (_, words, reading, seconds, said), page in zip(rows, pages.values()):
        assert int(words) == pytest.approx(lesson_times.words(page), rel=0.1), f"{page.stem}: run tools/lesson_times.py"
        assert int(reading) == round(int(words) / lesson_times.WORDS_A_MINUTE) and 0 < float(seconds) < 300 and said == lesson_times.said(page)
