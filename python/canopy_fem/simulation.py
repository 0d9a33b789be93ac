"""A simulation that a program drives, and networks made of arrays."""

from __future__ import annotations

import html
import sys
import time
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from .case import as_case
from .errors import CaseError

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["Motion", "Network", "Simulation"]

_Array = npt.NDArray[np.float64]


class Motion(NamedTuple):
    """Where nodes are and how they move."""

    positions: _Array
    """[m] (n, 3)"""
    velocities: _Array
    """[m/s] (n, 3)"""


class Network(_core.Network):
    """Masses and springs from arrays, without JSON.

    Args:
        mesh: a `canopy_fem.mesh.Mesh`, or positions [m] of nodes, (n, 3).
        mass: [kg], one for all nodes or (n,).
        gravity: [m/s^2] (3,), or None.

    Raises:
        CaseError: a mesh that contradicts itself.
        ValueError, TypeError: arrays of another shape or type.

    A mass of 2 kg on a spring of 8 N/m, pulled 0.5 m:

    >>> net = Network([[0, 0, 0], [1.5, 0, 0]], mass=2)
    >>> net.springs([[0, 1]], stiffness=8, rest_length=1)
    >>> net.hold([0])
    >>> sim = Simulation(net, method="rk4", step=1e-3, end=10)
    >>> _ = sim.run_until(1.0)
    >>> round(float(sim.positions[1, 0]), 6)
    0.791927
    """


