"""Which scenes are run, which programs, and which of their methods with which steps and tolerances.

A new peer is a program that speaks the line protocol of README.md and an entry in PEERS.
"""

import json
from dataclasses import dataclass, field

from setup import HERE, OURS, PROGRAM, PYTHON, TARGET, UNSERVED

FRAME = 0.02  # [s] between the frames that are compared


@dataclass
class SceneSpec:
    name: str
    case: str
    told: str
    stiff: float  # how many times shorter the explicit steps are than at K = 1e3
    overrides: list = field(default_factory=list)
    has: set = field(default_factory=lambda: {"springs", "compression"})  # what a program must know to run it
    targets: list = field(default_factory=lambda: [1e-2, 1e-4, 1e-6])  # errors whose times are compared
    asked: bool = False  # run only if --scene names it


STILL = ["system.network.aero=null", "system.network.springs.0.dashpot=null"]
TIME = ["time.end=0.2", f"output.frames.every={FRAME}"]
NET = "703 nodes, 1983 springs"
STIFFEST = "system.network.springs.0.stiffness=1e7"


def sheet(wrinkles):
    """Overrides that put the membrane that the net stands for in its place: E t = 2 k/sqrt(3) and nu = 1/3."""
    rule = {"on": "all", "thickness": 1e-4, "modulus": 2e7 / 3**0.5, "poisson": 1 / 3, "wrinkling": wrinkles}
    return ["system.network.aero=null", "system.network.springs=[]", f"system.network.membranes={json.dumps([rule])}"]


DAMPED = {"springs", "compression", "relative dashpots"}


def damped(stiffness, stiff, target):
    """The cloth with its dashpots (c = tau k) under its weight and a dead pressure, that of the air at 50 m/s."""
    load = {"on": "all", "pressure": 73.7, "kind": "dead", "direction": [0, 0, 1]}
    told = f"{NET} of {stiffness:.0e} N/m with relative dashpots under weight and dead pressure"
    overrides = ["system.network.aero=null", f"system.network.loads={json.dumps([load])}", *TIME]
    case = f"cloth-k{stiffness:.0f}.json"
    return SceneSpec(f"damped-k{stiffness:.0f}", case, told, stiff, overrides, DAMPED, [target, 1e-4, 1e-6])


SHEETS = {"membranes", "wrinkling"}
SHEET = "703 nodes, 1280 membrane triangles of E t = 1155 N/m"
# Eight nodes of the outer edge: the sheet between them wrinkles and goes slack.
HUNG = ['system.network.supports=[{"on": {"ids": [11, 25, 39, 54, 68, 83, 97, 111]}, "fix": "xyz"}]']
LINE = [
    'system.network.mesh={"chain": {"from": [0, 0, 0], "to": [10, 0, 0], "segments": 100}}',
    'system.network.mass={"nodal": 0.03}',
    'system.network.springs=[{"on": "all", "stiffness": 1e4}]',
    'system.network.supports=[{"on": {"ids": [0, 100]}, "fix": "xyz"}]',
    "system.network.aero=null",
    "output.probes=[]",
    *TIME,
]
SCENES = [
    SceneSpec("cloth-k1000", "cloth-k1000.json", f"{NET} of 1e3 N/m fall under gravity, undamped", 1, STILL + TIME),
    SceneSpec(
        "cloth-k100000", "cloth-k100000.json", f"{NET} of 1e5 N/m fall under gravity, undamped", 10, STILL + TIME
    ),
    SceneSpec(
        "cloth-k10000000",
        "cloth-k100000.json",
        f"{NET} of 1e7 N/m fall under gravity",
        100,
        [*STILL, *TIME, STIFFEST],
        asked=True,
    ),
    SceneSpec(
        "cloth-k1000-air",
        "cloth-k1000.json",
        f"{NET} of 1e3 N/m with relative dashpots in a wind of 50 m/s",
        1,
        TIME,
        {"springs", "compression", "relative dashpots", "air"},
    ),
    damped(1e3, 1, 1.5e-3),
    damped(1e4, 10**0.5, 5e-4),
    damped(1e5, 10, 7e-5),
    SceneSpec(
        "line",
        "cloth-k1000.json",
        "a line of 100 springs of 1e4 N/m between two supports, straight at the start",
        1,
        LINE,
        {"springs"},
    ),
    SceneSpec(
        "membrane",
        "cloth-k1000.json",
        f"{SHEET} fall under gravity, undamped",
        1,
        sheet(False) + TIME,
        SHEETS - {"wrinkling"},
    ),
    SceneSpec(
        "membrane-wrinkling",
        "cloth-k1000.json",
        f"{SHEET} that wrinkle, hung at eight points",
        1,
        sheet(True) + HUNG + TIME,
        SHEETS,
    ),
]


