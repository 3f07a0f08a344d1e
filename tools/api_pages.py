"""Write pages of every module, type and procedure of src/, which fetch nothing from elsewhere when they are read:

    python tools/api_pages.py          build/site/api/index.html, by ford

What ford's pages would fetch (a style, its scripts, a script for formulas, of which there are none) is taken out of them; tools/api.css is
their style.
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "build/site/api"
REMOTE = r"""["']?(?:https?:)?//"""
FETCHED = re.compile(rf"<link\b(?=[^>]*rel=[\"']?stylesheet)[^>]*href={REMOTE}[^>]*>|<script\b[^>]*src={REMOTE}[^>]*>.*?</script>", re.DOTALL)
SCRIPTS = re.compile(r"<script\b[^>]*>(?:(?!</script>).)*?(?:MathJax\.Hub|bootstrap\.Tooltip).*?</script>", re.DOTALL)  # need what is fetched


def local(page):
    """A page without what it fetches from elsewhere, and without the scripts that need it."""
    return SCRIPTS.sub("", FETCHED.sub("", page))


def fetches(page):
    """What a page would load from elsewhere when it is opened; links that a reader follows do not count."""
    return re.findall(rf"<(?:link|script|img|iframe)\b[^>]*(?:href|src)={REMOTE}[^>]*>", page)


def main():
    status = subprocess.run([sys.executable, "-m", "ford", "--quiet", ROOT / "tools/ford.md"]).returncode
    if status:
        sys.exit(status)
    for file in PAGES.rglob("*.html"):
        page = local(file.read_text())
        if fetches(page):
            sys.exit(f"api_pages.py: {file} fetches {fetches(page)[0]}: ford writes other pages than this script knows")
        file.write_text(page)


if __name__ == "__main__":
    main()
