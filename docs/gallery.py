#!/usr/bin/env python3
"""Pictures of runs, drawn without a screen. Needs VTK: pip install vtk.

    docs/gallery.py draw out/c9-drop c9.png --times 0 0.4 0.8 8     frames of a run, side by side
    docs/gallery.py draw out/rim rim.png --colour pressure --azimuth 30 --elevation 20
    docs/gallery.py draw out/snow net.png --colour plain --lines tension --elevation 25
    docs/gallery.py all                                             runs the cases of the guide's gallery and draws them

Triangles are coloured by `--colour`: `gores` (by turns, for canopies with a group `radials`), `plain`, `speed`, `pressure`
(or any other array of the triangles or nodes). Lines are edges that belong to no triangle; with `--lines` all that have a spring,
coloured by an array, with a bar that says from where to where. Points of a frame are where the
nodes are at that time, so nothing is moved by the displacement.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import validation
import vtk
from vtk.util.numpy_support import vtk_to_numpy

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs/guide/src/pictures"
LIGHT, DARK, LINES, PAYLOAD = (0.96, 0.95, 0.91), (0.89, 0.40, 0.16), (0.25, 0.25, 0.3), (0.2, 0.25, 0.35)
SKY, INK = (0.88, 0.93, 0.98), (0.1, 0.1, 0.2)
# [px] width of the strip with the colours' numbers
BAR = 110
# Names of numbers, with units; words of numbers that stand for states.
NAMES = {"pressure": "pressure [Pa]", "speed": "speed [m/s]", "tension": "tension [N]", "strain": "strain [-]",
         "stress_1": "stress [Pa]", "stress_2": "smaller stress [Pa]"}
STATES = {"wrinkling": ("taut", "wrinkled", "slack")}


@dataclass
class Picture:
    """What is drawn, and from where."""
    run: Path
    png: Path
    # [s] the nearest frames are drawn
    times: list
    # further runs, of which the last frames are drawn, each with its name
    beside: list = field(default_factory=list)
    colour: str = "gores"
    # array of the springs
    lines: str | None = None
    # [degrees] of the camera around z, and above the horizontal
    azimuth: float = 60.0
    elevation: float = -12.0
    # [px] of one frame
    width: int = 300
    height: int = 420
    # edge of what is shown over that of the scene
    zoom: float = 1.0
    # a direction that points upwards
    up: tuple = (0, 0, 1)


def frames(run):
    """Times [s] and files of the frames of a run."""
    collection = next(iter(sorted(run.glob("*.pvd"))), None)
    if collection is None:
        sys.exit(f"{run} holds no .pvd file; `canopy-fem solve` writes one")
    rows = re.findall(r'timestep="([^"]+)"[^>]*file="([^"]+)"', collection.read_text())
    return [(float(t), run / file) for t, file in rows]


def read(path):
    """The grid of a frame."""
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def cells(grid):
    """Nodes of the triangles, and of the edges that belong to no triangle; each with its cell's number."""
    triangles, edges = [], []
    for number in range(grid.GetNumberOfCells()):
        nodes = vtk.vtkIdList()
        grid.GetCellPoints(number, nodes)
        ids = [nodes.GetId(k) for k in range(nodes.GetNumberOfIds())]
        (triangles if len(ids) == 3 else edges).append((number, ids))
    sides = {frozenset(pair) for _, (a, b, c) in triangles for pair in ((a, b), (b, c), (c, a))}
    return triangles, [(number, ids) for number, ids in edges if frozenset(ids) not in sides]


def mesh(grid, chosen):
    """Some cells of a frame as data to draw."""
    data, array = vtk.vtkPolyData(), vtk.vtkCellArray()
    data.SetPoints(grid.GetPoints())
    for _, ids in chosen:
        array.InsertNextCell(len(ids), ids)
    (data.SetPolys if chosen and len(chosen[0][1]) == 3 else data.SetLines)(array)
    return data


def members(grid, name, cell_data=True):
    """Which cells, or nodes, are in a group."""
    data = grid.GetCellData() if cell_data else grid.GetPointData()
    numbers, group = data.GetArray("group"), grid.GetFieldData().GetArray(("" if cell_data else "node ") + "group " + name)
    if numbers is None or group is None:
        return []
    kept = set(vtk_to_numpy(group).tolist())
    return [k for k, number in enumerate(vtk_to_numpy(numbers)) if int(number) in kept]


