"""The sketch of a model: each group that has a place is where the namelist has it, with its size, before any run."""

import re
import warnings
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import sketch
from pictures import STYLE, plt

from paths import DCB, INPUT, ROOT

BLUE, ORANGE, GREEN, PINK = sketch.LOAD, sketch.CRACK, sketch.SUPPORT, sketch.MOTION
MODEL = """&run end_time = 1e-4  plane = 'strain' /
&grid lower = -10e-3, -10e-3  cell = 1e-3  cells = 80, 60 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7800 /
&material name = 'a $ b'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'steel'  shape = 'polygon'  points = 0, 0, 40e-3, 0, 30e-3, 30e-3, 0, 20e-3 /
&body material = 'a $ b'  lower = 41e-3, 0  upper = 60e-3, 20e-3  velocity = -1.0, 0.0  spin = 3.0  eigenstrain = 1e-3, 1e-3, 0 /
&body shape = 'circle'  center = 10e-3, 8e-3  radius = 4e-3  hole = .true. /
&constraint lower = 0, 0  upper = 40e-3, 0  fix = 'xy' /
&constraint lower = 60e-3, 0  upper = 60e-3, 20e-3  fix = 'xy'  velocity = -1, 0.0  name = 'grip' /
&constraint lower = -5e-3, 10e-3  upper = 5e-3, 22e-3  fix = 'x' /
&load kind = 'gravity'  acceleration = 0, -9.81  history = 'ramp'  rise_time = 1e-5 /
&load kind = 'body'  lower = 42e-3, 5e-3  upper = 55e-3, 18e-3  force = 10.0, 0.0 /
&load kind = 'pressure'  lower = 5e-3, 3e-3  upper = 15e-3, 13e-3  pressure = 1e6 /
&load kind = 'point'  lower = 50e-3, 20e-3  upper = 50e-3, 20e-3  force = 1.0, -1.0  history = 'sine'  frequency = 1e6 /
&load kind = 'traction'  lower = 22.5e-3, 12e-3  upper = 25.5e-3, 12e-3  force = 0, 3.0  face = 'left' /
&load kind = 'traction'  lower = 0, 20e-3  upper = 30e-3, 30e-3  force = 0, 0.0 /
&crack kind = 'path'  points = 18e-3, 10e-3, 22e-3, 12e-3, 26e-3, 12e-3  name = 'b' /
&contact bodies = 'frictionless' /
&method frame = 'updated'  mass = 'partial'  consistent_lower = 0, 0  consistent_upper = 10e-3, 10e-3 /
&refine indicator = 'tip'  region_lower = 10e-3, 5e-3  region_upper = 35e-3, 20e-3 /
"""


@pytest.fixture
def drawn(tmp_path):
    """`drawn(model, ...)`: the axes of the sketch of a file or a text; none may warn."""
    def axes_of(model, *arguments):
        if isinstance(model, str):
            (tmp_path / "model.nml").write_text(model)
            model = tmp_path / "model.nml"
        options = sketch.parse([str(model), *map(str, arguments)])
        with warnings.catch_warnings(), plt.rc_context(STYLE):
            warnings.simplefilter("error")
            figure = sketch.draw(*sketch.understood(model, options.settings), options)
            figure.canvas.draw()
        return figure.axes[0]
    return axes_of


def words(axes):
    return [text.get_text() for text in axes.texts if text.get_text()]


def lines(axes, colour, marker="None"):
    """Points in mm of the lines of a colour, or of its markers."""
    return [line.get_xydata() * 1e3 for line in axes.lines if colour in (line.get_color(), line.get_markeredgecolor()) and
            (line.get_marker() == marker if isinstance(marker, str) else not isinstance(line.get_marker(), str))]


def arrows(axes, colour):
    """Tail and head in mm of each arrow of a colour."""
    return [np.array([text.xyann, text.xy]) * 1e3 for text in axes.texts if text.arrow_patch and plt.matplotlib.colors.to_hex(
        text.arrow_patch.get_edgecolor()).upper() == colour]


