#!/usr/bin/env python3
"""Renders a frame off screen with VTK (pip install vtk; without a display it uses OSMesa or EGL).

    render_vtu.py FILE OUT.png [ARRAY]    coloured by an array, default displacement (its z)
"""

import sys

from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkFiltersCore import vtkArrayCalculator
from vtkmodules.vtkFiltersExtraction import vtkExtractCellsByType
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkColorTransferFunction,
    vtkDataSetMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)
import vtkmodules.vtkRenderingFreeType  # noqa: F401  (registers text)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the window)

# Cool to warm through a light grey, after K. Moreland, "Diverging color maps for scientific visualization" (2009).
LOW, MIDDLE, HIGH = (0.23, 0.30, 0.75), (0.87, 0.87, 0.87), (0.71, 0.02, 0.15)
WIDTH, HEIGHT = 1000, 560
TRIANGLE = 5
UNITS = {"displacement": "m", "velocity": "m/s", "force": "N", "reaction": "N", "tension": "N", "strain": "-"}


def source_of(path, array):
    """The grid with a scalar to colour by, the scalar's name, and whether it sits on cells."""
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


def colours(low, high):
    """A table of 256 colours over a range."""
    curve = vtkColorTransferFunction()
    curve.SetColorSpaceToDiverging()
    for place, colour in ((0, LOW), (0.5, MIDDLE), (1, HIGH)):
        curve.AddRGBPoint(place, *colour)
    table = vtkLookupTable()
    table.SetNumberOfTableValues(256)
    for i in range(256):
        table.SetTableValue(i, *curve.GetColor(i / 255), 1)
    table.SetRange(low, high)
    return table


def surface(source, name, on_cells):
    """The mesh, lit as cloth is, with thin edges."""
    grid = source.GetOutput()
    values = (grid.GetCellData() if on_cells else grid.GetPointData()).GetArray(name)
    triangles = vtkExtractCellsByType()
    triangles.SetInputConnection(source.GetOutputPort())
    triangles.AddCellType(TRIANGLE)
    triangles.Update()
    # Where there is a surface, its springs are its triangles' edges: drawn as cells too they would flicker over them.
    shown = triangles if triangles.GetOutput().GetNumberOfCells() else source
    mapper = vtkDataSetMapper()
    mapper.SetInputConnection(shown.GetOutputPort())
    mapper.SetLookupTable(colours(*values.GetRange()))
    mapper.UseLookupTableScalarRangeOn()
    mapper.SetInterpolateScalarsBeforeMapping(True)
    mapper.SetScalarModeToUseCellFieldData() if on_cells else mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(name)
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.EdgeVisibilityOn()
    look.SetEdgeColor(0.2, 0.2, 0.25)
    look.SetEdgeOpacity(0.55)
    look.SetLineWidth(1)
    look.SetPointSize(8)
    look.SetAmbient(0.35)
    look.SetDiffuse(0.65)
    look.SetInterpolationToFlat()
    return actor


def legend(actor, title):
    bar = vtkScalarBarActor()
    bar.SetLookupTable(actor.GetMapper().GetLookupTable())
    bar.SetTitle(title)
    bar.SetNumberOfLabels(4)
    bar.SetLabelFormat("%-.3g")
    bar.UnconstrainedFontSizeOn()
    bar.SetPosition(0.85, 0.18)
    bar.SetWidth(0.09)
    bar.SetHeight(0.64)
    for text, size in ((bar.GetTitleTextProperty(), 16), (bar.GetLabelTextProperty(), 15)):
        text.SetColor(0.1, 0.1, 0.1)
        text.SetFontSize(size)
        text.BoldOff()
        text.ItalicOff()
        text.ShadowOff()
    return bar


def main():
    if len(sys.argv) not in (3, 4):
        print(__doc__, file=sys.stderr)
        return 2
    array = sys.argv[3] if len(sys.argv) == 4 else "displacement"
    source, name, on_cells = source_of(sys.argv[1], array)
    actor = surface(source, name, on_cells)
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    renderer.AddViewProp(legend(actor, f"{name} [{UNITS.get(array, '?')}]"))
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(WIDTH, HEIGHT)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(1, -2, 1.15)
    camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    camera.Zoom(1.62)
    camera.SetWindowCenter(0.12, -0.24)
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
