"""Comparing two results: what counts as a difference, what is named, and the exit codes."""

import h5py
import numpy as np
import pytest

from synthetic import dcb, write_result


@pytest.fixture
def against(tmp_path, script, dcb_file):
    """Compare the complete result with one of other columns; the row of each column is found by its name."""
    def call(columns, *options):
        other = write_result(tmp_path / "b.h5", columns)
        result = script("compare.py", dcb_file, other, *options)
        return result, {line.split()[0]: line for line in result.stdout.splitlines()}
    return call


def changed(name, values):
    return {**dcb(), name: values}


def test_equal_results(against):
    result, rows = against(dcb())
    assert result.returncode == 0 and rows["G_vcct_I"].endswith("equal")
    assert against(dcb(), "--exact")[0].returncode == 0


def test_the_largest_difference_and_its_time_are_shown(against):
    opening = dcb()["crack_opening"].copy()
    opening[300] += 1e-9
    result, rows = against(changed("crack_opening", opening))
    assert result.returncode == 1 and "1 of 6 columns differ" in result.stdout
    relative = f"{1e-9 / np.max(dcb()['crack_opening']):.1e}"
    assert rows["crack_opening"].split() == ["crack_opening", "1.000e-09", relative, "0.0003", "1e-09", "rel", "DIFFERS"]
    assert against(changed("crack_opening", opening), "--exact")[1]["crack_opening"].split()[1:3] == ["1.000e-09", relative]
    result, rows = against(changed("step", dcb()["step"] * 2))
    assert rows["step"].split()[2] == "1.0e+00"


def test_what_was_zero_has_no_relative_difference(tmp_path, script):
    none, some = (write_result(tmp_path / f"{value}.h5", changed("crack_opening", np.full(1201, value))) for value in (0.0, 1e-9))
    row, = [line for line in script("compare.py", none, some).stdout.splitlines() if line.startswith("crack_opening")]
    assert row.split()[1:4] == ["1.000e-09", "-", "0"]


def test_tolerance_belongs_to_the_largest_value_of_the_column(against):
    """1e-3 of the maximum, added where the column is zero: 0.9e-3 is refused, 1.1e-3 is not."""
    energy = dcb()["kinetic_energy"].copy()
    energy[0] += 1e-3 * np.max(np.abs(energy))
    other = changed("kinetic_energy", energy)
    assert against(other, "--rtol", "0.9e-3")[0].returncode == 1
    assert against(other, "--rtol", "1.1e-3")[0].returncode == 0
    assert against(other, "--rtol", "0", "--atol", "1.1e-9")[0].returncode == 0


def test_a_column_may_have_its_own_tolerance(against):
    other = dcb(factor=1.05)
    assert against(other)[0].returncode == 1
    assert against(other, "--tolerance", "G_*=0.06")[0].returncode == 0
    assert against(other, "--tolerance", "G_*=0.06", "--tolerance", "G_vcct_I=0,1e-9")[0].returncode == 1


def test_columns_may_be_chosen_or_ignored(against):
    other = dcb(factor=1.05)
    assert against(other, "--columns", "time", "crack_opening")[0].returncode == 0
    assert against(other, "--ignore", "G_*")[0].returncode == 0


def test_missing_columns_are_named(against):
    other = dcb()
    del other["step"]
    other["extra"] = other["time"]
    result, rows = against(other)
    assert result.returncode == 1
    assert rows["step"].endswith("missing in B") and rows["extra"].endswith("missing in A")


def test_different_lengths_are_named(against):
    result, rows = against(dcb(samples=601))
    assert result.returncode == 1 and rows["(rows)"].endswith("A has 1201 samples, B has 601") and result.stdout.count("samples") == 1


def test_interpolation_onto_other_times(against):
    assert against(dcb(samples=4801), "--interpolate", "--ignore", "step", "--rtol", "1e-12")[0].returncode == 0
    result, rows = against(dcb(samples=997), "--interpolate", "--ignore", "step", "--rtol", "1e-3")
    assert result.returncode == 0
    assert not rows["crack_opening"].split()[1] == "0"


def test_interpolation_does_not_hide_a_run_that_ended_early(against):
    result, _ = against(dcb(samples=1001, end=1e-3), "--interpolate", "--ignore", "step")
    assert result.returncode == 1 and "B covers 0 to 0.001 s, A 0 to 0.0012 s" in result.stdout


BENT = [(-4e-3, 0.0), (0.0, 0.0), (3e-3, 4e-3)]