class Simulation(_core.Simulation):
    """A scene in motion. Arrays are copies, in the numbering of the mesh; units are SI.

    Args:
        source: a `Case`, a case file, a dictionary, or a `Network`.
        threads: threads of scenes above 2,000 nodes; results do not depend on it.
        keep_going: go on past a divergence until a value is not finite.
        free_steps: `attempt` may be given the size of each step, as couplings need; the case's own fixed step is then
            only the size of steps for which none is given, and a tolerance is not used.
        method, step, tolerance, end: of a network: a method as in a case (``"newmark"`` or
            ``{"hht": {"alpha": -0.1}}``), the fixed step [s] or the relative tolerance of adaptive steps, the end [s].

    Raises:
        CaseError: a case with faults, a network that cannot be simulated, a method that does not fit.
        TypeError, ValueError: arguments of other types, or out of range.

    A simulation may be used by one thread at a time; another one gets a SimulationError.
    """

    def __new__(
        cls,
        source: Any,
        *,
        threads: int = 1,
        keep_going: bool = False,
        free_steps: bool = False,
        method: str | Mapping[str, Mapping[str, float]] | None = None,
        step: float | None = None,
        tolerance: float | None = None,
        end: float | None = None,
    ) -> Self:
        how = {"method": method, "step": step, "tolerance": tolerance, "end": end}
        if not isinstance(source, _core.Network):
            given = [name for name, value in how.items() if value is not None]
            if given:
                raise TypeError(f"{', '.join(given)}: a case has them itself; give overrides to Case")
            core: Any = as_case(source)._core
            return super().__new__(cls, core, threads=threads, keep_going=keep_going, free_steps=free_steps)
        if method is None or end is None:
            raise TypeError("a network needs method, end, and step or tolerance")
        name, parameters = _method(method)
        settings = {"method": name, "parameters": parameters, "step": step, "tolerance": tolerance, "end": float(end)}
        return super().__new__(
            cls, source, threads=threads, keep_going=keep_going, free_steps=free_steps, settings=settings
        )

    def run(self, progress: bool | Callable[[float, float], object] = False) -> _core.Step | None:
        """Makes all steps that are left; the last one, or None if there was none left.

        Args:
            progress: True for a line on standard error, or a function of time [s] and end [s].

        Raises:
            Diverged: a step diverged or could not be solved.
        """
        tell = teller(progress)
        end, step = self.end, None
        while self.time < end * (1 - 1e-15):
            # Small enough for ten calls a second in most scenes, and without effect on the bits.
            until = min(end, self.time + (end / 200 if tell else end))
            step = self.run_until(until)
            if tell:
                tell(self.time, end)
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
    def forces(self) -> Forces:
        """Forces from outside by name: arrays [N], (n, 3), or functions ``f(t, x, v)`` that return one.

        An array acts from now on until it is set again, in every step alike. A function is called several times a step
        with the interpreter, which takes some ten microseconds a call: slow, and steps are then made one by one. It
        must return the same values for the same arguments. What it raises ends the step, and comes out of it.

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

    def __repr__(self) -> str:
        return f"<Simulation: {self.node_count} nodes, t = {self.time:g} of {self.end:g} s, step {self.step_count}>"

    def _repr_html_(self) -> str:
        energies = self.energies.as_dict().items()
        rows = "".join(f"<tr><td>{name}</td><td>{value:.6g} J</td></tr>" for name, value in energies)
        return f"<b>{html.escape(repr(self))}</b><table>{rows}</table>"


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


def teller(progress: Any) -> Callable[[float, float], object] | None:
    """The function that is told of progress."""
    if progress is False or progress is None:
        return None
    if callable(progress):
        return progress  # type: ignore[no-any-return]
    if progress is not True:
        raise TypeError("progress is True, False or a function of time and end")
    last = [0.0]

    def line(t: float, end: float) -> None:
        now = time.monotonic()
        if now - last[0] >= 0.1 or t >= end:
            last[0] = now
            print(f"\r{100 * t / end:3.0f} %  t {t:.4g} of {end:.4g} s", end="", file=sys.stderr, flush=True)
            if t >= end:
                print(file=sys.stderr)

    return line


class Forces(MutableMapping[str, Any]):
    """Forces from outside, by name; see `Simulation.forces`."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    @property
    def _known(self) -> dict[str, Any]:
        return self._sim.__dict__.setdefault("_forces", {})  # type: ignore[no-any-return]

    def __setitem__(self, name: str, force: Any) -> None:
        if not isinstance(name, str):
            raise TypeError(f"a force has a text as its name, not {name!r}")
        if callable(force):
            self.add(name, force)
        else:
            self._sim.set_force(name, force)
            self._known[name] = force

    def add(
        self, name: str, function: Callable[[float, _Array, _Array], npt.ArrayLike], *, velocity_dependent: bool = True
    ) -> None:
        """Sets a force that a function computes. One that does not depend on velocities costs velocity Verlet one call
        a step less."""
        self._sim.set_force_function(name, function, velocity_dependent=velocity_dependent)
        self._known[name] = function

    def __getitem__(self, name: str) -> Any:
        return self._known[name]

    def __delitem__(self, name: str) -> None:
        if not self._sim.remove_force(name):
            raise KeyError(name)
        self._known.pop(name, None)

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._known))

    def __len__(self) -> int:
        return len(self._known)


class RestScales:
    """Factors of rest lengths; see `Simulation.rest_scale`."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    def _edges(self, key: Any) -> Any:
        return self._sim.select(key, "edges") if isinstance(key, str) else np.atleast_1d(key)

    def __setitem__(self, key: Any, factor: float) -> None:
        """Sets the factor of a group, or of edges by number, from now on."""
        self._sim.set_rest_scale(self._edges(key), factor)

    def __getitem__(self, key: Any) -> _Array:
        """The factors of these edges, (k,)."""
        factors: _Array = self._sim.rest_scales()[self._edges(key)]
        return factors


class Loads(MutableMapping[str, float]):
    """Factors of loads; see `Simulation.loads`."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    def __setitem__(self, name: str, factor: float) -> None:
        self._sim.set_load_factor(name, factor)

    def __getitem__(self, name: str) -> float:
        return dict(self._sim.load_factors())[name]

    def __delitem__(self, name: str) -> None:
        raise TypeError("a load cannot be removed; set its factor to 0")

    def __iter__(self) -> Iterator[str]:
        return iter([name for name, _ in self._sim.load_factors()])

    def __len__(self) -> int:
        return len(self._sim.load_factors())
