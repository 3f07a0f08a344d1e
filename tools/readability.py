"""How easily the pages are read: of each page its words, the length of its sentences, long lines, words of version 1, and turns of phrase that hide the subject.

    python tools/readability.py                     all pages of docs/, README.md and CONTRIBUTING.md
    python tools/readability.py PAGE.md ...         these pages
    python tools/readability.py --long PAGE.md      the long sentences of a page too

Prose is what stands outside of code, tables, headings and formulas. A name in backticks counts as one word, and a link as the words that it
shows. A sentence ends with . ! or ? before a blank, and with its paragraph or item of a list. Words of version 1 are those of the
left column of docs/reference/glossary.md that are no names in backticks. `TURNS` are turns of phrase whose noun stands elsewhere, or in no place.
`all words` are those of the whole file, tables, code and formulas too, between blanks.
"""

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
GLOSSARY = ROOT / "docs/reference/glossary.md"
LONG_SENTENCE, LONG_LINE = 30, 132  # words, characters
FENCE = re.compile(r"^ *(```+)[^\n]*\n.*?^ *\1 *$", re.MULTILINE | re.DOTALL)
ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|et al|cf|vs|pp?|Figs?|Eqs?|Nos?|Dr|ca)\.(?=\s)")
TURNS = re.compile(r"\b(?:that|those) of\b|\bbut for\b|\b(?:by|of|to) which\b|\bcom(?:es|ing|e) to\b(?! rest)|(?:^|[.;:,] )what (?:is|was|are|has|have)\b|"
                   r"\bnone(?! of\b)|\bthat is to say\b", re.IGNORECASE)
LEFT_CELL = re.compile(r"^\| *([^|]+?) *\|", re.MULTILINE)


@dataclass
class Page:
    """What is counted of a page."""

    words: int
    sentences: list   # of words each, with the text
    long_lines: int   # of prose, but for pictures, whose words cannot be wrapped
    wide_lines: int   # of tables, code and pictures
    old_words: list
    turns: list
    all_words: int    # of the file

    @property
    def mean(self):
        """Mean number of words in a sentence."""
        return self.words / max(1, len(self.sentences))

    @property
    def long_sentences(self):
        return [text for text in self.sentences if words_in(text) > LONG_SENTENCE]


def words_in(text):
    """Number of words: what is between blanks and has a letter or a digit."""
    return sum(bool(re.search(r"\w", word)) for word in text.split())


def paragraphs(text):
    """The paragraphs and items of lists of a page, as plain text."""
    text = re.sub(r"<!--.*?-->", "", FENCE.sub("\n\n", text), flags=re.DOTALL)
    text = re.sub(r"^( *)([-*+]|\d+\.) +", r"\n\n", text, flags=re.MULTILINE)      # an item begins a paragraph
    for part in re.split(r"\n\s*\n", text):
        lines = [line.strip() for line in part.splitlines() if not re.match(r" *(\||#|<|!\[|    )", line)]
        if plain := shown(" ".join(lines)):
            yield plain


def shown(text):
    """What a reader sees of a text: names in backticks as one word, links as their words."""
    text = re.sub(r"\$`[^`]*`\$", "formula", text)
    text = re.sub(r"(`+)[^`]*?\1", "name", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"[*_]{1,2}(?=\S)|(?<=\S)[*_]{1,2}", "", text).strip()


def sentences_of(paragraph):
    """The sentences of a paragraph."""
    text = ABBREVIATIONS.sub(r"\1", paragraph)
    return [part for part in re.split(r"(?<=[.!?])[)\"'”]*\s+", text) if words_in(part)]


def old_words():
    """A pattern of the words in the left column of the glossary."""
    cells = [cell for cell in LEFT_CELL.findall(GLOSSARY.read_text()) if cell != "version 1" and "---" not in cell]
    words = {word.strip() for cell in cells for word in re.sub(r"\([^)]*\)", "", cell).split(",") if "`" not in word}
    return re.compile(r"\b(" + "|".join(sorted(map(re.escape, filter(None, words)), key=len, reverse=True)) + r")\b", re.IGNORECASE)


def is_table(line):
    return line.lstrip().startswith("|")


def measure(path, old=None):
    """What is counted of a page."""
    text = path.read_text()
    prose = list(paragraphs(text))
    sentences = [sentence for paragraph in prose for sentence in sentences_of(paragraph)]
    outside = FENCE.sub("", text).splitlines()
    long_lines = sum(len(line) > LONG_LINE for line in outside if not is_table(line) and not line.startswith("!["))
    wide = sum(len(line) > LONG_LINE for line in text.splitlines()) - long_lines
    found = [] if path.resolve() == GLOSSARY else (old or old_words()).findall(" ".join(prose))
    turns = TURNS.findall("\n".join(sentences))
    return Page(sum(map(words_in, sentences)), sentences, long_lines, wide, found, turns, len(text.split()))


def pages():
    """All pages that are read by people."""
    return [*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]


def table(measured):
    """The table as lines of text: a row for each page, and one for all."""
    yield f"{'page':44} {'words':>6} {'a sentence':>10} {f'above {LONG_SENTENCE}':>9} {'long lines':>10} {'wide tables':>11} {'old words':>9} {'turns':>5} {'all words':>9}"
    rows = [(str(path), page.words, len(page.sentences), len(page.long_sentences), page.long_lines, page.wide_lines, len(page.old_words), len(page.turns), page.all_words)
            for path, page in measured]
    for name, words, sentences, *rest in [*rows, ("all", *map(sum, zip(*(row[1:] for row in rows))))]:
        yield f"{name:44} {words:6} {words / max(1, sentences):10.1f} {rest[0]:9} {rest[1]:10} {rest[2]:11} {rest[3]:9} {rest[4]:5} {rest[5]:9}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", metavar="PAGE.md", nargs="*", type=Path)
    parser.add_argument("--long", action="store_true", help="print the sentences that are long, or have such a turn")
    options = parser.parse_args()
    if missing := [path for path in options.pages if not path.is_file()]:
        sys.exit(f"{missing[0]}: no such page")
    old = old_words()
    chosen = [path.resolve() for path in options.pages] or pages()
    measured = [(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path, measure(path, old)) for path in chosen]
    print(*table(measured), sep="\n")
    for path, page in measured if options.long else ():
        shown_ones = [text for text in page.sentences if text in page.long_sentences or TURNS.search(text)]
        print(*(f"{path}: {words_in(text)} words: {text}" for text in shown_ones), sep="\n", end="\n" if shown_ones else "")


if __name__ == "__main__":
    main()
