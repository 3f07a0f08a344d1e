"""Result files as VTK reads them, which ParaView and PyVista do too: beside what h5py reads by the rules of VTKHDF, on which other tests stand."""

import subprocess

import numpy as np
import pytest

pytest.importorskip("vtkmodules", reason="VTK is not installed: tools/setup.sh verify")

from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: E402
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet  # noqa: E402
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline  # noqa: E402
from vtkmodules.vtkIOHDF import vtkHDFReader  # noqa: E402

from paths import INPUT, PROGRAM, RESULTS_DRIVER  # noqa: E402
from snapshots import BLOCKS, read_steps  # noqa: E402

pytestmark = [pytest.mark.verify, pytest.mark.xdist_group("test_vtk")]  # which share the runs of a fixture

# Two cracks of which one has an edge, in cells of two sizes, with a part that comes to rest on it
CRACKS = """&run end_time = 4e-6 /
&grid lower = -12e-3, -12e-3  cell = 1e-3  cells = 24, 24 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'steel'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 0.0, 40e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -40e3 /
&crack kind = 'path'  points = -4.1e-3, -1.3e-3, 3.7e-3, 2.2e-3 /
&crack kind = 'path'  points = -10e-3, 5.3e-3, -7.2e-3, 6.1e-3, -4.6e-3, 7.2e-3 /
&refine indicator = 'tip'  max_level = 1  rings = 2 /
&output snapshot_interval = 2e-6 /
"""


def reader_of(path):
    """VTK's reader of a result file, which has been asked what there is, as ParaView and PyVista do."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    return reader


def read_by_vtk(path):
    """Times and, for every time, the blocks."""
    reader = reader_of(path)
    times = list(reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()))
    steps = []
    for time in times:
        reader.UpdateTimeStep(time)
        data = reader.GetOutputDataObject(0)
        copies = [data.GetBlock(block).NewInstance() for block in range(data.GetNumberOfBlocks())]
        for block, copy in enumerate(copies):
            copy.DeepCopy(data.GetBlock(block))
        steps.append(copies)
    return times, steps


def arrays(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Results of the driver, of which the blocks change in size, and of runs: a beam on a grid line, and cracks in any direction."""
    path = tmp_path_factory.mktemp("results")
    subprocess.run([RESULTS_DRIVER, path], check=True, capture_output=True)
    if PROGRAM.exists():
        (path / "cracks.nml").write_text(CRACKS)
        for words in ([INPUT / "dcb.nml", "--set", "grid.cell=5e-3", "--set", "grid.cells=20,3", "--set", "run.end_time=3e-4", "--set", "output.snapshot_interval=1e-4"],
                      ["cracks.nml"]):
            subprocess.run([PROGRAM, *words, "--quiet"], cwd=path, check=True, capture_output=True)
    return path


@pytest.mark.parametrize(("name", "blocks"), [("results", 2), ("dcb", 2), ("cracks", 3)])
def test_vtk_reads_what_h5py_reads(folder, name, blocks, capfd):
    """Times, points, cells and fields of each snapshot, of the same types; and has nothing to complain of."""
    path = folder / f"{name}.h5"
    if not path.exists():
        pytest.skip("the program has not been built")
    (times, steps), (own_times, own_steps) = read_by_vtk(path), read_steps(path)
    assert times == own_times and len(times) > 1
    for step, own_step in zip(steps, own_steps, strict=True):
        assert len(step) == blocks
        for data, own in zip(step, own_step, strict=True):
            found = vtk_to_numpy(data.GetPoints().GetData())
            np.testing.assert_array_equal(found, own.points)
            assert found.dtype == own.points.dtype
            cells = [[data.GetCell(k).GetPointId(i) for i in range(data.GetCell(k).GetNumberOfPoints())] for k in range(data.GetNumberOfCells())]
            assert cells == [list(cell) for cell in own.cells] and [data.GetCellType(k) for k in range(len(cells))] == list(own.kinds)
            assert all(data.GetCell(k).GetBounds()[:4] == tuple(own.bounds(k)[:4]) for k in range(len(cells)))
            for fields, own_fields in ((data.GetPointData(), own.point_data), (data.GetCellData(), own.cell_data)):
                assert sorted(arrays(fields)) == sorted(own_fields)
                for field, values in arrays(fields).items():
                    np.testing.assert_array_equal(values, own_fields[field])
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["results", "cracks"])
def test_vtk_names_the_blocks(folder, name):
    if not (folder / f"{name}.h5").exists():
        pytest.skip("the program has not been built")
    reader = reader_of(folder / f"{name}.h5")
    reader.Update()
    blocks = reader.GetOutputDataObject(0)
    names = [blocks.GetMetaData(k).Get(vtkCompositeDataSet.NAME()) for k in range(blocks.GetNumberOfBlocks())]
    assert names == list(BLOCKS[:len(names)])


def test_vtk_reads_the_file_of_a_killed_program(tmp_path):
    with subprocess.Popen([RESULTS_DRIVER, tmp_path, "killed"], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"flushed\n"
        process.kill()
    assert read_by_vtk(tmp_path / "killed.h5")[0] == [0.0, 1e-3]


def test_vtk_gives_the_time_that_is_asked_for_in_any_order(folder):
    """VTK 9.6.2 and later take the first for all where they do not find the number of snapshots at once."""
    reader = reader_of(folder / "results.h5")
    for k in (2, 0, 1, 1, 2):
        reader.UpdateTimeStep(1e-3 * k)
        data = reader.GetOutputDataObject(0)
        assert [data.GetBlock(block).GetNumberOfPoints() for block in range(2)] == [5 + 3 * k, 6 + 2 * k]
        assert vtk_to_numpy(data.GetFieldData().GetArray("Time")) == 1e-3 * k
        reader.SetStep((k + 1) % 3)
        reader.Update()