def gores(grid, triangles):
    """0 and 1 by turns from gore to gore: triangles that share a side which is no radial are in the same gore."""
    radials = set()
    for number in members(grid, "radials"):
        cell = grid.GetCell(number)
        radials.add(frozenset((cell.GetPointId(0), cell.GetPointId(1))))
    if not radials:
        return None
    by_side = {}
    for k, (_, (a, b, c)) in enumerate(triangles):
        for side in map(frozenset, ((a, b), (b, c), (c, a))):
            by_side.setdefault(side, []).append(k)
    turn = {}
    for first in range(len(triangles)):
        if first in turn:
            continue
        turn[first], waiting = 0, [first]
        while waiting:
            k = waiting.pop()
            a, b, c = triangles[k][1]
            for side in map(frozenset, ((a, b), (b, c), (c, a))):
                for other in by_side[side]:
                    if other not in turn:
                        turn[other] = turn[k] ^ (side in radials)
                        waiting.append(other)
    return [turn[k] for k in range(len(triangles))]


def values(grid, triangles, colour):
    """A number for each triangle, or None."""
    if colour == "gores":
        return gores(grid, triangles)
    if colour == "plain":
        return None
    if colour == "speed":
        velocity = vtk_to_numpy(grid.GetPointData().GetArray("velocity"))
        speed = (velocity**2).sum(axis=1) ** 0.5
        return [float(speed[ids].mean()) for _, ids in triangles]
    array = grid.GetCellData().GetArray(colour)
    if array is not None:
        return [array.GetTuple1(number) for number, _ in triangles]
    array = grid.GetPointData().GetArray(colour)
    if array is None:
        sys.exit(f"frames have no array {colour!r} with a number for each triangle or node")
    return [sum(array.GetTuple1(k) for k in ids) / 3 for _, ids in triangles]


def actor(data, colour, line_width=1.2):
    """Data to draw, in one colour."""
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    made = vtk.vtkActor()
    made.SetMapper(mapper)
    look = made.GetProperty()
    look.SetColor(*colour)
    look.SetLineWidth(line_width)
    look.SetAmbient(0.3)
    look.SetDiffuse(0.75)
    return made


def cloth(grid, triangles, colour, limits):
    """The triangles, coloured."""
    data, numbers = mesh(grid, triangles), values(grid, triangles, colour)
    made = actor(data, LIGHT)
    if numbers is None:
        return made
    array = vtk.vtkDoubleArray()
    for number in numbers:
        array.InsertNextValue(number)
    data.GetCellData().SetScalars(array)
    if colour != "gores":
        # Colours that can be compared with those of the bar; three states can be told apart in a shade too.
        ambient, diffuse = (0.55, 0.45) if colour in STATES else (0.8, 0.25)
        made.GetProperty().SetAmbient(ambient)
        made.GetProperty().SetDiffuse(diffuse)
    mapper = made.GetMapper()
    mapper.ScalarVisibilityOn()
    mapper.SetLookupTable(colours(colour, limits))
    mapper.UseLookupTableScalarRangeOn()
    return made


def colours(colour, limits):
    """The colours of numbers between limits."""
    table = vtk.vtkLookupTable()
    table.SetTableRange(*((0, 1) if colour == "gores" else limits))
    if colour == "gores":
        table.SetNumberOfTableValues(2)
        table.SetTableValue(0, *LIGHT, 1)
        table.SetTableValue(1, *DARK, 1)
    elif colour in STATES:
        table.SetNumberOfTableValues(len(STATES[colour]))
        table.SetTableRange(-0.5, len(STATES[colour]) - 0.5)
    table.SetHueRange(0.62, 0.0)
    table.SetSaturationRange(0.75, 0.85)
    if colour != "gores":
        table.Build()
    return table