@dataclass
class Peer:
    name: str
    command: list
    needs: list  # names in missing.json without which it cannot run
    runs: object  # scene -> [(method, kind, values)]
    knows: set = field(default_factory=lambda: {"springs", "compression"})
    environment: dict = field(default_factory=dict)


def steps(scene, *fractions):
    """Explicit steps: FRAME over a whole number, that number times what the scene's stiffness asks for."""
    return ["step", [FRAME / round(n * scene.stiff) for n in fractions]]


IMPLICIT = [2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4]
VERLET = (8, 10, 12, 16, 20, 32, 40, 80, 160)
RK4 = (6, 8, 10, 14, 20, 40)


def ours(s):
    tight = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8]
    runs = [
        ("velocity-verlet", *steps(s, *VERLET)),
        ("beeman", *steps(s, 10, 11, 12, 14, 16, 20, 32, 40, 80)),
        ("rk4", *steps(s, *RK4)),
        ("dormand-prince", *steps(s, 16, 20, 32)),
        ("dop853", *steps(s, 4, 6, 8)),
        ("dop853", "tol", tight),
        ("dormand-prince", "tol", tight),
        ("newmark", "step", [*IMPLICIT, 2e-4, 1e-4]),
        ("newmark", "tol", [1e-1, 1e-2, 1e-3, 1e-4]),
        ("newmark-full", "step", IMPLICIT),
        ("esdirk4", "step", IMPLICIT),
        ("esdirk4", "tol", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]),
    ]
    if "relative dashpots" in s.has:
        runs.append(("euler-cromer", *steps(s, *VERLET)))
    if s.has <= {"springs", "compression"}:
        runs.append(("kang", *steps(s, 20, 80)))
    return runs


def plain_cpp(s):
    return [("leapfrog", *steps(s, *VERLET)), ("verlet", *steps(s, *VERLET)), ("rk4", *steps(s, *RK4))]


def sundials(s):
    loose = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
    # The preconditioner knows springs and dashpots.
    preconditioned = [
        ("bdf-cholesky", "tol", [1e-1, 3e-2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]),
        ("esdirk4", "step", IMPLICIT),
        ("esdirk4", "tol", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]),
    ]
    if s.stiff > 10:  # what is left out takes from a quarter of a minute to several
        return [("erk5", "tol", [1e-3, 1e-4, 1e-6]), ("bdf-cholesky", "tol", [1e-1, 3e-2, 1e-2, 1e-3])]
    return [
        ("erk5", "tol", [*loose, 1e-8]),
        ("erk8", "tol", loose[::2]),
        ("bdf", "tol", loose if s.stiff < 4 else loose[1:4]),
        *([] if SHEETS & s.has else preconditioned),
    ]


def scipy(s):
    if s.stiff > 10:  # minutes
        return []
    return [("DOP853", "tol", [1e-2, 1e-4, 1e-6]), ("RK45", "tol", [1e-3, 1e-4, 1e-6])]


def numpy_loop(s):
    # Its steps shrink with the stiffness, not its root: undamped oscillations grow by (w h)^2/2 a step.
    euler = [("explicit-euler", *steps(s, 100, 200, 400))] if s.stiff == 1 else []
    return [*euler, ("velocity-verlet", *steps(s, 16, 20, 40, 80, 160))]


def opensees(s):
    explicit = [("central-difference", *steps(s, 12, 16, 20, 40, 80, 160))]
    return [("newmark", "step", IMPLICIT)] + (explicit if s.stiff <= 10 else [])


