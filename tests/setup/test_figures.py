"""The pictures of the docs: each is shown, and named in tools/figures.txt with what draws it."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from paths import ROOT

TABLE = ROOT / "tools/figures.txt"
FIGURES = ROOT / "tools/figures.sh"
PALETTE = ROOT / "tools/palette.py"
LARGEST = {".png": 120_000, ".svg": 30_000}  # bytes


def rows():
    """Picture, figure and drawn file of each row."""
    lines = [line.split("#")[0].split() for line in TABLE.read_text().splitlines()]
    return [tuple(words) for words in lines if words]


def shown():
    """Documents by the picture that they show, as paths from the root."""
    found = {}
    for document in [ROOT / "README.md", *ROOT.glob("docs/**/*.md")]:
        for target in re.findall(r"!\[[^\]]*\]\(([^)\s]+\.(?:png|svg))\)", document.read_text()):
            path = (document.parent / target).resolve().relative_to(ROOT)
            found.setdefault(str(path), []).append(str(document.relative_to(ROOT)))
    return found


def pictures():
    """Those of runs and the sketches of models; other drawings have tests of their own."""
    found = [path for pattern in ("docs/**/*.png", "docs/lessons/*.svg", "docs/images/sketch_*.svg") for path in ROOT.glob(pattern)]
    return {str(path.relative_to(ROOT)) for path in found}


def test_the_table_names_each_picture_once():
    assert all(len(row) == 3 for row in rows())
    named = [picture for picture, _, _ in rows() if picture != "-"]
    assert sorted(named) == sorted(pictures())


def test_pictures_that_are_shown_exist_and_all_are_shown():
    assert {path for path in shown() if path.endswith(".png")} <= pictures() <= shown().keys()


def test_pictures_are_small():
    assert {path: size for path in pictures() if (size := (ROOT / path).stat().st_size) > LARGEST[Path(path).suffix]} == {}


def test_each_figure_is_drawn_by_a_function_or_a_target_of_make():
    functions = re.findall(r"^draw_(\w+)\(\)", FIGURES.read_text(), re.MULTILINE)
    targets = re.findall(r"^(\w+):.*## ", (ROOT / "Makefile").read_text(), re.MULTILINE)
    figures = {figure for _, figure, _ in rows()}
    assert figures <= {*functions, *targets} and set(functions) <= figures
    assert all(Path(drawn).parts[0] == "results" for _, _, drawn in rows())


def figures(folder, *arguments):
    """Run a copy of figures.sh that lives in a folder with a table of its own."""
    return subprocess.run([folder / "tools/figures.sh", "false", sys.executable, *arguments], capture_output=True, text=True)


@pytest.fixture
def copy(tmp_path):
    """figures.sh beside a table of one figure, which is a target of make that writes a picture of two colours."""
    (tmp_path / "tools").mkdir()
    for file in (FIGURES, PALETTE):
        (tmp_path / "tools" / file.name).write_bytes(file.read_bytes())
    (tmp_path / "tools/figures.sh").chmod(0o755)
    (tmp_path / "tools/figures.txt").write_text("# a comment\ndocs/new/a.png  square  results/a.png  # another\ndocs/new/b.svg  square  results/b.svg\n-  square  results/b\n")
    (tmp_path / "Makefile").write_text("square:\n\t@mkdir -p results; cp source.png results/a.png; cp source.svg results/b.svg; touch results/b; echo made\n")
    pixels = np.zeros((40, 40, 4), dtype=np.uint8)
    pixels[..., 3] = 255
    pixels[10:30, 10:30, 1] = 200
    Image.fromarray(pixels).save(tmp_path / "source.png")
    (tmp_path / "source.svg").write_text('<svg width="3pt" height="2pt">\n<text>1 pt</text></svg>\n')
    return tmp_path


def test_a_target_is_made_once_and_its_picture_goes_into_the_docs(copy):
    assert figures(copy, "--list").stdout.split() == ["square"]
    first, second = figures(copy), figures(copy, "--docs", "square")
    assert (first.returncode, second.returncode) == (0, 0) and "made" in first.stdout and "made" not in second.stdout
    assert "docs/new/a.png: " in second.stdout
    with Image.open(copy / "docs/new/a.png") as image, Image.open(copy / "source.png") as source:
        assert image.mode == "P"
        np.testing.assert_array_equal(np.array(image.convert("RGB")), np.array(source.convert("RGB")))
    assert (copy / "docs/new/b.svg").read_text() == '<svg width="3px" height="2px">\n<text>1 pt</text></svg>\n'


ADVICE = """study,within_percent,group,setting,estimator,particles,cpu_seconds,error_percent,sustained_percent,times_cheaper,cheapest
bars,5,uniform,coarse,j,100,1.0,-4.00,4.00,1,yes
bars,1,uniform,fine,j,400,8.0,-1.00,1.00,1,
bars,5,at rest,,,,,,,,
bars,1,at rest,rest,j,90,0.5,+0.50,0.50,4,yes
"""
FRONT = "study,setting,estimator,particles,cpu_seconds,error_percent,sustained_percent\nbars,rest,j,90,0.500,+0.500,0.500\n"


def test_accuracy_against_cost_is_drawn_from_the_tables_beside_the_page(tmp_path, monkeypatch):
    """The front and up to five families, each in one colour on all pictures; those of the docs too."""
    monkeypatch.syspath_prepend(ROOT / "tools")
    import tradeoff_pictures
    (tmp_path / "advice.csv").write_text(ADVICE)
    (tmp_path / "front.csv").write_text(FRONT)
    figure = tradeoff_pictures.draw(*(tradeoff_pictures.rows_of(tmp_path / f"{part}.csv", "bars") for part in ("front", "advice")))
    uniform, rest, front = figure.axes[0].lines
    assert [line.get_label() for line in figure.axes[0].lines] == ["uniform", "at rest", "front of all settings"]
    np.testing.assert_allclose(uniform.get_xydata(), [[1, 4], [8, 1]])
    np.testing.assert_allclose(rest.get_xydata(), [[0.5, 0.5]])
    np.testing.assert_allclose(front.get_xydata(), [[0.5, 0.5]])
    assert uniform.get_color() == tradeoff_pictures.FAMILIES["uniform"] and tradeoff_pictures.MOST == 5
    words = [ROOT / "tools/tradeoff_pictures.py", ROOT / "docs/evidence", "--output", tmp_path]
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert {path.stem for path in tmp_path.glob("*.png")} == {"static", "tension", "dynamic", "impact"}


def test_failures_end_the_script(copy):
    result = figures(copy, "circle")
    assert result.returncode == 2 and "no figure 'circle'; there are square" in result.stderr
    (copy / "Makefile").write_text("square:\n\t@false\n")
    assert figures(copy).returncode != 0
    (copy / "Makefile").write_text("square:\n\t@true\n")
    result = figures(copy, "--docs")
    assert result.returncode != 0 and "results/a.png: no such file" in result.stderr