def colour_bar(colour, limits):
    """The colours with their numbers and unit, or with what they mean, for a strip of its own."""
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(colours(colour, limits))
    bar.SetTitle(NAMES.get(colour, colour))
    bar.SetNumberOfLabels(0 if colour in STATES else 5)
    bar.SetLabelFormat("%.3g")
    bar.UnconstrainedFontSizeOn()
    for text, size in ((bar.GetTitleTextProperty(), 15), (bar.GetLabelTextProperty(), 14)):
        text.SetFontSize(size)
        text.SetColor(*INK)
        text.BoldOff()
        text.ItalicOff()
        text.ShadowOff()
    bar.SetPosition(0.08, 0.08)
    bar.SetWidth(0.84)
    bar.SetHeight(0.84)
    bar.SetBarRatio(0.22)
    bar.SetVerticalTitleSeparation(10)
    return bar


def legend(colour, height):
    """What the colours of states mean: a word on each, as actors."""
    made = []
    table = colours(colour, (0, 1))
    for number, word in enumerate(STATES[colour]):
        red, green, blue, _ = table.GetTableValue(number)
        text = vtk.vtkTextActor()
        text.SetInput(f" {word} ")
        look = text.GetTextProperty()
        look.SetFontSize(16)
        look.SetColor(*INK)
        look.SetBackgroundColor(red, green, blue)
        look.SetBackgroundOpacity(0.6)
        text.SetPosition(10, height - 40 - 28 * number)
        made.append(text)
    return made


def springs(grid, name):
    """The edges with a spring, coloured by an array, and the bar of its colours."""
    rest, array = (grid.GetCellData().GetArray(key) for key in ("rest_length", name))
    if rest is None or array is None:
        sys.exit(f"frames have no arrays 'rest_length' and {name!r}; `canopy-fem static` writes them")
    chosen = [k for k in range(grid.GetNumberOfCells()) if rest.GetTuple1(k) >= 0]
    data = mesh(grid, [(k, [grid.GetCell(k).GetPointId(0), grid.GetCell(k).GetPointId(1)]) for k in chosen])
    scalars = vtk.vtkDoubleArray()
    for k in chosen:
        scalars.InsertNextValue(array.GetTuple1(k))
    data.GetCellData().SetScalars(scalars)
    table = vtk.vtkLookupTable()
    table.SetHueRange(0.62, 0.0)
    table.SetSaturationRange(0.75, 0.85)
    table.Build()
    made = actor(data, LINES, line_width=4)
    made.GetMapper().ScalarVisibilityOn()
    made.GetMapper().SetLookupTable(table)
    made.GetMapper().SetScalarRange(*scalars.GetRange())
    # Sides of triangles are drawn over them.
    made.GetMapper().SetResolveCoincidentTopologyToPolygonOffset()
    made.GetMapper().SetRelativeCoincidentTopologyLineOffsetParameters(0, -20)
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle(UNITS.get(name, name))
    bar.SetNumberOfLabels(4)
    bar.SetLabelFormat("%.3g")
    bar.SetOrientationToHorizontal()
    bar.SetPosition(0.2, 0.85)
    bar.SetPosition2(0.6, 0.14)
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        text.SetColor(0.1, 0.1, 0.2)
        text.ShadowOff()
        text.ItalicOff()
    return made, bar


UNITS = {"tension": "tension [N]", "strain": "strain [-]", "rest_length": "rest length [m]"}


def ball(centre, radius):
    """A payload."""
    sphere = vtk.vtkSphereSource()
    sphere.SetCenter(*centre)
    sphere.SetRadius(radius)
    sphere.SetThetaResolution(24)
    sphere.SetPhiResolution(24)
    sphere.Update()
    return actor(sphere.GetOutput(), PAYLOAD)


def aim(renderer, picture, grid, size):
    """Turns the camera to the middle of a frame; all frames have the same scale."""
    from math import cos, radians, sin
    low_high = grid.GetBounds()
    middle = [0.5 * (low_high[2 * k] + low_high[2 * k + 1]) for k in range(3)]
    azimuth, elevation = radians(picture.azimuth), radians(picture.elevation)
    level = (cos(azimuth) * cos(elevation), sin(azimuth) * cos(elevation), sin(elevation))
    # With y upwards the angles count around y.
    towards = level if picture.up == (0, 0, 1) else (level[0], level[2], level[1])
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(*middle)
    camera.SetPosition(*(m + 3 * size * d for m, d in zip(middle, towards)))
    camera.SetViewUp(*picture.up)
    camera.ParallelProjectionOn()
    camera.SetParallelScale(0.5 * size / picture.zoom)
    renderer.ResetCameraClippingRange()


