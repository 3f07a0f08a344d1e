"""A history as a mapping, its pictures and what its columns are; snapshots by their times; values along fronts."""

import copy
import json
import pickle
import subprocess
import sys

import numpy as np
import pytest

import hampm as package
from paths import INPUT, ROOT, SOLID_PROGRAM


@pytest.fixture
def history(plate_result):
    return package.History(plate_result)


def test_a_history_is_a_mapping(history):
    """Of names to samples; patterns are no names."""
    assert "K_I" in history and "K_III" not in history and "K_*" not in history and 0 not in history
    assert len(history) == len(list(history)) == len(history.keys()) == len(history.columns) and "time" in list(history)
    assert dict(history)["J"] is history["J"] is history.J and history.get("K_III") is None
    assert [name for name, samples in history.items() if samples.shape != history.times.shape] == []
    for again in (copy.deepcopy(history), pickle.loads(pickle.dumps(history))):
        np.testing.assert_array_equal(again.K_I, history.K_I)
    assert history == history and history != package.History(history.path) and len({history}) == 1


def test_a_column_that_is_not_there_is_a_key_error(history):
    for error in (KeyError, package.ResultError):
        with pytest.raises(error, match="no column 'K_III' in /history; it has time") as told:
            history["K_III"]
        assert not str(told.value).startswith('"')
    with pytest.raises(AttributeError, match="no column 'K_i' in /history; did you mean 'K_I'"):
        history.K_i


def test_columns_are_completed(history):
    assert {"K_I", "K_I_error", "value", "times"} <= set(dir(history)) and "K_II" in history._ipython_key_completions_()


def test_curves_of_a_history(dcb_result):
    """Each unit has a panel of its own; errors are bands."""
    history = package.History(dcb_result)
    figure = history.plot("G_vcct_I", "kinetic_energy", errors=True)
    assert [len(axes.lines) for axes in figure.axes] == [1, 1] and len(figure.axes[0].collections) == 1
    (own, *_), = (axes.lines for axes in history.plot("kinetic_energy", x="crack_opening").axes)
    assert own.get_xdata().size == history.times.size


def test_a_dataset_names_the_errors_of_its_variables(history):
    data = history.to_xarray()
    assert data.K_I.attrs["ancillary_variables"] == "K_I_error" and data.K_I_error.attrs["units"] == "Pa m^0.5" and "ancillary_variables" not in data.K_I_error.attrs
    assert data[data.J_tip2.attrs["ancillary_variables"]].name == "J_error_tip2"


def test_each_column_is_described(history, dcb_result):
    """With the unit and the words of the result."""
    for result in (history, package.History(dcb_result)):
        for name in result:
            about = package.describe(name)
            assert about.unit == result.units[name], name
            assert result.long_names[name].split(",")[0].split(" of ")[0] in about.meaning or name.startswith("J_"), name
    assert package.describe("K_I_tip2").symbol == r"$K_{\mathrm{I}}$, tip 2" and package.describe("reaction_left_x").unit == "N"
    assert "J_error" in repr(package.describe("J_error")) and str(package.describe("dt")) == "dt [s]: time step (always; 0 in the first sample)"
    with pytest.raises(KeyError, match="there is no column 'KI'; did you mean 'K_I'"):
        package.describe("KI")


def test_descriptions_are_those_of_the_page_of_results():
    printed = subprocess.run([sys.executable, ROOT / "tools/python_groups.py", "--columns"], capture_output=True, text=True, check=True).stdout
    assert (ROOT / "python/src/hampm/columns.json").read_text() == printed, "tools/python_groups.py --columns > python/src/hampm/columns.json"
    assert len(json.loads(printed)) > 150


def test_snapshots_are_chosen_by_time(plate_result):
    """As of xarray: exactly, or the nearest; there is none beyond the ends of the run."""
    snapshots = package.Snapshots(plate_result)
    assert float(snapshots.sel(1.0).time) == 1.0 == float(snapshots.sel(0.7, method="nearest").time) and "corners" in snapshots.sel(0.0, block="mesh")
    for time, method, said in ((0.7, None, "no snapshot at 0.7 s; method='nearest' takes that of 1 s"), (5.0, "nearest", "they are from 0 to 1 s"),
                               (-0.1, "nearest", "they are from 0 to 1 s"), (0.5, "pad", "method 'pad' is not known")):
        with pytest.raises(KeyError, match=said):
            snapshots.sel(time, method)
    with pytest.raises(package.ResultError, match="no snapshot near 5 s"):
        snapshots.to_xarray(time=5.0)
    figure = snapshots.plot("stress_yy", time=1.0, scale=100)
    assert "100" in figure.axes[0].get_title()


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
def test_values_along_a_front(tmp_path, monkeypatch, plate_result):
    """At points, or at ways along it; those of a penny lie on a circle."""
    monkeypatch.setenv("HAMPM3D", str(SOLID_PROGRAM))
    penny = package.Scene(INPUT / "solid/penny.nml")
    history = penny.run(output=tmp_path, progress=False)
    front = history.front()
    assert front.K_I.dims == ("time", "point") and front.arc.attrs["units"] == "m" and {"x", "y", "z", "arc", "time"} <= set(front.coords)
    end = float(front.arc[-1].max())
    ways = np.linspace(0.1, 0.9, 9) * end
    even = history.front(arc=ways)
    assert even.K_I.dims == ("time", "arc") and even.sizes["arc"] == 9 and even.K_I_error.attrs["units"] == "Pa m^0.5" and even.K_I.attrs["ancillary_variables"] == "K_I_error"
    k = int(np.argmin(abs(front.arc.values[-1] - ways[4])))
    assert float(even.K_I[-1, 4]) == pytest.approx(float(front.K_I[-1, k]), rel=0.02)
    radius = np.sqrt(even.x**2 + even.y**2 + even.z**2).values[-1]
    assert np.ptp(radius) < 0.02 * radius.mean()
    assert np.isnan(history.front(arc=[2 * end]).K_I.values).all()
    figure = package.plot("front", history, quantity="K_I")
    assert figure.axes
    with pytest.raises(package.ResultError, match="no values along a front 2"):
        history.front(2)
    with pytest.raises(package.ResultError, match="no values along a front 1"):
        package.History(plate_result).front()
