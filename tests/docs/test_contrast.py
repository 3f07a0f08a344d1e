"""The site and the interactive pages can be read: the contrast of text to what is behind it (WCAG 2.1, 1.4.3) by the style sheets, in both schemes of colours."""

import colorsys
import re
from functools import cache
from pathlib import Path

import pytest

from paths import ROOT

LEAST = 4.5
material = pytest.importorskip("material")
SHEETS = [*sorted((Path(material.__file__).parent / "templates/assets/stylesheets").glob("*.css")), ROOT / "docs/site/site.css"]
PAGE, CODE, BAR, FOOT = "--md-default-bg-color", "--md-code-bg-color", "--md-primary-fg-color", "--md-footer-bg-color"
# What is written with a variable, over which layers; the lowest first
TEXTS = {PAGE: ["--md-typeset-color", "--md-default-fg-color", "--md-default-fg-color--light", "--md-typeset-a-color", "--md-accent-fg-color", "--md-admonition-fg-color"],
         CODE: ["--md-code-fg-color", *(f"--md-code-hl-{name}-color" for name in ("number", "special", "function", "constant", "keyword", "string", "name", "operator",
                                                                                  "punctuation", "comment", "generic", "variable"))],
         BAR: ["--md-primary-bg-color", "--md-primary-bg-color--light"], "--md-accent-fg-color": ["--md-accent-bg-color"], FOOT: ["--md-footer-fg-color", "--md-footer-fg-color--light"]}
# A selector whose colour is of its own, and the layers behind it
SELECTORS = {".md-typeset .headerlink": (PAGE,), ".md-search-result__meta": (PAGE, "--md-default-fg-color--lightest")}


@cache
def rules():
    """(selector, declarations) of all sheets, in their order."""
    found = []
    for sheet in SHEETS:
        for selectors, body in re.findall(r"([^{};]+)\{([^{}]*)\}", re.sub(r"/\*.*?\*/", "", sheet.read_text(), flags=re.DOTALL)):
            declared = dict(re.findall(r"([\w-]+)\s*:\s*([^;]+)", body))
            found += [(selector.strip(), declared) for selector in selectors.split(",")]
    return found


@cache
def variables(scheme):
    """The variables of a scheme, by rules that name less before those that name more."""
    names = [":root", *(f"[data-md-color-{kind}=indigo]" for kind in ("accent", "primary")), f"[data-md-color-scheme={scheme}]",
             f"[data-md-color-scheme={scheme}][data-md-color-primary=indigo]"]
    return {key: value for name in names for selector, declared in rules() if selector == name for key, value in declared.items() if key.startswith("--")}


def colour(text, scheme):
    """Red, green, blue and opacity, 0 to 1, of a colour."""
    text = re.sub(r"var\((--[\w-]+)\)", lambda match: variables(scheme)[match[1]], text.strip())
    if "var(" in text:
        return colour(text, scheme)
    if match := re.fullmatch(r"#([0-9a-f]{3,8})", text):
        digits = match[1] if len(match[1]) > 4 else "".join(2 * digit for digit in match[1])
        return [int(digits[k:k + 2], 16) / 255 for k in range(0, len(digits), 2)] + [1.0] * (len(digits) == 6)
    kind, numbers = re.fullmatch(r"(rgba?|hsla?)\((.*)\)", text).groups()
    values = [float(number) / (100 if unit == "%" else 1) for number, unit in re.findall(r"([\d.]+)(%|deg)?", numbers)]
    opacity = [*values, 1.0][3]
    return [*(colorsys.hls_to_rgb(values[0] / 360, values[2], values[1]) if kind.startswith("hsl") else [value / 255 for value in values[:3]]), opacity]


def over(front, behind):
    """What is seen of a colour over an opaque one."""
    return [a * front[3] + b * (1 - front[3]) for a, b in zip(front[:3], behind)]


def luminance(seen):
    linear = [value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in seen]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(text, layers, scheme):
    """The ratio of a colour to the layers behind it."""
    behind = [1.0, 1.0, 1.0]
    for layer in layers:
        behind = over(colour(layer, scheme), behind)
    dark, light = sorted(map(luminance, (over(colour(text, scheme), behind), behind)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("scheme", ["default", "slate"])
def test_text_of_the_site(scheme):
    """Text, links, code, navigation, header and footer."""
    page = f"var({PAGE})"
    measured = {name: contrast(f"var({name})", (page, f"var({behind})"), scheme) for behind, names in TEXTS.items() for name in names}
    for selector, layers in SELECTORS.items():
        own = [declared["color"] for name, declared in rules() if name == selector and "color" in declared][-1]
        measured[selector] = contrast(own, [f"var({layer})" for layer in layers], scheme)
    opacity = [declared["opacity"] for name, declared in rules() if name == ".md-tabs__link" and "opacity" in declared][-1]
    measured["the tabs"] = contrast(f"rgba(255, 255, 255, {opacity})", [f"var({BAR})"], scheme)
    assert {name: round(ratio, 2) for name, ratio in measured.items() if ratio < LEAST} == {}


def test_text_and_curves_of_the_interactive_pages():
    """Names of curves have their colours; all of it is on white."""
    folder = ROOT / "docs/lessons/interactive"
    names = re.search(r"const COLOURS = \[(.*?)\]", (folder / "draw.js").read_text())[1]
    colours = re.findall(r"#[0-9a-f]{6}", names) + re.findall(r"(?<![-\w])(?:color|fill): (#[0-9a-f]+)", (folder / "pages.css").read_text())
    assert len(colours) >= 6
    assert {name: ratio for name in colours if (ratio := contrast(name, ["#ffffff"], "default")) < LEAST} == {}


def test_ratios_are_those_of_the_standard():
    assert contrast("#000000", ["#fff"], "default") == pytest.approx(21)
    assert contrast("#767676", ["#ffffff"], "default") == pytest.approx(4.54, abs=0.005)
    assert contrast("#00000080", ["#fff"], "default") == pytest.approx(contrast("#7f7f7f", ["#fff"], "default"), rel=1e-9)