def draw(picture):
    """Draws frames of a run side by side."""
    known = frames(picture.run)
    chosen = [min(known, key=lambda frame: abs(frame[0] - t)) for t in picture.times or [known[-1][0]]]
    chosen = [(f"t = {t:g} s", path) for t, path in chosen]
    if picture.beside:
        chosen = [(run.name, frames(run)[-1][1]) for run in [picture.run, *picture.beside]]
    grids = [(label, read(path)) for label, path in chosen]
    parts = [cells(grid) for _, grid in grids]
    size = max(max(b[1] - b[0], b[3] - b[2], b[5] - b[4]) for b in (grid.GetBounds() for _, grid in grids)) * 1.08
    numbers = [n for (_, grid), (triangles, _) in zip(grids, parts) for n in values(grid, triangles, picture.colour) or []]
    low, high = min(numbers, default=0), max(numbers, default=1)
    # A bar from about 0 begins there.
    limits = (0 if 0 < low < 0.02 * high else low, high)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    numbered = picture.colour not in ("gores", "plain")
    strip = BAR if numbered else 0
    width = picture.width * len(grids) + strip
    window.SetSize(width, picture.height)
    if numbered:
        renderer = vtk.vtkRenderer()
        renderer.SetViewport(1 - strip / width, 0, 1, 1)
        renderer.SetBackground(*SKY)
        states = legend(picture.colour, picture.height) if picture.colour in STATES else [colour_bar(picture.colour, limits)]
        for one in states:
            renderer.AddViewProp(one)
        window.AddRenderer(renderer)
    for place, ((words, grid), (triangles, edges)) in enumerate(zip(grids, parts)):
        renderer = vtk.vtkRenderer()
        renderer.SetViewport(place * picture.width / width, 0, (place + 1) * picture.width / width, 1)
        renderer.SetBackground(*SKY)
        if triangles:
            renderer.AddActor(cloth(grid, triangles, picture.colour, limits))
        if picture.lines:
            made, bar = springs(grid, picture.lines)
            renderer.AddActor(made)
            renderer.AddViewProp(bar)
        elif edges:
            renderer.AddActor(actor(mesh(grid, edges), LINES))
        for node in members(grid, "payload", cell_data=False):
            renderer.AddActor(ball(grid.GetPoint(node), 0.02 * size))
        label = vtk.vtkTextActor()
        label.SetInput(words)
        label.GetTextProperty().SetFontSize(18)
        label.GetTextProperty().SetColor(*INK)
        label.SetPosition(10, 10)
        renderer.AddViewProp(label)
        aim(renderer, picture, grid, size)
        window.AddRenderer(renderer)
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    image.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(picture.png))
    writer.SetCompressionLevel(9)
    writer.SetInputConnection(image.GetOutputPort())
    picture.png.parent.mkdir(parents=True, exist_ok=True)
    writer.Write()
    print(f"{picture.png}  {picture.png.stat().st_size // 1024} kB" + (f"  {picture.colour} {limits[0]:.3g} to {limits[1]:.3g}"
          if picture.colour not in ("gores", "plain") else ""))


