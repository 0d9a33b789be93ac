#!/usr/bin/env python3
"""Reads the .mdpa that canopy-fem writes with Kratos, and the .glb with Blender, whose wheels are for one Python.

    .ci/check_meshes_py311.py FOLDER         cloth.mdpa and cloth.glb of one mesh
"""

import sys
from pathlib import Path

NODES, TRIANGLES, LINES = 10, 8, 2
folder = Path(sys.argv[1])

import KratosMultiphysics as Kratos

part = Kratos.Model().CreateModelPart("cloth")
Kratos.ModelPartIO(str(folder / "cloth"), Kratos.IO.READ | Kratos.IO.SKIP_TIMER).ReadModelPart(part)
assert (part.NumberOfNodes(), part.NumberOfElements()) == (NODES, TRIANGLES + LINES), part
canopy = part.GetSubModelPart("CANOPY")
area = sum(element.GetGeometry().Area() for element in canopy.Elements)
assert canopy.NumberOfElements() == TRIANGLES and abs(area - 1) < 1e-6, canopy
assert 0 < canopy.NumberOfNodes() < NODES and part.GetSubModelPart("LINES").NumberOfElements() == LINES, part
print("meshes: Kratos reads .mdpa")

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=str(folder / "cloth.glb"))
meshes = [item.data for item in bpy.data.objects if item.type == "MESH"]
assert sum(len(mesh.polygons) for mesh in meshes) == TRIANGLES, meshes
assert abs(sum(polygon.area for mesh in meshes for polygon in mesh.polygons) - 1) < 1e-6, meshes
names = {material.name for material in bpy.data.materials} | {item.name for item in bpy.data.objects}
assert any(name.startswith("CANOPY") for name in names), names
# Blender has +Z up: what was up is up.
heights = [vertex.co.z for mesh in meshes for vertex in mesh.vertices]
print(f"meshes: Blender reads .glb, from z = {min(heights):g} to {max(heights):g} m")
