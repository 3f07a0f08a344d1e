"""What the site does to a page of docs/ before it is shown: formulas become MathML, and links to files outside docs/ the names of these files.

MkDocs calls `on_page_markdown`; GitHub shows the same pages with their formulas as they are written, ```` ```math ```` blocks and $`...`$.
"""

import html
import os
import re

from latex2mathml.converter import convert

FENCE = re.compile(r"^( *)(```+)(\w*) *([^\n]*)\n(.*?)^\1\2 *$", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"\$`(?P<formula>[^`\n]+)`\$|`+[^`\n]*`+")
BOLD = re.compile(r'<mi mathvariant="bold-italic">&#x0*([0-9A-F]+);</mi>')
LINK = re.compile(r"(?<!!)\[([^\]\n]+)\]\(([^)\s]+)\)")


def anchor(heading, separator="-"):
    """The anchor of a heading as GitHub makes it: small letters, without punctuation, a hyphen for each blank."""
    return re.sub(r"[^\w\- ]", "", html.unescape(re.sub(r"<[^>]+>", "", heading)).strip().lower()).replace(" ", separator)


def mathml(formula, display):
    """A formula of TeX as MathML, which browsers draw without a script; `display`: "inline" or "block"."""
    return BOLD.sub(bold, convert(formula.strip().replace(r"\!", ""), display=display).replace("\n", ""))


def bold(match):
    """A bold Greek letter as a letter of its own: browsers leave out `mathvariant`."""
    small = ord("\N{MATHEMATICAL BOLD ITALIC SMALL ALPHA}") - ord("α")
    letter = int(match[1], 16)
    return f"<mi>&#x{letter + small:05X};</mi>" if 0x3B1 <= letter <= 0x3C9 else match[0]


def spans(text):
    """What lies between fences, with its formulas as MathML; other code in a line stays as it is."""
    return CODE.sub(lambda match: f'<span>{mathml(match["formula"], "inline")}</span>' if match["formula"] else match[0], text)


def outside(text, folder):
    """Links to files outside docs/ as the names of the files."""
    def name(match):
        words, target = match.groups()
        if re.match(r"[a-z]+:|#", target):
            return match[0]
        place = os.path.normpath(os.path.join("docs", folder, target.split("#")[0]))
        if place.startswith("docs" + os.sep):
            return match[0]
        return f"`{place}`" if os.path.basename(place) in words else f"{words} (`{place}`)"
    return LINK.sub(name, text)


def shown(indent, marks, language, title, text):
    """A block between fences: a formula as MathML; what else the first line says of code, as the name of a file, is its title."""
    if language == "math":
        return f'{indent}<div class="formula">{mathml(text, "block")}</div>'
    first = f'{language} title="{title}"' if title else language
    return f"{indent}{marks}{first}\n{text}{indent}{marks}"


def on_page_markdown(markdown, page, **_):
    """The Markdown of a page as MkDocs is to have it."""
    folder = os.path.dirname(page.file.src_uri)
    parts, end = [], 0
    for fence in FENCE.finditer(markdown):
        parts.append(spans(outside(markdown[end:fence.start()], folder)))
        parts.append(shown(*fence.groups()))
        end = fence.end()
    return "".join([*parts, spans(outside(markdown[end:], folder))])
