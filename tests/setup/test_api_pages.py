"""Pages of the source fetch nothing from elsewhere."""

import sys

import pytest

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from api_pages import fetches, local  # noqa: E402

KEPT = '<link href="../css/user.css" rel="stylesheet">\n<script src="../js/svg-pan-zoom.min.js"></script>\n<a href="https://a.b/c">read</a>'
REMOVED = [
    '<link href="https://a.b/style.css" rel="stylesheet"\n   integrity="sha384-x" crossorigin="anonymous">',
    "<link rel='stylesheet' href='//a.b/style.css'>",
    '<script src="https://a.b/x.js"\n   crossorigin="anonymous"></script>',
    "<script src=//a.b/x.js async></script>",
    "<script>\n  new bootstrap.Tooltip(element)\n</script>",
    '<script type="text/x-mathjax-config">MathJax.Hub.Config({});</script>',
]


@pytest.mark.parametrize("removed", REMOVED)
def test_what_is_fetched_is_taken_out_and_nothing_else(removed):
    first, rest = KEPT.split("\n", 1)
    assert local(f"{first}\n{removed}{rest}") == f"{first}\n{rest}"


def test_links_to_follow_are_nothing_to_fetch():
    assert fetches(KEPT) == []
    assert fetches('<img src="https://a.b/c.png">')
