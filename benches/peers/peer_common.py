"""What the Python peers share: the scene file, its forces in numpy, and the line protocol of README.md."""

import sys
import time
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Scene:
    end: float = 0.0
    every: float = 0.0
    x0: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    mass: np.ndarray = field(default_factory=lambda: np.zeros(0))
    fixed: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    ends: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), int))
    k: np.ndarray = field(default_factory=lambda: np.zeros(0))
    rest: np.ndarray = field(default_factory=lambda: np.zeros(0))
    c: np.ndarray = field(default_factory=lambda: np.zeros(0))
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    load: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))  # [N] constant forces beside the weight
    membranes: np.ndarray = field(
        default_factory=lambda: np.zeros((0, 7))
    )  # corners, thickness, E, nu, whether it wrinkles
    air: np.ndarray | None = None  # linear, quadratic, wind
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), int))

    @property
    def frames(self):
        return round(self.end / self.every)

    @property
    def damped(self):
        return self.air is not None or bool(np.any(self.c))

    @property
    def constant(self):
        """[N] Weight and load of every node."""
        return self.mass[:, None] * self.gravity + self.load


def read_scene(file):
    """Reads what `peer_canopy_fem export` writes."""
    scene, rows = Scene(), iter(open(file, encoding="ascii"))

    def table(n, columns):
        return np.array([next(rows).split() for _ in range(int(n))], dtype=float).reshape(-1, columns)

    for row in rows:
        word, *rest = row.split()
        if word == "time":
            scene.end, scene.every = map(float, rest)
        elif word == "nodes":
            t = table(rest[0], 5)
            scene.x0, scene.mass, scene.fixed = t[:, :3].copy(), t[:, 3].copy(), t[:, 4] != 0
            scene.load = np.zeros_like(scene.x0)
        elif word == "springs":
            t = table(rest[0], 5)
            scene.ends = t[:, :2].astype(int)
            scene.k, scene.rest, scene.c = (t[:, i].copy() for i in (2, 3, 4))
        elif word == "gravity":
            scene.gravity = np.array(rest, float)
        elif word == "air":
            scene.air = np.array(rest, float)
        elif word == "triangles":
            scene.triangles = table(rest[0], 3).astype(int)
        elif word == "membranes":
            scene.membranes = table(rest[0], 7)
        elif word == "forces":
            t = table(rest[0], 4)
            np.add.at(scene.load, t[:, 0].astype(int), t[:, 1:])
    return scene


class Accelerations:
    """f(x, v)/m of a scene, vectorised; `gather` sums elements' forces at the nodes."""

    def __init__(self, scene, gather):
        if len(scene.membranes):
            raise ValueError("there are no membranes here")
        self.scene = scene
        self.a, self.b = scene.ends[:, 0].copy(), scene.ends[:, 1].copy()
        self.at_springs = gather(scene.ends, [1.0, -1.0], len(scene.x0))
        if scene.air is not None:
            self.at_triangles = gather(scene.triangles, [1.0, 1.0, 1.0], len(scene.x0))
        self.inverse = np.where(scene.fixed, 0.0, 1.0 / scene.mass)[:, None]
        self.weight = self.inverse * scene.constant
        self.passes = 0

    def __call__(self, x, v):
        scene = self.scene
        self.passes += 1
        d = x[self.b] - x[self.a]
        length = np.sqrt(np.einsum("ij,ij->i", d, d))
        pull = (scene.k * (1.0 - scene.rest / length))[:, None] * d
        if not scene.damped:
            return self.weight + self.inverse * self.at_springs(pull)
        pull += scene.c[:, None] * (v[self.b] - v[self.a])
        f = self.at_springs(pull)
        if scene.air is not None:
            f += self.at_triangles(self.wind(x, v))
        return self.weight + self.inverse * f

    def wind(self, x, v):
        """dp A N / 3 of every triangle."""
        p, q, r = (x[self.scene.triangles[:, i]] for i in range(3))
        area = 0.5 * np.cross(q - p, r - p)
        size = np.sqrt(np.einsum("ij,ij->i", area, area))
        u = self.scene.air[2:] - v[self.scene.triangles].mean(axis=1)
        through = np.einsum("ij,ij->i", area, u) / size
        linear, quadratic = self.scene.air[:2]
        return ((linear + quadratic * np.abs(through)) * through / 3.0)[:, None] * area


def steps_a_frame(scene, step):
    """Steps between two frames; a step that does not divide their distance is refused, so that nobody interpolates."""
    n = round(scene.every / step)
    if n < 1 or abs(scene.every / step - n) > 1e-6 * n:
        raise ValueError("the step does not divide the frames' distance")
    return n


class Diverged(Exception):
    """A run left the physics or could not be solved."""


def serve(version, run):
    """Answers each line `METHOD step|tol VALUE FILE` with `done|diverged|refused SECONDS NOTE`.

    `run(scene, method, kind, value)` returns a note and the positions at every frame after the start; it may return
    seconds as a third, where setting up its model is not part of the integration.
    """
    scene, out = read_scene(sys.argv[1]), sys.stdout
    print("ready", version, file=out, flush=True)
    for line in sys.stdin:
        method, kind, value, file = line.split()
        before = time.process_time()
        try:
            note, frames, *seconds = run(scene, method, kind, float(value))
            spent = seconds[0] if seconds else time.process_time() - before
            frames = np.asarray(frames, dtype="<f8")
            whole = frames.shape == (scene.frames, *scene.x0.shape) and np.all(np.abs(frames) < 1e4)
            frames.tofile(file)
            print("done" if whole else "diverged", spent, note, file=out, flush=True)
        except Diverged as why:
            print("diverged", time.process_time() - before, why, file=out, flush=True)
        except Exception as why:  # the table shows it; the others go on
            print("refused 0", type(why).__name__, str(why).replace("\n", " "), file=out, flush=True)