def kratos(s):
    explicit = [("central-difference", *steps(s, 12, 16, 20, 40, 80))]
    return [("newmark-cg", "step", IMPLICIT), ("newmark-lu", "step", IMPLICIT[:3])] + (
        explicit if s.stiff <= 10 else []
    )


def mujoco(s):
    return [("euler", *steps(s, *VERLET)), ("rk4", *steps(s, *RK4))]


def newton(s):
    return [("semi-implicit", *steps(s, *VERLET))] if s.stiff <= 10 else []


def rapier_cloth(s):
    # All of order 1. Two sweeps a step are a little cheaper at first, more are not.
    return [
        ("xpbd", *steps(s, 10, 20, 50, 100, 200, 500, 1000, 2000)),
        ("xpbd-2", *steps(s, 10, 20, 30, 50)),
        ("backward-euler", "step", IMPLICIT),
    ]


def moordyn(s):
    return [("rk2", *steps(s, 20, 40, 80, 160, 320)), ("rk4", *steps(s, *RK4))]


KRATOS = ["KratosMultiphysics"] + [
    f"Kratos{part}Application" for part in ("LinearSolvers", "ConstitutiveLaws", "StructuralMechanics")
]


def python(script):
    return [str(PYTHON), str(HERE / script)]


def opensees_libraries():
    """The wheel brings libraries along that it does not find by itself."""
    found = sorted(PYTHON.parent.parent.glob("lib/python*/site-packages/openseespy*/lib"))
    return {"LD_LIBRARY_PATH": ":".join(map(str, found))}


NETS = DAMPED | {"air"}
ALL = NETS | SHEETS
PEERS = [
    Peer("canopy-fem", [str(TARGET / OURS), "serve"], [OURS], ours, ALL),
    Peer("cpp", [str(TARGET / "plain_cpp")], ["plain_cpp"], plain_cpp, ALL),
    Peer(
        "eigen",
        [str(TARGET / "plain_eigen")],
        ["plain_eigen"],
        lambda s: [("newmark", "step", [*IMPLICIT, 2e-4])],
        DAMPED,
    ),
    Peer("sundials", [str(TARGET / "plain_sundials")], ["plain_sundials"], sundials, ALL),
    Peer("scipy", python("peer_scipy.py"), ["scipy"], scipy, NETS),
    Peer("numpy", python("peer_numpy.py"), ["numpy"], numpy_loop, NETS),
    Peer("opensees", python("peer_opensees.py"), ["openseespy"], opensees, environment=opensees_libraries()),
    Peer("kratos", python("peer_kratos.py"), KRATOS, kratos, {"springs", "compression", "membranes"}),
    Peer("mujoco", python("peer_mujoco.py"), ["mujoco"], mujoco, {"springs", "compression", "membranes"}),
    Peer("newton", python("peer_newton.py"), ["newton"], newton),
    Peer("moordyn", python("peer_moordyn.py"), ["moordyn"], moordyn, {"springs"}),
    Peer("rapier-cloth", [str(TARGET / "rapier_cloth")], ["rapier_cloth"], rapier_cloth),
    *(Peer(name, [], [name], lambda s: []) for name in UNSERVED),
]


def whole_command(peer, scene, run, folder):
    """The command of a process that makes one run, and what it reads from standard input."""
    if peer.name != "canopy-fem":
        return [
            *peer.command,
            str(TARGET / f"{scene.name}.txt"),
        ], f"{run.method} {run.kind} {run.value!r} {folder}/frames.bin\n"
    method, full = run.method.removesuffix("-full"), ["solver.newton.strategy=full"] * run.method.endswith("-full")
    setting = ["--step" if run.kind == "step" else "--tolerance", repr(run.value)]
    sets = [word for pair in [*scene.overrides, *full] for word in ("--set", pair)]
    solve = [str(TARGET / PROGRAM), "solve", name_of_case(scene), *sets, "--method", method, *setting]
    return [*solve, "--out", f"{folder}/results", "--force", "--quiet"], ""


def name_of_case(scene):
    return str(HERE.parent.parent / "assets" / "cases" / scene.case)
