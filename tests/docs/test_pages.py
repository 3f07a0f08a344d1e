"""The pages of docs/: links and anchors lead somewhere, formulas are such that GitHub and the site both show them, and the site is built from them."""

import html
import os
import re
import subprocess
import sys

import pytest
import yaml

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from api_pages import fetches  # noqa: E402
from site_hooks import anchor, mathml  # noqa: E402

DOCS = ROOT / "docs"
PAGES = [*sorted(DOCS.rglob("*.md")), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "bench/README.md", "python/README.md"))]
FENCE = re.compile(r"^ *(```+)(\w*)[^\n]*\n(.*?)^ *\1 *$", re.MULTILINE | re.DOTALL)
FORMULA = re.compile(r"\$`([^`\n]+)`\$")
EVERY_PAGE = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def prose(page):
    """The text of a page without fenced blocks."""
    return FENCE.sub("", page.read_text())


def anchors(page):
    """The anchors of the headings of a page, as GitHub makes them: a heading that comes again gets a number."""
    found = []
    for heading in re.findall(r"^#+ +(.+?)\s*$", prose(page), re.MULTILINE):
        name = anchor(re.sub(r"\[([^\]]*)\]\([^)]*\)|`", r"\1", heading))
        found.append(f"{name}-{found.count(name)}" if name in found else name)
    return set(found) | set(re.findall(r'<a (?:id|name)="([^"]+)"', page.read_text()))


@EVERY_PAGE
def test_links_lead_somewhere(page):
    text = re.sub(r"(`+)[^`\n]*?\1", "", prose(page))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, name = target.partition("#")
        place = page if not path else page.parent / path
        assert place.exists(), target
        assert not name or place.suffix != ".md" or name in anchors(place), target


@EVERY_PAGE
def test_formulas_are_such_that_github_and_the_site_show_them(page):
    """Blocks ```math and $`...`$: GitHub takes backslashes and asterisks out of formulas between bare dollars, and refuses some macros."""
    text = prose(page)
    rest = re.sub(r"(`+)[^`\n]*?\1", "", FORMULA.sub("", text))
    assert not re.search(r"\$\$|\$[^$\n]*[\\^_{][^$\n]*\$", rest)
    for formula in [*FORMULA.findall(text), *(block[2] for block in FENCE.findall(page.read_text()) if block[1] == "math")]:
        assert not re.search(r"\\(operatorname|[hv]?phantom|mbox|def|newcommand)\b", formula), formula
        shown = mathml(formula, "inline")
        assert "\\" not in re.sub(r"<[^>]+>", "", shown).replace("&#x0005C;", ""), formula


def test_the_site_has_every_page():
    class Loader(yaml.SafeLoader):
        """Reads names of procedures as text."""
    Loader.add_multi_constructor("tag:yaml.org,2002:python/name:", lambda loader, suffix, node: suffix)
    navigation = yaml.load((ROOT / "mkdocs.yml").read_text(), Loader)["nav"]

    def pages(part):
        return [part] if isinstance(part, str) else [page for item in (part.values() if isinstance(part, dict) else part) for page in pages(item)]
    assert sorted(pages(navigation)) == sorted(str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md"))


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, built as `make docs` builds it, without the pages of the sources."""
    pytest.importorskip("mkdocs", reason="mkdocs is not installed: tools/setup.sh docs")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", folder], cwd=ROOT,
                          env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.verify
def test_the_site_is_read_without_a_network(site):
    for page in site.rglob("*.html"):
        assert fetches(page.read_text()) == [], page
    assert sum(file.stat().st_size for file in site.rglob("*") if file.is_file()) < 15e6
    assert max(page.stat().st_size for page in site.rglob("*.html")) < 500e3


@pytest.mark.verify
def test_pages_of_the_site_can_be_read_by_all(site):
    """What an audit of accessibility asks of each page: its language, one first heading, no level left out, and words for each picture."""
    for page in site.rglob("*.html"):
        text = page.read_text()
        if "<article" not in text:  # of no page of docs/
            continue
        assert '<html lang="en"' in text and '<meta name="viewport"' in text, page
        levels = [int(level) for level in re.findall(r"<h([1-6])\b", text.partition("<article")[2])]
        assert levels[0] == 1 and levels.count(1) == 1, page
        assert all(b <= a + 1 for a, b in zip(levels, levels[1:])), page
        for image in re.findall(r"<img\b[^>]*>", text):
            assert re.search(r'alt="[^"]+"', image), f"{page}: {image}"
        for formula in re.findall(r"<math\b.*?</math>", text, re.DOTALL):
            assert "\\" not in html.unescape(re.sub(r"<[^>]+>", "", formula)), f"{page}: {formula}"
