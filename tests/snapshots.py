"""Snapshots as VTK reads them from a result file."""

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader


def reader_of(path):
    """VTK's reader of a result file, which has been asked what there is, as ParaView and PyVista do."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    return reader


def read_steps(path):
    """Times and, for every time, the blocks: particles, mesh and, with cracks in any direction, these."""
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


def points(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


def field(data, name):
    return vtk_to_numpy(data.GetArray(name))


def field_names(data):
    return [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]
