"""The pages are easy to read, as tools/readability.py counts: short sentences where one follows a page step by step, lines of prose up to 132 characters."""

import subprocess
import sys

import pytest

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from readability import LONG_LINE, measure, old_words, pages, paragraphs, sentences_of  # noqa: E402

MEAN, IN_ALL = 18, 15  # words in a sentence: of a page that one follows, of all pages
LONG_SENTENCES, TURNS_IN_ALL = 21, 64  # of all pages; these, and the next ones, may only fall
LONGEST = 2500         # words of a page with its tables, but for those that the program prints
PRINTED = ["benchmarks.md", "key_rules.md", "keys.md", "messages.md", "results.md"]  # tables of all keys, rules, messages, columns and benchmarks
FOLLOWED = [path for path in pages() if path.parent.name in ("tutorials", "how-to") or path.name in ("README.md", "CONTRIBUTING.md", "index.md")]


def each(paths):
    return [pytest.param(path, id=str(path.relative_to(ROOT))) for path in paths]


def test_lines_of_prose_are_short():
    """On one page as on all: not by page, as it takes no time and the first pages say nothing of the others."""
    wide = [str(page.relative_to(ROOT)) for page in pages() if measure(page).long_lines]
    assert not wide, f"lines of more than {LONG_LINE} characters"


@pytest.mark.parametrize("page", each(FOLLOWED))
def test_sentences_of_pages_that_one_follows_are_short(page):
    assert measure(page).mean < MEAN


def test_sentences_of_all_pages_are_short():
    measured = [measure(page) for page in pages()]
    assert sum(page.words for page in measured) / sum(len(page.sentences) for page in measured) < IN_ALL
    assert sum(len(page.long_sentences) for page in measured) <= LONG_SENTENCES
    assert sum(len(page.turns) for page in measured) <= TURNS_IN_ALL


@pytest.mark.parametrize("page", each(page for page in pages() if page.name not in PRINTED))
def test_pages_are_short(page):
    assert measure(page).all_words <= LONGEST


@pytest.mark.parametrize(("text", "turns"), [
    ("The error of K is larger than that of J.", 1), ("All but for one are stable; none is wrong.", 2), ("What is refused? The rule by which it is.", 2),
    ("The sum comes to 3.", 1), ("The error of J is smaller. None of the pages, and what it is for.", 0)])
def test_turns_that_hide_the_subject_are_counted(tmp_path, text, turns):
    (tmp_path / "page.md").write_text(text)
    assert len(measure(tmp_path / "page.md").turns) == turns


@pytest.mark.parametrize(("text", "sentences"), [
    ("One. Two words! Three?", ["One.", "Two words!", "Three?"]), ("See Fig. 3 and p. 2.2 of it. Good.", ["See Fig 3 and p 2.2 of it.", "Good."]),
    ("A [link here](a.md) and `code with blanks`.", ["A link here and name."]), ("# Heading\n\n| a | table |\n\n```\ncode\n```\n\nText.", ["Text."]),
    ("- one item\n- another\n  in two lines", ["one item", "another in two lines"]), ("1. first\n2. second", ["first", "second"]),
    ("![A picture](a.png)\n\n*Its words.*", ["Its words."]), ("Of $`a_i b`$ it follows.", ["Of formula it follows."])])
def test_sentences_are_found(text, sentences):
    assert [sentence for paragraph in paragraphs(text) for sentence in sentences_of(paragraph)] == sentences


def test_lines_words_and_old_words_are_counted(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Page\n\n" + "word " * 40 + ".\n\nThe audit keeps the scene.\n\n| " + "wide " * 40 + "|\n\n```\n" + "code " * 40 + "\n```\n")
    found = measure(page)
    assert (found.words, len(found.sentences), len(found.long_sentences), found.long_lines, found.wide_lines) == (45, 2, 1, 1, 2)
    assert found.old_words == ["audit", "scene"] and old_words().findall("a residual; a mistake") == ["mistake"]


def test_the_table_has_a_row_a_page_and_one_of_all():
    done = subprocess.run([sys.executable, ROOT / "tools/readability.py", ROOT / "README.md", "--long"], capture_output=True, text=True)
    lines = done.stdout.splitlines()
    assert done.returncode == 0 and lines[1].startswith("README.md ") and lines[2].startswith("all ") and lines[1].split()[1:] == lines[2].split()[1:]
