"""A simulation that a program drives, and networks made of arrays."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from .case import Case, as_case
from .controls import Forces, Loads, RestScales
from .errors import CaseError
from .logs import doubt, listen, log
from .names import Named
from .progress import teller

if TYPE_CHECKING:
    from typing_extensions import Self

    from .typed import CaseSource, DashpotKind, Law, Method, Slack

__all__ = ["Motion", "Network", "Simulation"]

_Array = npt.NDArray[np.float64]


class Motion(NamedTuple):
    """Where nodes are and how they move."""

    positions: _Array
    """[m] (n, 3)"""
    velocities: _Array
    """[m/s] (n, 3)"""

    def __repr__(self) -> str:
        return f"<Motion of {len(self.positions)} nodes>"


class Network(_core.Network):
    """Masses and springs from arrays, without JSON. Every method returns the network itself, for the next one.

    Args:
        mesh: a `canopy_fem.mesh.Mesh`, or positions [m] of nodes, (n, 3).
        mass: [kg], one for all nodes or (n,).
        gravity: [m/s^2] (3,), or None.

    Raises:
        CaseError: a mesh that contradicts itself.
        ValueError, TypeError: arrays of another shape or type.

    A mass of 2 kg on a spring of 8 N/m, pulled 0.5 m:

    >>> net = Network([[0, 0, 0], [1.5, 0, 0]], mass=2).springs([[0, 1]], stiffness=8, rest_length=1).hold([0])
    >>> sim = Simulation(net, method="rk4", step=1e-3, end=10)
    >>> _ = sim.run_until(1.0)
    >>> round(float(sim.positions[1, 0]), 6)
    0.791927
    """

    __slots__ = ("__weakref__", "_made", "_parts")

    # Arguments, and what was added since, from which a copy is made: (name, arguments, keywords).
    _made: tuple[Any, Any, Any]
    _parts: list[tuple[str, tuple[Any, ...], dict[str, Any]]]

    def __new__(
        cls, mesh: _core.Mesh | npt.ArrayLike, *, mass: npt.ArrayLike, gravity: npt.ArrayLike | None = None
    ) -> Self:
        self = super().__new__(cls, mesh, mass=mass, gravity=gravity)
        self._made, self._parts = (_kept(mesh), _kept(mass), _kept(gravity)), []
        return self

    def springs(
        self,
        pairs: npt.ArrayLike | None = None,
        *,
        stiffness: npt.ArrayLike,
        rest_length: npt.ArrayLike | None = None,
        law: Law = "linear",
        slack: Slack = "none",
        dashpot: npt.ArrayLike | None = None,
        dashpot_kind: DashpotKind = "axial",
    ) -> Self:
        """Adds springs.

        Args:
            pairs: nodes, (m, 2); all edges of the mesh if left out. Pairs that are no edges yet become edges, after
                those of the mesh.
            stiffness: [N/m], one for all or (m,).
            rest_length: [m] likewise; the distances as given if left out.
            law: "linear", or "green" (finite strain).
            slack: "none", "tension-only" or "compression-only".
            dashpot: [N s/m] likewise; none if left out.
            dashpot_kind: "axial" or "relative".

        Raises:
            ValueError, TypeError: arrays of another shape or type, nodes that do not exist.
        """
        more = {"stiffness": stiffness, "rest_length": rest_length, "law": law, "slack": slack}
        more |= {"dashpot": dashpot, "dashpot_kind": dashpot_kind}
        return self._add("springs", (pairs,), more)

    def hold(self, nodes: npt.ArrayLike, directions: str = "xyz") -> Self:
        """Holds nodes, (k,), in x, y and z, or in those directions that are named.

        Raises:
            ValueError, TypeError: nodes that do not exist, other directions.
        """
        return self._add("hold", (nodes, directions), {})

    def force(self, nodes: npt.ArrayLike, force: npt.ArrayLike) -> Self:
        """Adds a constant force [N], (3,), on each of these nodes, (k,).

        Raises:
            ValueError, TypeError: nodes that do not exist, another shape or type.
        """
        return self._add("force", (nodes, force), {})

    def initial(self, *, displacement: npt.ArrayLike | None = None, velocity: npt.ArrayLike | None = None) -> Self:
        """Starts displaced [m] and moving [m/s]: each (n, 3) or left out.

        Raises:
            ValueError, TypeError: another shape or type.
        """
        return self._add("initial", (), {"displacement": displacement, "velocity": velocity})

    def _add(self, name: str, arguments: tuple[Any, ...], more: dict[str, Any]) -> Self:
        getattr(super(), name)(*arguments, **more)
        kept = {key: _kept(value) for key, value in more.items()}
        self._parts.append((name, tuple(map(_kept, arguments)), kept))
        return self

    def _recipe(self) -> tuple[Any, Any]:
        return self._made, list(self._parts)

    def __repr__(self) -> str:
        mesh, added = self._made[0], ", ".join(name for name, _, _ in self._parts)
        nodes = len(mesh.nodes if isinstance(mesh, _core.Mesh) else mesh)
        return f"<Network: {nodes} nodes; {added or 'nothing added'}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _network, (type(self), *self._recipe()), getattr(self, "__dict__", None)


def _kept(value: Any) -> Any:
    """A value that no one changes later."""
    return value if value is None or isinstance(value, (str, _core.Mesh)) else np.array(value)


def _network(kind: type[Network], made: Any, parts: Any) -> Network:
    """The network of a recipe."""
    mesh, mass, gravity = made
    network = Network.__new__(kind, mesh, mass=mass, gravity=gravity)
    for name, arguments, more in parts:
        Network._add(network, name, arguments, more)
    return network


class Simulation(_core.Simulation):
    """A scene in motion. Arrays are copies, read-only, in the numbering of the mesh; units are SI.

    Args:
        source: a `Case`, a case file, a dictionary, or a `Network`.
        threads: threads of scenes above 2,000 nodes; results do not depend on it.
        keep_going: go on past a divergence until a value is not finite.
        free_steps: `attempt` may be given the size of each step, as couplings need; the case's own fixed step is then
            only the size of steps for which none is given, and a tolerance is not used.
        sensitivity: keys of the case, as for ``cf.gradient``: the simulation goes along with the exact derivatives of
            its state by these numbers, which `sensitivity` then has by key. It makes steps of one size and takes no
            changes on the way; each number costs about four force passes and a solve a step. Copies and restored
            simulations go without.
        method, step, tolerance, end: of a network: a method as in a case (``"newmark"`` or
            ``{"hht": {"alpha": -0.1}}``), the fixed step [s] or the relative tolerance of adaptive steps, the end [s].

    Raises:
        CaseError: a case with faults, a network that cannot be simulated, a method that does not fit.
        TypeError, ValueError: arguments of other types, or out of range.

    A simulation may be used by one thread at a time; another one gets a SimulationError. It can be copied and pickled,
    with its state and forces: a copy goes on with the same bits.
    """

    __slots__ = ("__weakref__", "_how", "_source")

    # What it was made of, and by which keywords: for copies.
    _source: tuple[Any, ...]
    _how: dict[str, Any]

    def __new__(
        cls,
        source: Case | CaseSource | _core.Network,
        *,
        threads: int = 1,
        keep_going: bool = False,
        free_steps: bool = False,
        sensitivity: str | Sequence[str] = (),
        method: Method | Mapping[str, Mapping[str, float]] | None = None,
        step: float | None = None,
        tolerance: float | None = None,
        end: float | None = None,
    ) -> Self:
        listen()
        how: dict[str, Any] = {"method": method, "step": step, "tolerance": tolerance, "end": end}
        common: dict[str, Any] = {"threads": threads, "keep_going": keep_going, "free_steps": free_steps}
        if not isinstance(source, _core.Network):
            given = [name for name, value in how.items() if value is not None]
            if given:
                raise TypeError(f"{', '.join(given)}: a case has them itself; give overrides to Case")
            case = as_case(source)
            self = super().__new__(cls, case._core, **common)
            self._source, self._how = case.__reduce__(), common
            keys = [sensitivity] if isinstance(sensitivity, str) else list(sensitivity)
            if keys:
                self._follow(case._core, keys, threads)
            return self
        if sensitivity:
            raise TypeError("sensitivity: a network has no keys; make it of a case")
        if method is None or end is None:
            raise TypeError("a network needs method, end, and step or tolerance")
        name, parameters = _method(method)
        settings = {"method": name, "parameters": parameters, "step": step, "tolerance": tolerance, "end": float(end)}
        self = super().__new__(cls, source, **common, settings=settings)
        recipe = source._recipe() if isinstance(source, Network) else None
        self._source, self._how = (_network, (Network, *recipe)) if recipe else (), common | how
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        state = {
            "functions": self.force_laws(),
            "state": self.snapshot(),
            "more": getattr(self, "__dict__", None),
        }
        return _simulation, (type(self), self._source, self._how), state

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Before the state, since the first function would begin it anew.
        for name, (function, velocity_dependent) in state["functions"].items():
            self.set_force_law(name, function, velocity_dependent=velocity_dependent)
        self._restore_later(state["state"])
        if state["more"]:
            self.__dict__.update(state["more"])

    def __setattr__(self, name: str, value: Any) -> None:
        try:
            super().__setattr__(name, value)
        except AttributeError:
            advice = _INSTEAD.get(name, "attributes are read; methods change the simulation")
            raise AttributeError(f"{name!r} of a simulation cannot be set: {advice}") from None

    def restore(self, state: bytes) -> list[str]:
        """Goes on from the bytes of a snapshot, with the bits of a run that was never stopped.

        The scene or run may be another one of the same nodes and connections: with other masses or stiffnesses, another
        method or step, as in fits. A `CaseWarning` then says what differs, and so do the phrases that are returned; the
        scheme, its steps and the energy account begin anew at that state. Forces that are functions stay; arrays,
        factors and wind become those of the snapshot.

        Raises:
            ValueError: damaged bytes, those of other nodes or connections, of another version, or of a time that the
                run does not reach.
        """
        differs = super().restore(state)
        if differs:
            text = f"the snapshot is of another scene or run, so the scheme begins anew: {'; '.join(differs)}"
            doubt(text, stacklevel=2)
        return differs

    def run(self, progress: bool | Callable[[float, float], object] = False) -> _core.Step | None:
        """Makes all steps that are left; the last one, or None if there was none left.

        Args:
            progress: True for a line on standard error, in a notebook a bar; or a function of time [s] and end [s].

        Raises:
            Diverged: a step diverged or could not be solved.
        """
        tell = told_time(progress)
        end, step = self.end, None
        listen()
        log.info("run from t = %g s to %g s begins", self.time, end)
        while self.time < end * (1 - 1e-15):
            # Small enough for ten calls a second in most scenes, and without effect on the bits.
            until = min(end, self.time + (end / 200 if tell else end))
            step = self.run_until(until)
            if tell:
                tell(self.time, end)
        log.info("run ended at t = %g s after %d steps", self.time, self.step_count)
        return step

    def attempt(self, step: float | None = None) -> Motion:
        """Computes the next step without accepting it, and shows its end. `accept` or `drop` must follow.

        For implicit coupling, where the forces of a step depend on its end.

        Args:
            step: [s] its size, which a simulation with `free_steps` takes; cut where an event of the scene lies within
                it, such as a support that lets go. The end of the case does not limit it.

        Raises:
            Diverged, Ended, SimulationError: as `step`, and when an attempted step still waits.
            ValueError: a step of 0 or less, or not finite.
        """
        return Motion(*super().attempt(step))

    @property
    def gauges(self) -> dict[str, float]:
        """What the gauges of the case and its canopies show now, by ``"name quantity"``, each in its SI unit: of the
        forces that act now, with what was set since the last step."""
        return Named("gauge", super().gauges)

    @property
    def gauge_units(self) -> dict[str, str]:
        """Units of the gauges, by ``"name quantity"``."""
        return Named("gauge", super().gauge_units)

    @property
    def peaks(self) -> dict[str, float]:
        """Peaks of the gauges over all steps so far, by ``"name quantity"``, as `Result.peaks` has them; of components
        those of the largest magnitude. `set_state` begins them anew, and `restore` takes up those of the snapshot."""
        return Named("gauge", super().peaks)

    @property
    def forces(self) -> Forces:
        """Forces from outside by name: arrays [N], (n, 3), or functions ``f(t, x, v)`` that return one.

        It shows what acts, after `restore` too. Arrays in it are read-only: ``sim.forces["wake"][3] = …`` raises.

        An array acts from now on until it is set again, in every step alike. A function is called several times a step
        with the interpreter, which takes some ten microseconds a call: slow, and steps are then made one by one. It
        must return the same values for the same arguments, which are read-only. What it raises ends the step, and
        comes out of it.

        >>> sim.forces["wake"] = f                    # doctest: +SKIP
        >>> sim.forces["thrust"] = lambda t, x, v: f  # doctest: +SKIP
        >>> del sim.forces["wake"]                    # doctest: +SKIP
        """
        return Forces(self)

    @property
    def rest_scale(self) -> RestScales:
        """Factors [-] of rest lengths, by group or by numbers of edges: below 1 to reef a line, above 1 to let it out.

        >>> sim.rest_scale["reefing"] = 0.3           # doctest: +SKIP
        """
        return RestScales(self)

    @property
    def loads(self) -> Loads:
        """Factors [-] of loads: ``"gravity"``, ``"pressure 0"``, ``"force 0"``, … in the order of the case."""
        return Loads(self)

    def to_pyvista(self, into: Any = None) -> Any:
        """The scene as it is now, as a pyvista.PolyData with velocities [m/s] of its nodes.

        Args:
            into: a mesh of an earlier call, which shows the present state from then on, also where a plotter has it.

        Raises:
            ImportError: pyvista is not installed.
        """
        from .mesh import to_pyvista

        if into is None:
            into = to_pyvista(_core.Mesh(self.reference, edges=self.edges, triangles=self.triangles))
        into.points = self.positions.copy()
        into.point_data["velocity"] = self.velocities
        return into

    def __repr__(self) -> str:
        return f"<Simulation: {self.node_count} nodes, t = {self.time:g} of {self.end:g} s, step {self.step_count}>"

    def _repr_html_(self) -> str:
        energies = self.energies.as_dict().items()
        rows = "".join(f"<tr><td>{name}</td><td>{value:.6g} J</td></tr>" for name, value in energies)
        return f"<b>{html.escape(repr(self))}</b><table>{rows}</table>"


_INSTEAD = {
    "wind": "use set_wind",
    "positions": "use set_state",
    "velocities": "use set_state",
    "time": "use set_state(positions, velocities, time=…)",
    "forces": "use forces[name] = …",
    "loads": "use loads[name] = …",
    "rest_scale": "use rest_scale[group] = …",
    "threads": "give it to Simulation",
}


def _simulation(kind: type[Simulation], source: tuple[Any, ...], how: dict[str, Any]) -> Simulation:
    """The simulation of a recipe, at its start."""
    if not source:
        raise TypeError("this simulation cannot be copied: its network is none of canopy_fem.Network")
    make, arguments = source[:2]
    return Simulation.__new__(kind, make(*arguments), **how)


def _method(method: Any) -> tuple[str, dict[str, float]]:
    if isinstance(method, str):
        return method, {}
    if isinstance(method, Mapping) and len(method) == 1:
        ((name, parameters),) = method.items()
        if isinstance(name, str) and isinstance(parameters, Mapping):
            try:
                return name, {str(key): float(value) for key, value in parameters.items()}
            except (TypeError, ValueError) as error:
                raise CaseError(f"method {name}: parameters are numbers: {error}") from None
    raise TypeError('a method is its name, or {"name": {"parameter": value}}')


def told_time(progress: Any) -> Callable[[float, float], object] | None:
    """The function that is told of the time [s] that a run has come to, and of its end."""
    return teller(progress, lambda t, end: f"t {t:.4g} of {end:.4g} s", "time and end")
