#!/usr/bin/env python3
"""Renders a frame off screen with VTK (pip install vtk; needs OSMesa or EGL, else run it under xvfb-run).

    render_vtu.py FILE OUT.png [ARRAY]    coloured by an array, default displacement z
"""

import sys

from vtkmodules.vtkFiltersCore import vtkArrayCalculator
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkActor, vtkDataSetMapper, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter
import vtkmodules.vtkRenderingFreeType  # noqa: F401  (registers text)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the window)


def source_of(path, array):
    """The grid with a scalar to colour by, and where the scalar sits."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    if grid.GetCellData().HasArray(array):
        return reader, array, True
    if not grid.GetPointData().HasArray(array):
        sys.exit(f"render_vtu: {path} has no array {array}")
    if grid.GetPointData().GetArray(array).GetNumberOfComponents() == 1:
        return reader, array, False
    height = vtkArrayCalculator()
    height.SetInputConnection(reader.GetOutputPort())
    height.AddScalarVariable("z", array, 2)
    height.SetFunction("z")
    height.SetResultArrayName(f"{array} z")
    height.Update()
    return height, f"{array} z", False


def main():
    if len(sys.argv) not in (3, 4):
        print(__doc__, file=sys.stderr)
        return 2
    array = sys.argv[3] if len(sys.argv) == 4 else "displacement"
    source, name, on_cells = source_of(sys.argv[1], array)
    grid = source.GetOutput()
    values = (grid.GetCellData() if on_cells else grid.GetPointData()).GetArray(name)

    mapper = vtkDataSetMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.SetScalarRange(values.GetRange())
    mapper.SetScalarModeToUseCellFieldData() if on_cells else mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(name)
    mapper.GetLookupTable().SetHueRange(2 / 3, 0)  # blue is low, red is high
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().EdgeVisibilityOn()
    actor.GetProperty().SetPointSize(8)
    bar = vtkScalarBarActor()
    bar.SetLookupTable(mapper.GetLookupTable())
    bar.SetTitle(name)

    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    bar.GetTitleTextProperty().SetColor(0, 0, 0)
    bar.GetLabelTextProperty().SetColor(0, 0, 0)
    renderer.AddActor(actor)
    renderer.AddViewProp(bar)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(1000, 750)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(1, -2, 1)
    camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    window.Render()

    image = vtkWindowToImageFilter()
    image.SetInput(window)
    png = vtkPNGWriter()
    png.SetFileName(sys.argv[2])
    png.SetInputConnection(image.GetOutputPort())
    png.Write()
    return 0


if __name__ == "__main__":
    sys.exit(main())
