#!/usr/bin/env python3
"""Contact beside MuJoCo's flexes: the same cloths fall on a ball and over a bar.

    benches/peers/contact.py --program target/release/canopy-fem [--out FILE] [--scene NAME] [--only PROGRAM]

Needs Python with numpy and mujoco (requirements.txt). Every run is a process of its own, from start to end; its
processor time is what the system tells of it. Where ipctk is installed, it checks the count of crossings.
"""

import argparse
import csv
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from report import markdown, processor

EVERY = 0.02  # [s] between the frames that are searched for nodes in the ball or the bar
GAP = 0.01  # [m] ours; MuJoCo gets half of it as the radius of a flex, and half on the ball and the bar
FRICTION = 0.3
STRETCH = 500.0  # [N/m] of every spring
TIME = 1e-4  # [s] c = TIME STRETCH of the dashpot along it
DRAG = 3.0  # [1/s] c = DRAG m at every node, so that the cloth comes to rest
WEIGHT = 9.81
DENSITY = 0.3  # [kg/m^2]


@dataclass
class Drape:
    name: str
    told: str
    cells: int  # along a side
    tilt: float  # slope of the sheet along x at the start
    ball: tuple | None = None  # centre, radius
    bar: tuple | None = None  # half the length along y, height of the axis, radius
    end: float = 1.5

    def sheet(self):
        """Nodes of 1 m by 1 m about the origin, triangles with turning diagonals, edges, masses."""
        n = self.cells
        line = np.linspace(-0.5, 0.5, n + 1)
        x, y = (a.ravel() for a in np.meshgrid(line, line))
        slope = np.hypot(1.0, self.tilt)
        nodes = np.stack([x / slope, y, self.tilt * x / slope], axis=1)
        triangles = []
        for j in range(n):
            for i in range(n):
                a = j * (n + 1) + i
                b, c, d = a + 1, a + n + 2, a + n + 1
                triangles += [[a, b, c], [a, c, d]] if (i + j) % 2 == 0 else [[a, b, d], [b, c, d]]
        triangles = np.array(triangles)
        edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
        mass = np.zeros(len(nodes))
        np.add.at(mass, triangles.ravel(), DENSITY * 0.5 / n**2 / 3.0)
        return nodes, triangles, edges, mass

    def distance(self, x):
        """[m] Of the nearest node from the surface; below 0 it is inside."""
        if self.ball:
            return np.min(np.linalg.norm(x - self.ball[0], axis=-1)) - self.ball[1]
        half, height, radius = self.bar
        at = np.array([0.0, 1.0, 0.0]) * np.clip(x[..., 1:2], -half, half) + [0.0, 0.0, height]
        return np.min(np.linalg.norm(x - at, axis=-1)) - radius


BALL = ((0.02, 0.01, -0.28), 0.25)
SCENES = [
    Drape("ball-441", "441 nodes fall on a ball and drape over it", 20, 0.0, ball=BALL),
    Drape("ball-2025", "2,025 nodes fall on a ball and drape over it", 44, 0.0, ball=BALL, end=1.0),
    Drape(
        "bar-441",
        "441 nodes fall over a round bar of 8 cm, and the halves swing against each other",
        20,
        0.2,
        bar=(0.6, -0.08, 0.04),
    ),
]


# canopy-fem


def case(scene):
    nodes, triangles, _, _ = scene.sheet()
    if scene.ball:
        body = {"sphere": {"center": scene.ball[0], "radius": scene.ball[1]}}
    else:
        half, height, radius = scene.bar
        body = {"cylinder": {"from": [0, -half, height], "to": [0, half, height], "radius": radius}}
    touch = {"gap": GAP, "friction": FRICTION}
    return {
        "name": scene.name,
        "system": {
            "network": {
                "mesh": {"explicit": {"nodes": nodes.tolist(), "triangles": triangles.tolist()}},
                "mass": {"areal_density": DENSITY},
                "springs": [{"on": "all", "stiffness": STRETCH, "dashpot": {"axial": {"time": TIME}}}],
                "damping": {"rayleigh": {"mass": DRAG}},
                "gravity": [0, 0, -WEIGHT],
                "contact": [{"between": "self", **touch}, {"between": ["all", body], **touch}],
            }
        },
        "time": {"end": scene.end, "method": "backward-euler", "step": 4e-3},
        "output": {
            "frames": {"every": EVERY},
            "probes": [{"name": "all", "on": "all"}],
            "crossings": "none",
        },
    }