def test_the_beam_of_the_paper(drawn):
    axes = drawn(DCB)
    assert sorted(words(axes)) == ["$F$ = 1 N", "$u_y$ = 0", "crack", "symmetry"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$ [mm]", "$y$ [mm]")
    np.testing.assert_allclose(axes.patches[0].get_xy()[:4] * 1e3, [[0, 0], [100, 0], [100, 10], [0, 10]])
    np.testing.assert_allclose(lines(axes, ORANGE), [[[0, 0], [50, 0]]])
    np.testing.assert_allclose(lines(axes, ORANGE, "o"), [[[50, 0]]])
    np.testing.assert_allclose(lines(axes, BLUE), [[[0, 10], [0, 0]]], atol=1e-3)
    rollers = np.concatenate(lines(axes, GREEN, marker=None))
    assert len(rollers) > 3 and np.all(rollers[:, 1] == 0) and rollers[:, 0].min() > 50 and rollers[:, 0].max() < 100
    (tail, head), = arrows(axes, BLUE)
    assert tail[0] == head[0] < 0 and head[1] > tail[1]  # along the edge, beside it


def test_settings_are_those_of_a_run(drawn):
    axes = drawn(DCB, "--set", "load.force=2e3,0", "--set", "energy_release.reference=none", "--set", "crack.tip=0.06,0", "--set", "constraint.lower=0.06,0")
    assert "$F$ = 2 kN" in words(axes)
    np.testing.assert_allclose(lines(axes, ORANGE, "o"), [[[60, 0]]])
    assert all(tail[0] < head[0] <= 1e-9 for tail, head in arrows(axes, BLUE))  # it presses on the edge from outside


def test_each_group_that_has_a_place_is_drawn(drawn):
    axes = drawn(MODEL)
    assert sorted(words(axes)) == sorted([
        "steel", r"a \$ b, $\varepsilon_0$ = 0.001, 0.001, 0, $\omega$ = 3 rad/s", "$v$ = 1 m/s", "b", "tip 1", "tip 2", "$u_x$ = $u_y$ = 0",
        "grip: $v_x$ = −1 m/s, $u_y$ = 0", "$u_x$ = 0", "$g$ = 9.81 m/s² (ramp)", "$F$ = 10 N", "$p$ = 1 MPa", "$F$ = 1.414 N (sine)",
        "$F$ = 3 N", "$F$ = 0 N"])
    assert [patch.get_facecolor()[0] for patch in axes.patches[:3]] == [0.9, 0.9, 1]  # the hole is white
    assert len(arrows(axes, PINK)) == 1 and len(arrows(axes, GREEN)) >= 1
    assert len([tail for tail, head in arrows(axes, BLUE) if head[0] == tail[0] and head[1] < tail[1]]) >= 2  # weight of both bodies
    on_hole = [(tail, head) for tail, head in arrows(axes, BLUE) if np.hypot(*(head - [10, 8])) < 4.01 and np.hypot(*(tail - [10, 8])) < 4]
    assert len(on_hole) >= 1  # the pressure is on the edge of the hole, from within it
    np.testing.assert_allclose(lines(axes, BLUE)[1], [[22.5, 12], [25.5, 12]], atol=1e-3)
    np.testing.assert_allclose(lines(axes, BLUE)[2], [[30, 30], [0, 20]], atol=1e-3)
    assert np.ptp(axes.patches[0].get_xy(), axis=0) == pytest.approx([0.04, 0.03])


@pytest.mark.parametrize("load, line", [("kind = 'traction'  side = 2  force = 1.0, 0.0", [[40, 0], [30, 30]]), ("kind = 'absorbing'  side = 3", [[30, 30], [0, 20]]),
                                        ("kind = 'pressure'  side = 4  pressure = 1.0  lower = 41e-3, 5e-3  upper = 60e-3, 30e-3", [[41, 20], [41, 5]])])
def test_a_load_on_a_side(drawn, load, line):
    text = "\n".join(row for row in MODEL.splitlines() if not row.startswith("&load"))
    if "lower" not in load:
        text = text.replace("&body material = 'a $ b'  lower = 41e-3, 0  upper = 60e-3, 20e-3", "&body material = 'a $ b'  shape = 'circle'  center = 50e-3, 10e-3  radius = 9e-3")
    np.testing.assert_allclose(lines(drawn(text + f"\n&load {load} /\n"), BLUE), [line], atol=1e-3)


def test_the_lattice_and_its_boxes_where_asked(drawn):
    axes = drawn(MODEL, "--grid", "--title", "all")
    assert axes.get_title() == "all" and {"grid", "refines", "consistent mass"} <= set(words(axes))
    boxes = [patch.get_bbox().bounds for patch in axes.patches[-3:]]
    np.testing.assert_allclose(boxes, [(-0.01, -0.01, 0.08, 0.06), (0.01, 0.005, 0.025, 0.015), (0, 0, 0.01, 0.01)])


def test_cohesion_growth_and_pressure_of_cracks(drawn):
    axes = drawn(INPUT / "dcb_cohesive.nml")
    assert "a, cohesive" in words(axes)
    assert any(line.get_linestyle() not in ("-", "-.") for line in axes.lines)
    axes = drawn(INPUT / "pressurised_crack.nml")
    (tail, head), (other_tail, other_head) = arrows(axes, BLUE)
    np.testing.assert_allclose(head - tail, other_tail - other_head)  # both faces are pushed apart
    np.testing.assert_allclose(tail, other_tail)
    assert "crack, grows" in words(drawn(INPUT / "kalthoff.nml")) and "axis" in words(drawn(INPUT / "penny.nml"))
    axes = drawn((INPUT / "kalthoff.nml").read_text().replace("'hoop_stress'", "'path'  points = 0.05, 0.025, 0.06, 0.05"))
    assert [line.get_linestyle() for line in axes.lines if line.get_color() == ORANGE].count(":") == 1


def test_parts_of_a_line_in_a_box():
    square = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]], dtype=float)
    assert sketch.within(square, np.array([3, 3]), np.array([4, 4]), 1e-6) == []
    edge, = sketch.within(square, np.array([2, 0.5]), np.array([2, 9]), 1e-6)
    np.testing.assert_allclose(edge, [[2, 0.5], [2, 2]], atol=1e-5)
    lower, left = sketch.within(square, np.array([-1, -1]), np.array([1, 1]), 1e-6)
    np.testing.assert_allclose(np.concatenate([lower, left]), [[0, 0], [1, 0], [0, 1], [0, 0]], atol=1e-5)
    np.testing.assert_allclose(sketch.along(square, 2.0)[0], [[1, 0], [2, 1], [1, 2], [0, 1]])
    np.testing.assert_allclose(sketch.along(square[:2], 9.0)[0], [[1, 0]])


