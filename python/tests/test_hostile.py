"""Bad input of all kinds: it is refused with what is wrong, and neither crashes nor hangs (pyproject.toml ends a test
that hangs)."""

import copy
import random

import numpy as np
import pytest
from conftest import cloth

import canopy_fem as cf

REFUSED = (cf.CaseError, ValueError, TypeError, KeyError, OverflowError)
VALUES = [
    None, True, -1, 0, 1e308, -1e-320, 2**70, float("nan"), float("inf"), "", "x" * 5000, "\0", "\ud800", [], [[]], {},
    b"bytes",     object(), {"a": {}}, [1, 2, 3], np.zeros(3), np.array(["a"]), np.zeros((3, 3), complex),
    {1: 2}, set(), 1j, range(3),    np.datetime64("2020-01-01"), np.float32("nan"), -0.0, [None], {"": ""}, lambda: 0,
]  # fmt: skip


def places(value, at=()):
    """All paths of a nested case."""
    yield at
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from places(value[key], (*at, key))


@pytest.mark.parametrize("seed", range(20))
def test_random_cases(seed):
    """Cases with one to three wrong entries are refused with words, or run; 50 for every seed."""
    rng = random.Random(seed)
    for _ in range(50):
        case = cloth()
        for _ in range(rng.randint(1, 3)):
            at = rng.choice([place for place in places(case) if place])
            above = case
            for key in at[:-1]:
                above = above[key]
            above[at[-1]] = copy.copy(rng.choice(VALUES))
        try:
            sim = cf.Simulation(cf.Case(case))
            sim.step()
        except (*REFUSED, cf.SimulationError) as error:
            assert str(error)


def random_array(rng):
    """An array of any shape, type, order and content, mostly near what a scene of 49 nodes could take."""
    shapes = [(49, 3), (49, 3), (49, 3), (3,), (49,), (48, 3), (49, 4), (3, 49), (0,), (0, 3), (49, 3, 1), (), (2,)]
    kinds = ["f8", "f8", "f4", "f2", ">f8", "g", "i8", "u4", "i1", "?", "c16", "O", "U3", "M8[s]", "V8"]
    shape, kind = shapes[rng.integers(len(shapes))], kinds[rng.integers(len(kinds))]
    with np.errstate(all="ignore"):
        values = np.array(rng.normal(size=shape) * 10.0 ** rng.integers(-300, 300))
        if values.size and rng.integers(2):
            values.flat[rng.integers(values.size)] = [np.nan, np.inf, -np.inf, 1e308, 5e-324][rng.integers(5)]
        array = np.zeros(shape, kind) if kind[0] in "MV" else values.astype(kind)
    layouts = [
        lambda a: a, np.asfortranarray, lambda a: a[..., ::-1], lambda a: np.repeat(a, 2, axis=-1)[..., ::2],
        lambda a: np.broadcast_to(a[..., :1], a.shape), np.ma.masked_array,
        lambda a: a.view(type("Own", (np.ndarray,), {})),
    ]  # fmt: skip
    if array.ndim:
        array = layouts[rng.integers(len(layouts))](array)
    if rng.integers(2) and isinstance(array, np.ndarray):
        array.flags.writeable = False
    return array


@pytest.mark.parametrize("seed", range(10))
def test_random_arrays(seed):
    """Arrays of any kind are taken or refused with words, and a refused one leaves no trace; 100 for every seed."""
    rng = np.random.default_rng(seed)
    sim = cf.Simulation(cloth())
    for _ in range(100):
        array = random_array(rng)
        net = cf.Network([[0, 0, 0], [1, 0, 0]], mass=1)
        acts = [
            lambda a=array: sim.forces.__setitem__("f", a),
            lambda a=array: sim.forces.__setitem__("f", lambda t, x, v: a),
            lambda a=array: sim.set_state(a, a),
            lambda a=array: sim.set_wind(a),
            lambda a=array: sim.rest_scale.__setitem__(a, 0.5),
            lambda a=array: sim.read_positions(a),
            lambda a=array: cf.mesh.Mesh(a),
            lambda a=array: cf.mesh.Mesh(np.zeros((9, 3)), triangles=a),
            lambda a=array: cf.Network(np.zeros((49, 3)), mass=a),
            lambda a=array, n=net: n.springs([[0, 1]], stiffness=a),
            lambda a=array, n=net: n.springs(a, stiffness=1.0),
            lambda a=array, n=net: n.initial(velocity=a),
            lambda a=array: cf.Case(cloth(), {"system.network.gravity": a}),
        ]
        state = sim.snapshot()
        try:
            acts[rng.integers(len(acts))]()
            sim.step()
        except (*REFUSED, cf.SimulationError) as error:
            assert str(error)
        sim.forces.pop("f", None)
        sim.restore(state)