def ours(scene, setting, program, folder):
    """One run of canopy-fem: positions at every frame, steps, energy error."""
    method, step = setting
    file = Path(folder, "case.json")
    file.write_text(json.dumps(case(scene)), encoding="utf-8")
    out = Path(folder, "out")
    command = [program, "solve", str(file), "--method", method, "--step", repr(step), "--out", str(out), "--quiet"]
    cpu, code, said = watched(command, folder)
    if not (out / "summary.json").is_file():
        return Outcome(cpu, said=said)
    told = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    rows = np.loadtxt(out / "probes.csv", delimiter=",", skiprows=1, usecols=(3, 4, 5))
    n = len(scene.sheet()[0])
    whole = rows[: len(rows) // n * n].reshape(-1, n, 3)
    if code != 0:
        print(f"{scene.name}, {method}: {said}", file=sys.stderr)
    said = "" if code == 0 else f"stopped at {told['t_end']:.3g} s"
    return Outcome(cpu, whole, told["steps"], told["energy_error"], said)


# MuJoCo


def model(scene, stretch, step):
    """The same cloth, as peer_mujoco.py has it, with a flex of triangles that touches.

    `springs`: a flex of dimension 1 on the same bodies. `equality`: the edges are constraints that keep their length.
    """
    nodes, triangles, edges, mass = scene.sheet()

    def vector(x):
        return " ".join(map(repr, np.asarray(x).ravel().tolist()))

    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    bodies = []
    for i, (x, m) in enumerate(zip(nodes, mass.tolist(), strict=True)):
        inertia = f'<inertial pos="0 0 0" mass="{m!r}" diaginertia="1 1 1"/>'
        bodies.append(f'<body name="{i}" pos="{vector(x)}">{inertia}{slides}</body>')
    rub, thick = f'friction="{FRICTION}"', GAP / 2
    if scene.ball:
        center, radius = scene.ball
        body = f'<geom type="sphere" pos="{vector(center)}" size="{radius + thick!r}" {rub}/>'
    else:
        half, height, radius = scene.bar
        ends = vector([0, -half, height, 0, half, height])
        body = f'<geom type="capsule" fromto="{ends}" size="{radius + thick!r}" {rub}/>'
    on = f'body="{vector(range(len(nodes)))}" vertex="{" ".join(["0"] * 3 * len(nodes))}"'
    touch = f'<contact selfcollide="auto" {rub}/>'
    cloth = f'<flex name="cloth" dim="2" radius="{thick}" {on} element="{vector(triangles)}">{touch}</flex>'
    if stretch == "springs":
        made_of = f'<contact contype="0" conaffinity="0"/><edge stiffness="{STRETCH}" damping="{TIME * STRETCH}"/>'
        cloth += f'<flex name="net" dim="1" {on} element="{vector(edges)}">{made_of}</flex>'
        hold = ""
    else:
        hold = '<equality><flex flex="cloth"/></equality>'
    # As its own cloths have it, `model/flex/flag.xml`.
    option = f'<option timestep="{step!r}" gravity="0 0 {-WEIGHT}" solver="CG" tolerance="1e-6"/>'
    head = f'<mujoco>{option}<size memory="1G"/><worldbody>{body}'
    return f"{head}{''.join(bodies)}</worldbody><deformable>{cloth}</deformable>{hold}</mujoco>"


def run_mujoco(scene, stretch, step, file):
    """In a process of its own."""
    import mujoco

    made = mujoco.MjModel.from_xml_string(model(scene, stretch, step))
    data = mujoco.MjData(made)
    nodes, _, _, mass = scene.sheet()
    drag = np.repeat(DRAG * mass, 3)  # bodies of a flex may have no damping of joints
    each, frames = round(EVERY / step), [nodes]
    for _ in range(round(scene.end / EVERY)):
        for _ in range(each):
            np.multiply(drag, -data.qvel, out=data.qfrc_applied)
            mujoco.mj_step(made, data)
        # After a bad state it starts again from the first one.
        if any(w.number for w in (data.warning[i] for i in range(len(data.warning)))):
            break
        frames.append(nodes + data.qpos.reshape(-1, 3))
    np.save(file, np.array(frames))


def mujocos(scene, setting, _program, folder):
    stretch, step = setting
    file = Path(folder, "frames.npy")
    cpu, _, said = watched(
        [sys.executable, str(Path(__file__).resolve()), "--mujoco", scene.name, stretch, repr(step), str(file)], folder
    )
    if not file.is_file():
        return Outcome(cpu, said=said)
    x = np.load(file)
    reached = (len(x) - 1) * EVERY
    said = "" if reached > scene.end - EVERY / 2 else f"unstable after {reached:.3g} s"
    return Outcome(cpu, x, round(reached / step), None, said)


# What both share


@dataclass
class Outcome:
    cpu: float  # [s]
    frames: np.ndarray | None = None
    steps: int = 0
    energy: float | None = None
    said: str = ""


LIMIT = 300  # [s] of a run, by the clock


def watched(command, folder):
    """Processor time of a process from start to end, its exit code, and the end of what it said."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    single = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env=os.environ | single, cwd=folder, timeout=LIMIT
        )
        code, said = done.returncode, (done.stderr.strip().splitlines() or [""])[-1]
    except subprocess.TimeoutExpired:
        code, said = -1, f"stopped after {LIMIT} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, code, said


def crossings(x, edges, triangles):
    """How many pairs of an edge and a triangle that share no node intersect."""
    lowest, highest = x[triangles].min(axis=1), x[triangles].max(axis=1)
    found = 0
    for part in np.array_split(edges, max(1, len(edges) // 400)):
        a, b = x[part[:, 0]], x[part[:, 1]]
        low, high = np.minimum(a, b), np.maximum(a, b)
        near = np.all((low[:, None] <= highest) & (high[:, None] >= lowest), axis=2)
        e, t = np.nonzero(near)
        apart = np.all(part[e][:, :, None] != triangles[t][:, None, :], axis=(1, 2))
        e, t = e[apart], t[apart]
        p, q, r = (x[triangles[t, i]] for i in range(3))
        along, u, v, from_p = b[e] - a[e], q - p, r - p, a[e] - p
        # a + s along = p + j u + k v, by Cramer's rule
        normal = np.cross(along, v)
        whole = np.einsum("ij,ij->i", u, normal)
        # An edge in the plane of a triangle, as in a sheet that is still flat, does not pass through it.
        size = np.linalg.norm(along, axis=1) * np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
        through = np.abs(whole) > 1e-9 * size
        with np.errstate(all="ignore"):
            j = np.einsum("ij,ij->i", from_p, normal) / whole
            other = np.cross(from_p, u)
            k = np.einsum("ij,ij->i", along, other) / whole
            s = np.einsum("ij,ij->i", v, other) / whole
            found += int(np.sum(through & (j >= 0) & (k >= 0) & (j + k <= 1) & (s >= 0) & (s <= 1)))
    return found


def checked(x, edges, triangles, counted):
    """Whether ipctk sees crossings where `crossings` counts some; yes without it."""
    try:
        import ipctk
    except ImportError:
        return True
    return ipctk.has_intersections(ipctk.CollisionMesh(x, edges, triangles), x) == (counted > 0)


HEAD = [
    "scene",
    "program",
    "stretch or method",
    "step",
    "CPU",
    "steps",
    "nearest node",
    "crossings at the end",
    "frames with some",
    "fastest at the end",
    "energy error",
]
RUNS = {
    "canopy-fem": (
        ours,
        lambda s: [
            ("backward-euler", 4e-3 if s.cells < 30 else 2e-3),  # 4 ms take longer on the finer one
            ("energy-momentum", 2e-3),
            ("velocity-verlet", 5e-4 if s.cells < 30 else 2e-4),
        ],
    ),
    "MuJoCo": (
        mujocos,
        lambda s: [
            ("equality", 2e-3),
            ("equality", 1e-3),
            ("springs", 5e-4 if s.cells < 30 else 2e-4),
        ],
    ),
}


def row(scene, name, setting, got):
    told = [scene.name, name, setting[0], f"{1e3 * setting[1]:g} ms", f"{got.cpu:.1f} s"]
    if got.frames is None or len(got.frames) < 2:
        return [*told, got.said, *[""] * 5]
    _, triangles, edges, _ = scene.sheet()
    counted = [crossings(x, edges, triangles) for x in got.frames]
    if not checked(got.frames[-1], edges, triangles, counted[-1]):
        print(f"ipctk disagrees on the crossings of {scene.name}, {name}", file=sys.stderr)
    nearest = min(scene.distance(x) for x in got.frames)
    speed = np.max(np.linalg.norm(got.frames[-1] - got.frames[-2], axis=1)) / EVERY
    energy = "" if got.energy is None else f"{100 * got.energy:.1f} %"
    steps = f"{got.steps} {got.said}".strip()
    numbers = [f"{1e3 * nearest:+.1f} mm", str(counted[-1]), str(sum(c > 0 for c in counted)), f"{speed:.2f} m/s"]
    return [*told, steps, *numbers, energy]


def versions(program):
    told = [subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.strip()]
    for package in ("mujoco", "ipctk"):
        try:
            told.append(f"{package} {__import__(package).__version__}")
        except ImportError:
            told.append(f"{package} is not installed")
    return "; ".join(told)


def main():
    reads = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reads.add_argument("--program", required=True, help="canopy-fem")
    reads.add_argument("--out", help="a .csv or .md file for the table")
    reads.add_argument("--scene", action="append", choices=[s.name for s in SCENES])
    reads.add_argument("--only", action="append", choices=list(RUNS))
    asked = reads.parse_args()
    program = str(Path(asked.program).resolve())
    head, rows = HEAD, []
    about = f"{versions(program)}; {processor()}; {time.strftime('%Y-%m-%d')}"
    print(about)
    for scene in SCENES:
        if asked.scene and scene.name not in asked.scene:
            continue
        for name, (run, settings) in RUNS.items():
            if asked.only and name not in asked.only:
                continue
            for setting in settings(scene):
                with tempfile.TemporaryDirectory() as folder:
                    rows.append(row(scene, name, setting, run(scene, setting, program, folder)))
                print(" | ".join(rows[-1]), flush=True)
                if asked.out:
                    write(asked.out, about, head, rows)


def write(file, about, head, rows):
    with open(file, "w", newline="", encoding="utf-8") as out:
        if file.endswith(".csv"):
            csv.writer(out).writerows([head, *rows])
        else:
            out.write(f"{about}\n\n{markdown(head, rows)}\n")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--mujoco"]:
        scene_name, how, h, kept = sys.argv[2:]
        run_mujoco({s.name: s for s in SCENES}[scene_name], how, float(h), kept)
    else:
        main()