@pytest.mark.parametrize("model", sorted(INPUT.glob("*.nml")), ids=lambda path: path.stem)
def test_every_model_has_a_sketch_whose_labels_are_in_it(drawn, model):
    axes = drawn(model)
    labels = [text.get_window_extent() for text in axes.texts if text.get_text()]
    assert labels and axes.patches and all(box.x0 > -1 and box.y0 > -1 for box in labels)
    assert not any(box.overlaps(other) for k, box in enumerate(labels) for other in labels[:k])


def texts(svg):
    return ["".join(element.itertext()).split() for element in ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]


def test_text_stays_text_and_paths_may_have_blanks(script, tmp_path):
    folder = tmp_path / "a b"
    folder.mkdir()
    (folder / "my model.nml").write_text(DCB.read_text())
    result = script("sketch.py", folder / "my model.nml", "--output", folder / "my sketch.svg")
    assert result.returncode == 0 and result.stdout == f"{folder}/my sketch.svg\n" and result.stderr == ""
    assert ["crack"] in texts((folder / "my sketch.svg").read_text())
    assert script("sketch.py", folder / "my model.nml", "--dpi", "50").stdout == f"{folder}/my model_sketch.png\n"


def test_sketches_of_the_docs_are_those_of_their_models(script, tmp_path):
    rows = re.findall(r"^(\S+\.svg) +sketches +\S+/(\S+)\.svg$", (ROOT / "tools/figures.txt").read_text(), re.MULTILINE)
    assert len(rows) > 15
    for picture, name in rows:
        model, = [path for folder in (INPUT, ROOT / "docs/lessons") for path in folder.glob(f"{name}.nml")]
        assert script("sketch.py", model, "-o", tmp_path / "a.svg").returncode == 0
        assert texts((ROOT / picture).read_text()) == texts((tmp_path / "a.svg").read_text()), f"{picture}: make figures DOCS=1"


@pytest.mark.parametrize("arguments, code, said", [
    (["none.nml"], 4, "none.nml: cannot be read"), ([DCB, "--set", "loud.force=1,0"], 2, "there is no group &loud; did you mean 'load'?"),
    ([DCB, "--set", "body.upper=-1,1"], 2, "upper"), ([DCB, "-o", "a.doc"], 2, "end in .png"), ([DCB, "-o", "/nowhere/a.svg"], 4, "cannot be written"),
    ([__file__], 2, "test_sketch.py"), ([], 2, "MODEL.nml")])
def test_mistakes_are_named(script, tmp_path, monkeypatch, arguments, code, said):
    monkeypatch.chdir(tmp_path)
    result = script("sketch.py", *arguments)
    assert result.returncode == code and said in result.stderr and "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_without_the_program_it_says_so(script, monkeypatch, tmp_path):
    monkeypatch.setenv("HAMPM", str(tmp_path / "nowhere"))
    result = script("sketch.py", DCB)
    assert result.returncode == 4 and "no such program" in result.stderr