@pytest.mark.parametrize("value", VALUES, ids=lambda value: repr(value)[:20])
def test_wrong_arguments(value, sim):
    """Every argument refuses what it cannot take, with the exceptions that it should."""
    acts = [
        lambda: cf.Case(value),
        lambda: cf.Case(cloth(), value),
        lambda: cf.Case(cloth(), {"time.end": value}),
        lambda: cf.Simulation(value),
        lambda: cf.Simulation(cloth(), threads=value),
        lambda: sim.step(value),
        lambda: sim.advance(value),
        lambda: sim.run_until(value),
        lambda: sim.restore(value),
        lambda: sim.set_state(value, value),
        lambda: sim.forces.__setitem__("f", value),
        lambda: sim.forces.__setitem__(value, np.zeros((49, 3))),
        lambda: sim.set_wind(value),
        lambda: sim.rest_scale.__setitem__(value, 0.9),
        lambda: sim.rest_scale.__setitem__([0], value),
        lambda: sim.loads.__setitem__("gravity", value),
        lambda: sim.select(value),
        lambda: sim.read_positions(value),
        lambda: cf.Network(value, mass=1),
        lambda: cf.Network([[0, 0, 0], [1, 0, 0]], mass=value),
        lambda: cf.Network([[0, 0, 0], [1, 0, 0]], mass=1).springs(value, stiffness=1),
        lambda: cf.Network([[0, 0, 0], [1, 0, 0]], mass=1).springs([[0, 1]], stiffness=value),
        lambda: cf.Network([[0, 0, 0], [1, 0, 0]], mass=1).hold(value),
        lambda: cf.mesh.Mesh(value),
        lambda: cf.mesh.Mesh([[0, 0, 0], [1, 0, 0]], edges=value),
        lambda: cf.mesh.Mesh([[0, 0, 0], [1, 0, 0]], groups={"a": {"nodes": value}}),
        lambda: cf.mesh.disc(radius=value, nodes=50),
        lambda: cf.rollout(value),
        lambda: cf.rollout([cloth()], nodes=value),
        lambda: cf.rollout([cloth()], every=value),
    ]
    for act in acts:
        try:
            act()
        except (*REFUSED, cf.SimulationError, OSError) as error:
            assert str(error) or isinstance(error, KeyError)
    with pytest.raises(REFUSED):
        sim.set_state(value, value)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((48, 3)), r"\(49, 3\)"),
        (np.zeros(147), r"\(49, 3\)"),
        (np.zeros((49, 3, 1)), r"\(49, 3\)"),
        (np.broadcast_to(0.0, (10**12, 3)), r"\(49, 3\)"),
        (np.full((49, 3), np.nan), "row 0 is not finite"),
        (np.zeros((49, 3), complex), "real numbers"),
        (np.full((49, 3), "a"), "real numbers"),
        (np.full((49, 3), None), "real numbers"),
        ([[0, 0, 0], [0, 0]], "array of numbers"),
    ],
)
def test_wrong_forces(sim, array, words):
    with pytest.raises((ValueError, TypeError), match=words):
        sim.forces["f"] = array
    assert len(sim.forces) == 0


@pytest.mark.parametrize(
    "like",
    [
        lambda a: a.astype(np.float32),
        lambda a: a.astype(">f8"),
        lambda a: np.asfortranarray(a),
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[::-1][::-1],
        lambda a: a.tolist(),
        lambda a: np.lib.stride_tricks.as_strided(a, a.shape, a.strides, writeable=False),
        lambda a: np.ma.masked_array(a),
        lambda a: np.frombuffer(b"\0" + a.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(a.shape),
    ],
)
def test_arrays_of_any_layout(like, small):
    """float32, other byte orders, strides, read-only and unaligned memory give what a plain array gives."""
    force = np.zeros((49, 3))
    force[:, 0] = np.arange(49) / 64
    one, other = cf.Simulation(small), cf.Simulation(small)
    one.forces["f"] = force
    other.forces["f"] = like(force)
    one.step(5)
    other.step(5)
    assert one.positions.tobytes() == other.positions.tobytes()


def test_huge_requests_are_refused_at_once():
    for act in (
        lambda: cf.mesh.disc(radius=1.0, nodes=10**12),
        lambda: cf.mesh.chain(start=[0, 0, 0], end=[1, 0, 0], segments=2**63),
        lambda: cf.mesh.Mesh([[0, 0, 0]], triangles=[[0, 1, 2**40]]),
        lambda: cf.Case(cloth(), {"system.network.gravity": np.broadcast_to(0.0, 10**9)}),
        lambda: cf.Simulation(cloth(), threads=10**9),
    ):
        with pytest.raises(REFUSED):
            act()
