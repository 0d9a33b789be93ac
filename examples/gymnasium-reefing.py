"""An environment of gymnasium: draw in the skirt of a C-9 parachute so that a gust does not overload its riser.

An episode is four seconds of a steady descent, in which a gust of random strength and time comes from below. An agent
sees the load in the riser, as a load cell would, and moves a cord around the skirt. The extra `gymnasium` of the module
installs what it needs. `python examples/gymnasium-reefing.py` checks it and flies an episode without and with a rule.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import canopy_fem as cf
import gymnasium
import numpy as np
import numpy.typing as npt

CASE = Path(__file__).resolve().parent.parent / "assets" / "cases" / "parachute" / "c9-drop.json"

Observation = npt.NDArray[np.float32]


def descent() -> cf.Case:
    """The shipped C-9 on a coarser mesh, with the air of a steady descent in place of the opening."""
    air = {"on": {"group": "canopy"}, "table": {"pressure_coefficient": 1.84}, "apparent_mass": 1.0}
    return cf.Case(
        CASE,
        {
            "name": "c9-gust",
            "system.network.mesh.parachute.reefing": None,
            "system.network.mesh.parachute.gores": 14,
            "system.network.mesh.parachute.radial_segments": 4,
            "system.network.mesh.parachute.lines": {"length": 7.21, "segments": 1},
            "system.network.aero.canopy": air,
            "system.network.initial": {"velocity": [0, 0, -6.0]},
            "time": {"end": 60.0, "method": {"hht": {"alpha": -0.2}}, "step": 0.01},
        },
    )


class Reefing(gymnasium.Env[Observation, Observation]):
    """A C-9 in a gust.

    Action: the rate of the cord [-1, 1], of which 1 draws it in at 0.5 of its length a second.
    Observation: load in the riser [kN], length of the cord over that of the skirt [-], speed of fall [m/s].
    Reward: minus the load above 1 kN [kN] and minus 0.02 of the speed above that of the descent [m/s], each step.
    """

    metadata = {"render_modes": []}

    STEP = 0.02
    """[s] between two actions"""
    STEPS = 200
    """actions of an episode"""
    SHORT, LONG = 0.5, 0.67
    """[-] the cord fully drawn in, and where it just does not pull"""

    def __init__(self, settle: float = 4.0) -> None:
        """`settle` [s] is the time before the first episode, in which the descent becomes steady."""
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
        low, high = np.array([0.0, self.SHORT, -50.0], np.float32), np.array([100.0, self.LONG, 50.0], np.float32)
        self.observation_space, self.limits = gymnasium.spaces.Box(low, high), (low, high)
        self.sim = cf.Simulation(descent())
        self.payload = self.sim.select("payload")
        self.sim.advance(settle)
        self.steady = self.sim.snapshot()
        self.speed = self._fall()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self.sim.restore(self.steady)
        self.start, self.made, self.cord = self.sim.time, 0, self.LONG
        self.strength, self.begin = self.np_random.uniform(3.0, 5.0), self.np_random.uniform(0.5, 1.5)
        return self._observed(), {"gust": float(self.strength)}

    def step(self, action: Observation) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        drawn = 0.5 * float(np.clip(action[0], -1.0, 1.0)) * self.STEP
        self.cord = float(np.clip(self.cord - drawn, self.SHORT, self.LONG))
        self.made += 1
        self.sim.set_wind([0.0, 0.0, self._gust(self.sim.time - self.start)])
        self.sim.rest_scale["skirt"] = self.cord
        lost = False
        try:
            self.sim.run_until(self.start + self.made * self.STEP)
        except cf.Diverged:
            lost = True
        seen = self._observed()
        reward = (
            -max(float(seen[0]) - 1.0, 0.0) - 0.02 * max(float(seen[2]) - self.speed, 0.0) - (100.0 if lost else 0.0)
        )
        return seen, reward, lost, self.made >= self.STEPS, {"time": self.sim.time - self.start}

    def _gust(self, t: float) -> float:
        """[m/s] from below, within a second"""
        since = t - self.begin
        return float(self.strength * np.sin(np.pi * since) ** 2) if 0.0 <= since <= 1.0 else 0.0

    def _fall(self) -> float:
        """[m/s]"""
        return float(-self.sim.velocities[self.payload, 2].mean())

    def _observed(self) -> Observation:
        load = self.sim.gauges["riser tension_max"] / 1000.0
        seen = np.array([load, self.cord, self._fall()], np.float32)
        return np.clip(seen, *self.limits)


def fly(env: Reefing, rule: bool) -> float:
    """[kN] The largest load of an episode: the cord rests, or is drawn in while the load is above 1 kN."""
    seen, _ = env.reset(seed=1)
    largest, over = float(seen[0]), False
    while not over:
        pull = (1.0 if seen[0] > 1.0 else -0.3) if rule else 0.0
        seen, _, lost, over, _ = env.step(np.array([pull], np.float32))
        largest, over = max(largest, float(seen[0])), over or lost
    return largest


if __name__ == "__main__":
    from gymnasium.utils.env_checker import check_env

    env = Reefing()
    check_env(env, skip_render_check=True)
    print(
        f"largest load: {fly(env, rule=False):.2f} kN with a cord at rest, {fly(env, rule=True):.2f} kN with the rule"
    )
