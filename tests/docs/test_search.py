"""The search of the site leads from words of the trade to the page that answers: one of its first three hits.

The order of hits is that of the site's search (lunr, as Material for MkDocs sets it up): each page and each section is a document with a title and a text;
words begin with the words that are asked; BM25 in both fields, where a title counts a thousand times; a page of its own, and one that has all words, before.
"""

import math
import os
import re
import shutil
import subprocess
import sys
from collections import Counter

import pytest

from paths import ROOT

DOCS = ROOT / "docs"
HEADING = re.compile(r"^(#+) +(.+?)\s*$", re.MULTILINE)
FENCE = re.compile(r"^ *(```+)[^\n]*\n(.*?)^ *\1 *$", re.MULTILINE | re.DOTALL)
TITLE = 1000                # weight of a word in a title over one in a text
K, B = 1.2, 0.75            # of BM25
SEPARATOR = re.search(r"separator: '(.*)'", (ROOT / "mkdocs.yml").read_text())[1]
STOP = set("a able about across after all almost also am among an and any are as at be because been but by can cannot could dear did do does either else ever "
           "every for from get got had has have he her hers him his how however i if in into is it its just least let like likely may me might most must my "
           "neither no nor not of off often on only or other our own rather said say says she should since so some than that the their them then there these they "
           "this tis to too twas us wants was we were what when where which while who whom why will with would yet you your".split())

HITS = {  # words -> pages, of which one is among the first three hits
    "adhesive": "cohesion", "anisotropic": "inhomogeneous laws", "axisymmetric": "axisymmetric",
    "bimaterial": "inhomogeneous", "checkpoint": "checkpoints", "cohesive": "cohesion", "composite": "inhomogeneous", "close": "fatigue crack_contact", "contact": "contact crack_contact",
    "convergence": "verification tradeoff", "creep": "laws", "delamination": "cohesion inhomogeneous", "energy balance": "energy_balance",
    "energy release rate": "energy_release_rate", "error bar": "estimated_errors accuracy estimates", "exit code": "results", "fatigue life": "fatigue",
    "friction": "crack_contact", "glued": "cohesion", "HDF5": "results", "implicit": "implicit", "J integral": "energy_release_rate",
    "laminate": "inhomogeneous", "message": "messages", "mode mixity": "energy_release_rate", "orthotropic": "inhomogeneous laws",
    "ParaView": "pictures results", "Paris": "fatigue 20_fatigue", "penny": "axisymmetric", "plasticity": "laws", "pressure": "loaded_faces loads",
    "quadratic elements": "quadratic quadratic_cut quadratic_accuracy", "residual stress": "loaded_faces", "R-curve": "resistance", "rubber": "laws",
    "seam": "inhomogeneous", "stress intensity": "energy_release_rate", "T-stress": "t_stress", "thermal stress": "loaded_faces loads",
    "threads": "performance", "time step": "time_step", "toughness": "resistance growth", "units": "symbols", "units fatigue": "fatigue", "VCCT": "crack_closure",
    "viscoelastic": "laws", "weld": "inhomogeneous"}


def words(text):
    """The words of a text, in small letters, as they are indexed."""
    text = re.sub(r"\$`[^`]*`\$|!?\[([^\]]*)\]\([^)]*\)|<[^>]+>", r" \1 ", text)
    return [word for word in re.split(SEPARATOR, text.lower()) if word and word not in STOP]


def documents(path):
    """(whether it is the whole page, title, text) of a page and of each of its sections."""
    text = FENCE.sub(lambda match: re.sub(r"^#", " ", match[2], flags=re.MULTILINE), path.read_text(encoding="utf-8"))
    parts = HEADING.split(text)
    for k in range(1, len(parts), 3):
        yield k == 1, parts[k + 1], parts[k + 2]


class Index:
    """pages: of each document; fields: for title and text, words -> how often in each document."""

    def __init__(self, paths):
        found = [(path.stem, whole, words(title), words(text)) for path in paths for whole, title, text in documents(path)]
        self.pages = [(page, whole) for page, whole, _, _ in found]
        self.fields = [([Counter(row[k]) for row in found], [len(row[k]) for row in found]) for k in (2, 3)]
        self.known = {word for counts, _ in self.fields for count in counts for word in count}

    def hits(self, query):
        """Pages, best first."""
        asked, score = words(query), Counter()
        seen = {n: set() for n in range(len(self.pages))}
        for (counts, lengths), weight in zip(self.fields, (TITLE, 1)):
            mean = sum(lengths) / len(lengths)
            for term in asked:
                for word in (word for word in self.known if word.startswith(term)):
                    of = [n for n, count in enumerate(counts) if word in count]
                    rarity = math.log(1 + abs((len(counts) - len(of) + 0.5) / (len(of) + 0.5)))
                    for n in of:
                        seen[n].add(term)
                        score[n] += weight * rarity * (K + 1) * counts[n][word] / (K * (1 - B + B * lengths[n] / mean) + counts[n][word])
        best = Counter()
        for n, value in score.items():
            page, whole = self.pages[n]
            best[page] = max(best[page], value * (1 + (whole + (len(seen[n]) == len(set(asked))))**2))
        return [page for page, _ in best.most_common()]


@pytest.fixture(scope="module")
def index():
    return Index(sorted(DOCS.rglob("*.md")))


@pytest.mark.parametrize("query", HITS)
def test_words_of_the_trade_lead_to_their_page(index, query):
    assert set(index.hits(query)[:3]) & set(HITS[query].split()), index.hits(query)[:6]


@pytest.mark.parametrize(("query", "page"), [("fatigue life", "fatigue"), ("adhesive", "cohesion"), ("residual stress", "loaded_faces"), ("weld", "inhomogeneous"),
                                             ("HDF5", "results"), ("stress intensity", "energy_release_rate"), ("friction", "crack_contact")])
def test_the_page_of_a_word_comes_first(index, query, page):
    assert index.hits(query)[0] == page


def test_there_are_forty_words_and_the_pages_are_there():
    assert len(HITS) >= 40
    assert {page for pages in HITS.values() for page in pages.split()} <= {path.stem for path in DOCS.rglob("*.md")}


def test_a_title_counts_more_than_a_text_and_all_words_more_than_one(tmp_path):
    for name, text in {"a": "# Glue\n\nText.", "b": "# Other\n\nGlue glue glue and resin.", "c": "# Third\n\nresin\n\n## Glued joints\n\nof resin"}.items():
        (tmp_path / f"{name}.md").write_text(text)
    found = Index(sorted(tmp_path.glob("*.md")))
    assert found.hits("glue") == ["a", "c", "b"] and found.hits("resin glued") == ["c", "b"] and found.hits("water") == []


@pytest.mark.verify
@pytest.mark.skipif(not shutil.which("node"), reason="node is not installed")
def test_the_search_of_the_site_does_the_same(tmp_path):
    """By the worker of the site itself."""
    pytest.importorskip("mkdocs", reason="mkdocs is not installed: tools/setup.sh docs")
    subprocess.run([sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", tmp_path], cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=True)
    done = subprocess.run(["node", ROOT / "tests/docs/site_search.js", tmp_path, *HITS], capture_output=True, text=True, check=True)
    found = {query: hits for query, *hits in (line.split("\t") for line in done.stdout.splitlines())}
    assert {query: hits for query, hits in found.items() if not set(hits) & set(HITS[query].split())} == {} and len(found) == len(HITS)
