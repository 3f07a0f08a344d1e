"""Work-precision diagrams: tables printed, runs and fronts drawn, mistakes named."""

import matplotlib.image
import numpy as np
import pytest

import plot_work_precision

HEAD = "name,family,cpu_seconds,particles,error_percent,memory\n"
ROWS = ["coarse,uniform,1,100,-8,", "middle,uniform,4,400,3,", "fine,uniform,16,1600,-1.5,7", "tip,refined,3,700,0.9,",
        "finer tip,refined,30,1500,0,", "blown up,refined,2,,,", "costly,uniform,40,9000,-1.6,"]


@pytest.fixture
def table(tmp_path):
    def write(rows=ROWS, head=HEAD, name="table.csv"):
        path = tmp_path / name
        path.write_text(head + "".join(f"{row}\n" for row in rows))
        return path
    return write


def figure_of(path, *arguments):
    options = plot_work_precision.parse([str(path), *arguments])
    rows = plot_work_precision.read_table(path, [options.cost, options.error, options.family])
    return plot_work_precision.draw(plot_work_precision.measured(rows, options.cost, options.error), options)


def test_tables_and_the_count_of_failed_rows_are_printed(program, table):
    result = program("plot_work_precision.py", table(), "--dpi", 60)
    assert result.returncode == 0
    assert result.stderr == "1 of 7 rows without a number in cpu_seconds or error_percent left out\n"
    lines = [line.split() for line in result.stdout.splitlines()]
    assert [line[0] for line in lines[2:5]] == ["coarse", "tip", "finer"]
    assert [line[:2] for line in lines[7:12]] == [["5", "tip"], ["2", "tip"], ["1", "tip"], ["0.5", "finer"], ["0.3", "finer"]]
    assert lines[2][-3:] == ["1", "100", "-8"] and lines[12] == [str(table().with_name("table_work_precision.png"))]
    pixels = matplotlib.image.imread(lines[12][0])
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 50


def test_an_accuracy_that_no_setting_reaches_has_none(script, table):
    result = script("plot_work_precision.py", table(ROWS[:2]), "--dpi", 40)
    assert [line.split()[1] for line in result.stdout.splitlines()[6:11]] == ["middle", "none", "none", "none", "none"]


def test_panels_hold_all_runs_by_family_and_a_front_each(table):
    left, right = figure_of(table()).axes
    for panel, front in [(left, {(1, 8), (3, 0.9)}), (right, {(100, 8), (400, 3), (700, 0.9)})]:
        uniform, refined, steps = panel.lines[:3]
        assert (uniform.get_label(), refined.get_label(), steps.get_label()) == ("uniform", "refined", "Pareto front")
        np.testing.assert_allclose(uniform.get_ydata(), [8, 3, 1.5, 1.6])
        np.testing.assert_allclose(refined.get_ydata(), [0.9, 0.45])  # an error of 0 below all others
        assert set(zip(*steps.get_data())) >= front and steps.get_drawstyle() == "steps-post"
        assert panel.get_xscale() == panel.get_yscale() == "log"
    assert [text.get_text() for text in left.texts] == ["1", "2", "3"] and "4" in [text.get_text() for text in right.texts]
    plot_work_precision.plt.close("all")


def test_of_many_families_five_are_drawn_and_of_many_settings_none_is_numbered(table):
    """Those that are on the front most often."""
    rows = [f"{family} {k},{family},{k},{100 * k},{20 / (k + number / 10)}," for number, family in enumerate("abcdef") for k in (1, 2, 3)]
    rows += [f"g {k},g,{k + 0.5},{100 * k},{10 / k}," for k in range(1, 15)]
    left, right = figure_of(table(rows)).axes
    assert {line.get_label() for line in left.lines} >= {"g", "f", "Pareto front"}
    assert sum(len(line.get_label()) == 1 for line in left.lines) == 5
    assert not [text for text in left.texts if text.get_text().isdigit()]
    plot_work_precision.plt.close("all")


def test_other_columns_and_several_tables(script, table):
    head = "name,kind,steps,error\n"
    files = [table(["a,x,10,5"], head), table(["b,y,20,1"], head, "other.csv")]
    result = script("plot_work_precision.py", *files, "--cost", "steps", "--error", "error", "--family", "kind", "--dpi", 40)
    assert result.returncode == 0 and "a" in result.stdout.split() and "b" in result.stdout.split()


def test_rows_may_be_chosen(script, table):
    result = script("plot_work_precision.py", table(), "--only", "family=uniform", "--only", "cpu_seconds=4", "--dpi", 40)
    assert result.returncode == 0 and [line.split()[0] for line in result.stdout.splitlines()[2:4]] == ["middle", "cheapest"]


@pytest.mark.parametrize("text, arguments, code, words", [
    (HEAD, ["--only", "family"], 2, "not COLUMN=VALUE"), (HEAD, ["--only", "group=a"], 2, "no column 'group'"),
    (None, [], 4, "cannot be read"), ("", [], 2, "no column 'name'; it has none"), ("name,family\n", [], 2, "no column 'cpu_seconds'"),
    (HEAD, [], 2, "no row has numbers"), (HEAD, ["--cost", "hours"], 2, "no column 'hours'"), (b"\xff\xfe\x00", [], 4, "cannot be read"),
    (HEAD, ["--dpi", "0"], 2, "not a positive number")])
def test_mistakes_are_named(script, tmp_path, text, arguments, code, words):
    path = tmp_path / "a.csv"
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    result = script("plot_work_precision.py", path, *arguments)
    assert result.returncode == code and words in result.stderr and not list(tmp_path.glob("*.png"))
