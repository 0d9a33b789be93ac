"""The example environment passes the checker of gymnasium, and its episodes repeat."""

import importlib.util

import numpy as np
import pytest
from conftest import ROOT

gymnasium = pytest.importorskip("gymnasium")


@pytest.fixture(scope="module")
def env():
    spec = importlib.util.spec_from_file_location("reefing", ROOT / "examples" / "gymnasium-reefing.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Reefing(settle=0.5)


@pytest.mark.filterwarnings("error")
def test_the_environment_passes_its_checker(env):
    from gymnasium.utils.env_checker import check_env

    check_env(env, skip_render_check=True)


def test_episodes_repeat_and_the_cord_acts(env):
    """Equal seeds and actions give equal bits; a cord that is drawn in lowers the load in the gust."""

    def flown(pull):
        env.reset(seed=3)
        return np.array([env.step(np.array([pull], np.float32))[0] for _ in range(60)])

    free, again, drawn = flown(0.0), flown(0.0), flown(1.0)
    assert free.tobytes() == again.tobytes()
    assert drawn[-1, 1] == np.float32(0.5) and (drawn != free).any()
    assert env.made == 60
