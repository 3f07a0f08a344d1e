"""Snapshots as VTK reads them from a result file."""

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader


def read_steps(path):
    """Times and, for every time, the two blocks, particles and mesh."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = list(reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()))
    steps = []
    for time in times:
        reader.UpdateTimeStep(time)
        data = reader.GetOutputDataObject(0)
        assert data.GetNumberOfPartitionedDataSets() == 2
        copies = [data.GetPartition(block, 0).NewInstance() for block in range(2)]
        for block, copy in enumerate(copies):
            copy.DeepCopy(data.GetPartition(block, 0))
        steps.append(copies)
    return times, steps


def points(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


def field(data, name):
    return vtk_to_numpy(data.GetArray(name))


def field_names(data):
    return [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]