def with_paths(path, *last):
    """A result with two snapshots of cracks: one in which they are short, and the last."""
    write_result(path)
    with h5py.File(path, "a") as file:
        file["input/namelist"][()] = "&crack\n   kind = 'path'\n"
        for block in ("mesh", "particles"):
            file[f"VTKHDF/{block}/Steps/Values"] = [0.0, 1e-3]
        snapshots = [[[(0.0, 0.0), (1e-3, 0.0)]], last]
        lines = [[np.column_stack([points, np.zeros(len(points))]) for points in cracks] for cracks in snapshots]
        counts = [sum(map(len, cracks)) for cracks in lines]
        cells = [sum(len(points) - 1 for points in cracks) for cracks in lines]
        group = file.create_group("VTKHDF/cracks")
        group["Points"] = np.concatenate(sum(lines, []))
        group["PointData/tip"] = np.zeros(sum(counts))
        group["CellData/crack"] = np.concatenate([np.full(len(points) - 1, number + 1) for cracks in lines
                                                  for number, points in enumerate(cracks)])
        ends = [first + np.arange(len(points)) for cracks in lines
                for first, points in zip(np.cumsum([0, *map(len, cracks)]), cracks)]
        group["Connectivity"] = np.concatenate([np.column_stack([of[:-1], of[1:]]).ravel() for of in ends])
        group["NumberOfPoints"], group["NumberOfCells"] = counts, cells
        group["NumberOfConnectivityIds"] = 2 * np.array(cells)
        group["Steps/PointOffsets"], group["Steps/CellOffsets"] = [0, counts[0]], [0, cells[0]]
        group["Steps/ConnectivityIdOffsets"] = [0, 2 * cells[0]]
    return path


@pytest.mark.parametrize("other, distance", [
    (BENT, 0.0), (BENT[::-1], 0.0), ([(-4e-3, 0.0), (-1e-3, 0.0), *BENT[1:]], 0.0),     # the same line, by other points
    ([(x, y + 1e-4) for x, y in BENT], 1e-4), (BENT[:2], 5e-3),                         # aside; shorter: by the way of the other tip
    ([(-4e-3, 0.0), (3e-3, 4e-3)], 16 / np.sqrt(65) * 1e-3),                            # straight: the height of the kink over it
])
def test_paths_of_cracks(tmp_path, script, other, distance):
    """The largest distance of the last paths, in m and over their length, whatever points they are given by."""
    a, b = with_paths(tmp_path / "a.h5", BENT), with_paths(tmp_path / "b.h5", other)
    for tolerance in {0.99 * distance + 1e-12, 1.01 * distance + 1e-12}:
        result = script("compare.py", a, b, "--paths", tolerance)
        row, = [line for line in result.stdout.splitlines() if line.startswith("path of crack 1")]
        assert float(row.split()[4]) == pytest.approx(distance, rel=1e-3, abs=1e-15)
        assert float(row.split()[5]) == pytest.approx(distance / 9e-3, rel=0.05, abs=1e-15)
        agrees = distance <= tolerance
        assert result.returncode == (0 if agrees else 1)
        assert row.endswith("equal" if agrees else "DIFFERS")
        assert ("all 7 columns and paths agree" if agrees else "1 of 7 columns and paths differ") in result.stdout
    assert script("compare.py", a, b).returncode == 0


def test_a_crack_that_one_file_has_is_named(tmp_path, script):
    a, b = with_paths(tmp_path / "a.h5", BENT), with_paths(tmp_path / "b.h5", BENT, [(0.0, 1e-2), (1e-2, 1e-2)])
    result = script("compare.py", a, b, "--paths", 1e-6)
    assert result.returncode == 1 and "path of crack 2" in result.stdout and "missing in A" in result.stdout


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_values_that_are_not_finite_differ_whatever_the_tolerance(against, value):
    opening = dcb()["crack_opening"].copy()
    opening[5] = value
    assert against(changed("crack_opening", opening), "--rtol", "1e9")[0].returncode == 1


def test_exact_sees_the_last_bit_and_the_type(against):
    opening = dcb()["crack_opening"].copy()
    opening[7] = np.nextafter(opening[7], 1)
    other = changed("crack_opening", opening)
    assert against(other)[0].returncode == 0
    result, rows = against(other, "--exact")
    assert result.returncode == 1 and rows["crack_opening"].endswith("DIFFERS")
    result, rows = against(changed("step", dcb()["step"].astype(np.int64)), "--exact")
    assert result.returncode == 1 and rows["step"].endswith("A is int32, B is int64")
