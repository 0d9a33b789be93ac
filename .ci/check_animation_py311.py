#!/usr/bin/env python3
"""Reads the animation that canopy-fem exports as .glb with Blender, whose wheels are for one Python.

    check_animation_py311.py FOLDER [PICTURE.png]    canopy.glb, and expected.json of check_animation.py

At the time of every frame each vertex is where a node of the frame is. With PICTURE it also draws the last frame.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

folder = Path(sys.argv[1])
expected = json.loads((folder / "expected.json").read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=str(folder / "canopy.glb"))
scene = bpy.context.scene
meshes = [item for item in bpy.data.objects if item.type == "MESH"]
assert sum(len(item.data.polygons) for item in meshes) == expected["triangles"], meshes
assert all(len(item.data.shape_keys.key_blocks) == len(expected["times"]) for item in meshes), "a shape for each frame"


def places():
    """Where the vertices are, as drawn."""
    graph = bpy.context.evaluated_depsgraph_get()
    found = []
    for item in meshes:
        drawn = item.evaluated_get(graph)
        found += [drawn.matrix_world @ vertex.co for vertex in drawn.to_mesh().vertices]
        drawn.to_mesh_clear()
    return np.array(found)


rate = scene.render.fps / scene.render.fps_base
nodes = None
for t, frame in zip(expected["times"], map(np.array, expected["frames"])):
    at = t * rate
    scene.frame_set(int(at), subframe=at - int(at))
    found = places()
    if nodes is None:
        # Which node a vertex is, from the first frame.
        nodes = np.array([np.abs(frame - x).sum(axis=1).argmin() for x in found])
        assert len(set(nodes)) == len(frame), "a node is missing"
    worst = np.abs(found - frame[nodes]).max()
    assert worst <= 1e-4 * max(1.0, np.abs(frame).max()), f"t = {t} s: {worst} m away"
print(f"animation: Blender reads .glb, {len(expected['times'])} frames, {len(nodes)} vertices")

if len(sys.argv) > 2:
    frame = np.array(expected["frames"][-1])
    middle, size = (frame.min(axis=0) + frame.max(axis=0)) / 2, np.ptp(frame, axis=0).max()
    for name, data in (("camera", bpy.data.cameras.new("camera")), ("sun", bpy.data.lights.new("sun", "SUN"))):
        item = bpy.data.objects.new(name, data)
        scene.collection.objects.link(item)
        item.location = middle + size * np.array([1.5, -1.5, 0.4])
        item.rotation_euler = (1.38, 0, 0.785)
    scene.camera = bpy.data.objects["camera"]
    scene.camera.data.clip_end = 100 * size
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (0.7, 0.8, 0.9)
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 16
    scene.render.resolution_x, scene.render.resolution_y = 640, 640
    scene.render.filepath = str(Path(sys.argv[2]).absolute())
    bpy.ops.render.render(write_still=True)
