#!/usr/bin/env python3
"""Looks for intersections in the frames of a run (pip install ipctk meshio).

    check_contact_frames.py CASE.json DIR    DIR holds frames/*.vtu of a run of the case

Cloth and lines with cloth by ipctk, every edge against every triangle; with planes, balls, bars and boxes of `contact`
by ipctk's distances. Where `contact` names canopies alone, their lines may pass through them. Prints one line; exit
status 1 and the frame where anything passes through anything.
"""

import json
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import ipctk
import meshio
import numpy as np

def read(path, lines=True):
    """Points [m], edges and triangles of a frame, perhaps without the edges that are no side of a triangle."""
    frame = meshio.read(path)
    cells = {kind: np.empty((0, n), np.int32) for kind, n in (("line", 2), ("triangle", 3))}
    for i, block in enumerate(frame.cells):
        if block.type in cells:
            kept = block.data.astype(np.int32)
            if not lines and "kind" in frame.cell_data:
                kept = kept[frame.cell_data["kind"][i].ravel() < 2]
            cells[block.type] = np.vstack([cells[block.type], kept])
    return np.asarray(frame.points, float), cells["line"], cells["triangle"]


def of_canopies(case):
    """Whether the contact of a case is that of canopies, or of parts of them, alone."""
    pairs = [contact["between"] for contact in case["system"]["network"].get("contact", [])]
    sides = [side for pair in pairs for side in ([pair] if pair == "self" else pair)]
    return bool(sides) and all(isinstance(side, str) and side.startswith("canopy") for side in sides)


def frames_of(folder):
    """Paths of the frames that the .pvd of a folder lists, with their times [s]."""
    pvd = next(folder.glob("*.pvd"))
    listed = ElementTree.parse(pvd).getroot().findall("./Collection/DataSet")
    return [(folder / entry.get("file"), float(entry.get("timestep"))) for entry in listed]


def obstacles(case):
    """The rigid bodies of a case, each once."""
    found = []
    for contact in case["system"]["network"].get("contact", []):
        if contact["between"] != "self":
            found += [side for side in contact["between"] if isinstance(side, dict) and side not in found]
    return found


def moved(body, t):
    """[m] displacement of a rigid body"""
    table = np.array(body.get("motion", {"table": [[0, 0, 0, 0]]})["table"], float)
    return np.array([np.interp(t, table[:, 0], table[:, k]) for k in (1, 2, 3)])


def box(body):
    lo, hi = (np.array(body[key], float) for key in ("min", "max"))
    corners = np.array([[(lo, hi)[i >> k & 1][k] for k in range(3)] for i in range(8)])
    # Two triangles of each side; how they are turned does not matter here.
    quads = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return corners, np.array(triangles, np.int32)


def depth(body, t, x, edges, triangles):
    """[m] How deep the scene is in a plane, ball, bar or box; 0 outside."""
    shift = moved(body, t)
    if "plane" in body:
        point, normal = (np.array(body["plane"][key], float) for key in ("point", "normal"))
        return max(0.0, -((x - point - shift) @ normal).min() / np.linalg.norm(normal))
    if "sphere" in body:
        center, radius = np.array(body["sphere"]["center"], float) + shift, body["sphere"]["radius"]
        squares = [ipctk.point_point_distance(center, p) for p in x]
        squares += [ipctk.point_edge_distance(center, *x[e]) for e in edges]
        squares += [ipctk.point_triangle_distance(center, *x[f]) for f in triangles]
        return max(0.0, radius - min(squares) ** 0.5)
    if "cylinder" in body:
        bar = body["cylinder"]
        ends, radius = [np.array(bar[key], float) + shift for key in ("from", "to")], bar["radius"]
        squares = [ipctk.point_edge_distance(p, *ends) for p in x]
        squares += [ipctk.edge_edge_distance(*ends, *x[e]) for e in edges]
        squares += [ipctk.point_triangle_distance(end, *x[f]) for end in ends for f in triangles]
        return max(0.0, radius - min(squares) ** 0.5)
    if "box" in body:
        corners, _ = box(body["box"])
        lo, hi = corners[0] + shift, corners[7] + shift
        inside = np.minimum(x - lo, hi - x).min(axis=1).max()
        return max(0.0, inside)
    return 0.0


def crosses(case, t, x, edges, triangles):
    """Whether ipctk finds an edge that passes through a triangle, those of boxes and files of the case included."""
    for body in obstacles(case):
        if "box" in body:
            corners, sides = box(body["box"])
            pairs = np.vstack([sides[:, [0, 1]], sides[:, [1, 2]], sides[:, [2, 0]]])
            pairs = np.unique(np.sort(pairs, axis=1), axis=0).astype(np.int32)
            edges, triangles = np.vstack([edges, pairs + len(x)]), np.vstack([triangles, sides + len(x)])
            x = np.vstack([x, corners + moved(body, t)])
    if not len(triangles):
        return False
    mesh = ipctk.CollisionMesh(x, edges.astype(np.int32), triangles.astype(np.int32))
    return ipctk.has_intersections(mesh, x)


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    case, folder = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")), pathlib.Path(sys.argv[2])
    frames = frames_of(folder)
    for path, t in frames:
        x, edges, triangles = read(path, not of_canopies(case))
        if crosses(case, t, x, edges, triangles):
            print(f"{path}: an edge passes through a triangle at t = {t:g} s", file=sys.stderr)
            return 1
        for body in obstacles(case):
            deep = depth(body, t, x, edges, triangles)
            if deep > 0:
                print(f"{path}: {deep:.3g} m deep in {next(iter(body))} at t = {t:g} s", file=sys.stderr)
                return 1
    print(f"{folder}: {len(frames)} frames without an intersection")
    return 0


if __name__ == "__main__":
    sys.exit(main())
