"""SlideEnvironment: gymnasium's own checker, actions, rewards and seeds."""

import dataclasses

import numpy as np
import pytest

from slider_drilling.slide_scenarios import SCENARIOS

pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env

from slider_drilling.training.slide_environment import SlideEnvironment

HOLD = dataclasses.replace(next(scenario for scenario in SCENARIOS if scenario.name == "hold, 2.6 km"), duration=20.0)


def episode(action, seed=3):
    """Observations, rewards and the last info of a whole episode."""
    environment = SlideEnvironment(HOLD, elements=20)
    observations, rewards, over = [environment.reset(seed=seed)[0]], [], False
    while not over:
        observation, reward, ended, over, info = environment.step(np.array(action, np.float32))
        assert not ended and len(rewards) < 20
        observations.append(observation)
        rewards.append(reward)
    return np.array(observations), np.array(rewards), info


def test_gymnasium_checker_passes():
    check_env(SlideEnvironment(HOLD, elements=20), skip_render_check=True)


def test_action_turns_drive_and_lowers_block():
    observations, rewards, info = episode((1.2, 0.002))
    assert len(rewards) == 20
    assert observations[-1][1] == pytest.approx(20.0 * 1.2, rel=0.1)
    assert observations[-1][4] == pytest.approx(20.0 * 0.002, rel=0.1)
    assert observations[-1][3] > 1.0, "turning right takes torque to the right"
    drilled = rewards[-1] / (1.0 - 2.0 * abs(info["error"]) / np.pi)
    assert drilled == pytest.approx(info["truth"]["rate_of_penetration"] / 0.0025, abs=0.2)


def test_seed_fixes_episode():
    assert np.array_equal(episode((1.2, 0.0))[0], episode((1.2, 0.0))[0])
    assert not np.array_equal(episode((1.2, 0.0))[0], episode((1.2, 0.0), seed=4)[0])


def test_step_before_reset_raises():
    with pytest.raises(RuntimeError, match="reset"):
        SlideEnvironment(HOLD, elements=20).step(np.zeros(2, np.float32))
