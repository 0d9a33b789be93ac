"""What a program sets in a simulation, by names: forces, factors of rest lengths and of loads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .names import Named, unknown

if TYPE_CHECKING:
    from .simulation import Simulation
    from .typed import Force

__all__ = ["Forces", "Loads", "RestScales"]

_Array = npt.NDArray[np.float64]


class Forces(MutableMapping[str, Any]):
    """Forces from outside that act, by name; see `Simulation.forces`."""

    __slots__ = ("_sim",)

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    def __setitem__(self, name: str, force: Force) -> None:
        if not isinstance(name, str):
            raise TypeError(f"a force has a text as its name, not {name!r}")
        if callable(force):
            self.add(name, force)
        else:
            self._sim.set_force(name, force)

    def add(
        self, name: str, function: Callable[[float, _Array, _Array], npt.ArrayLike], *, velocity_dependent: bool = True
    ) -> None:
        """Sets a force that a function computes. One that does not depend on velocities costs velocity Verlet one call
        a step less."""
        self._sim.set_force_law(name, function, velocity_dependent=velocity_dependent)

    def __getitem__(self, name: str) -> Any:
        return Named("force", self._sim.acting_forces())[name]

    def __delitem__(self, name: str) -> None:
        if not self._sim.remove_force(name):
            raise unknown("force", name, self)

    def __iter__(self) -> Iterator[str]:
        return iter(self._sim.acting_forces())

    def __len__(self) -> int:
        return len(self._sim.acting_forces())

    def __repr__(self) -> str:
        acting = self._sim.acting_forces().items()
        named = [f"{name!r}: {'a function' if callable(force) else f'array {force.shape}'}" for name, force in acting]
        return f"Forces({{{', '.join(named)}}})"


class RestScales:
    """Factors of rest lengths; see `Simulation.rest_scale`."""

    __slots__ = ("_sim",)

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    # Without it, Python would go through numbers of edges.
    __iter__ = None

    def _edges(self, key: Any) -> Any:
        return self._sim.select(key, "edges") if isinstance(key, str) else np.atleast_1d(key)

    def __setitem__(self, key: Any, factor: float) -> None:
        """Sets the factor of a group, or of edges by number, from now on."""
        self._sim.set_rest_scale(self._edges(key), factor)

    def __getitem__(self, key: Any) -> _Array:
        """The factors of these edges, (k,), NaN where there is no spring; read-only."""
        factors: _Array = self._sim.rest_scales()[self._edges(key)]
        factors.flags.writeable = False
        return factors

    def __repr__(self) -> str:
        factors = self._sim.rest_scales()
        changed = np.flatnonzero(np.isfinite(factors) & (factors != 1.0))
        return f"RestScales({ {int(edge): float(factors[edge]) for edge in changed} })"


class Loads(MutableMapping[str, float]):
    """Factors of loads; see `Simulation.loads`."""

    __slots__ = ("_sim",)

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    def __setitem__(self, name: str, factor: float) -> None:
        self._sim.set_load_factor(name, factor)

    def __getitem__(self, name: str) -> float:
        return Named("load", dict(self._sim.load_factors()))[name]

    def __delitem__(self, name: str) -> None:
        raise TypeError("a load cannot be removed; set its factor to 0")

    def __iter__(self) -> Iterator[str]:
        return iter([name for name, _ in self._sim.load_factors()])

    def __len__(self) -> int:
        return len(self._sim.load_factors())

    def __repr__(self) -> str:
        return f"Loads({dict(self)!r})"