# The gallery: name of the picture, case, and how it is drawn.
CASES, OWN = "assets/cases", "docs/guide/cases"
GALLERY = [
    ("flag", f"{OWN}/flag.json", dict(times=[0, 0.3, 1, 3], colour="plain", azimuth=65, elevation=25, height=300, up=(0, 1, 0), zoom=0.9)),
    ("rim", f"{OWN}/rim.json", dict(times=[0, 0.06, 1], colour="pressure", elevation=20, height=260)),
    ("airbag", f"{OWN}/airbag.json",
     dict(times=[0.01, 0.02, 0.2], colour="wrinkling", azimuth=60, elevation=35, height=260, zoom=0.75)),
    ("hanging-sheet", f"{OWN}/hanging-sheet.json",
     dict(times=[0, 0.3, 0.6, 1], colour="plain", azimuth=60, elevation=20, height=300, zoom=0.75)),
    ("c9-filling", f"{CASES}/parachute/c9-filling.json", dict(times=[0, 0.4, 0.8, 1, 1.15, 1.3, 6], width=240, height=460)),
    ("c9-drop", f"{CASES}/parachute/c9-drop.json", dict(times=[0, 0.2, 0.7, 2, 8])),
    ("t10-drop", f"{CASES}/parachute/t10-drop.json", dict(times=[0, 0.3, 1.1, 15])),
    ("g12-reefed", f"{CASES}/parachute/g12-reefed.json", dict(times=[0, 3, 5, 20], zoom=1.0)),
    ("cluster", f"{CASES}/parachute/cluster.json", dict(times=[0, 3, 10], elevation=-5, azimuth=90)),
    ("dgb-aspire", f"{CASES}/parachute/dgb-aspire.json", dict(times=[0, 1.5], elevation=20)),
    ("gores-sewn", f"{OWN}/gores-sewn.json", dict(times=[0, 0.3], elevation=10, height=320)),
    ("saddle-net", f"{CASES}/saddle-net.json",
     dict(command="static --at 1", times=[], colour="plain", lines="tension", azimuth=70, elevation=35, width=640, height=420)),
    ("cloth", f"{CASES}/cloth-k1000.json", dict(times=[0.1, 0.3, 2], colour="speed", elevation=25, height=300)),
]


def gallery():
    """Runs the cases of the gallery and draws them."""
    program = ROOT / "target/release/canopy-fem"
    if not program.exists():
        sys.exit("build the program first: cargo build --release")
    with tempfile.TemporaryDirectory() as folder:
        for name, case, how in GALLERY:
            run = Path(folder) / name
            command = how.pop("command", "solve").split()
            subprocess.run([program, *command, ROOT / case, "--out", run, "--quiet"], check=True)
            draw(Picture(run=run, png=PICTURES / f"{name}.png", **how))
        first, *others = [flown(Path(folder), program, name) for name in TYPES]
        draw(Picture(run=first, beside=others, png=PICTURES / "types.png", times=[], width=230, height=360, zoom=0.9))


# Types that are drawn beside each other, as docs/validation.py holds them in a stream.
TYPES = ["elliptical", "toroidal", "ribbon", "ringsail", "square", "triangular"]


def flown(folder, program, name):
    """A run of the first of these forms after 2 s."""
    case = validation.held(next(keys for keys, *_ in validation.FORMS.values() if keys["type"] == name))
    case["time"]["end"] = 2.0
    case["output"] = {"frames": {"every": 2.0}}
    (folder / f"{name}.json").write_text(json.dumps(case))
    subprocess.run([program, "solve", folder / f"{name}.json", "--out", folder / name, "--quiet"], check=True)
    return folder / name


def main():
    parser = argparse.ArgumentParser(description="Pictures of runs, drawn without a screen.")
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("all", help="run the cases of the guide's gallery and draw them")
    one = commands.add_parser("draw", help="draw frames of a run")
    one.add_argument("run", type=Path, help="folder of results")
    one.add_argument("png", type=Path, help="picture to write")
    one.add_argument("--times", type=float, nargs="+", default=[], help="[s] times of the frames; the last one if not given")
    one.add_argument("--colour", default="gores", help="gores, plain, speed, pressure, or an array of the frames")
    one.add_argument("--lines", help="tension, or another array of the springs, which are then drawn by it")
    one.add_argument("--azimuth", type=float, default=60.0, help="[degrees] of the camera around z")
    one.add_argument("--elevation", type=float, default=-12.0, help="[degrees] of the camera above the horizontal")
    one.add_argument("--width", type=int, default=300, help="[px] of one frame")
    one.add_argument("--height", type=int, default=420, help="[px]")
    one.add_argument("--zoom", type=float, default=1.0, help="larger shows less")
    one.add_argument("--up", choices=["z", "y"], default="z", help="direction that points upwards")
    given = vars(parser.parse_args())
    if given.pop("command") == "all":
        gallery()
        return
    given["up"] = (0, 0, 1) if given["up"] == "z" else (0, 1, 0)
    draw(Picture(**given))


if __name__ == "__main__":
    main()
