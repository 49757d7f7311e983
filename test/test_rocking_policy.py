"""The example of docs/examples: its policy steers, trains, and runs alike as a controller and on many rigs."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gymnasium")

import slider_drilling as sd

_FOLDER = Path(__file__).parents[1] / "docs" / "examples"


def example(name):
    if str(_FOLDER) not in sys.path:
        sys.path.insert(0, str(_FOLDER))
    spec = importlib.util.spec_from_file_location(name, _FOLDER / f"{name}.py")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


policy_module, training = example("rocking_policy"), example("train_rocking_policy")


def test_controller_acts_as_on_many_rigs():
    """The same angles, whether the environment or the controller steps the policy."""
    rig = sd.load_rig()
    many = sd.vector_env(1, [rig], duration=60.0, elements=20, effects=False)
    observation, _ = many.reset(seed=3)
    controller = policy_module.TrainedRocking(rig)
    controller.tool_face_target = float(many.targets[0])
    policy = policy_module.Policy.load(policy_module.WEIGHTS)
    memory = policy_module.RockingMemory(many.rig_files, many.rig_index)
    single = sd.vector_env(1, [rig], duration=60.0, elements=20, effects=False, samples=1, actions="command")
    single.reset(seed=3)
    for _ in range(40):
        commands = memory.commands(observation[:, 0].astype(float), policy.mean_action(memory.features(observation)))
        observation = many.step(commands.astype(np.float32))[0]
        for _ in range(10):
            c = controller.step(single.measurements(0))
            single.step(np.array([[c.top_drive_angle, c.top_drive_speed, c.block_speed, c.pump_speed]]))
        assert single.measurements(0).top_drive_angle == pytest.approx(many.measurements(0).top_drive_angle, abs=1e-3)


def mean_error(policy):
    """Mean toolface error after 240 s of eight slides on fresh rigs, deg; without a policy the rocking stays fixed."""
    many = sd.vector_env(8, seed=501, elements=20, duration=480.0)
    observation, _ = many.reset(seed=501)
    memory, errors = policy_module.RockingMemory(many.rig_files, many.rig_index), []
    for _ in range(479):
        features = memory.features(observation)
        if policy is None:
            memory._pending[:] = 0.0
        actions = np.zeros((8, policy_module.ACTIONS)) if policy is None else policy.mean_action(features)
        commands = memory.commands(observation[:, 0].astype(float), actions)
        observation, _, _, _, info = many.step(commands.astype(np.float32))
        errors.append(np.abs(info["error"]))
    return np.degrees(np.mean(errors[240:]))


def test_trained_policy_beats_fixed_rocking():
    assert mean_error(policy_module.Policy.load(policy_module.WEIGHTS)) < 0.6 * mean_error(None)


def test_gradients_are_those_of_the_loss():
    policy = policy_module.Policy.random(0, width=8)
    policy.parameters = {name: value.astype(float) for name, value in policy.parameters.items()}
    random = np.random.default_rng(0)
    f, a = random.normal(size=(30, policy_module.FEATURES)), random.normal(size=(30, policy_module.ACTIONS))
    gain, returns = random.normal(size=30), random.normal(size=30)
    old = training.log_density(a, policy.mean_action(f), policy.parameters["log_std"]) + 0.1 * random.normal(size=30)

    def loss():
        ratio = np.exp(training.log_density(a, policy.mean_action(f), policy.parameters["log_std"]) - old)
        clipped = np.clip(ratio, 1.0 - training.CLIP, 1.0 + training.CLIP)
        value = policy.layers("critic", f)[-1][:, 0]
        entropy = np.sum(policy.parameters["log_std"])
        return (-np.mean(np.minimum(ratio * gain, clipped * gain)) + training.VALUE_WEIGHT
                * np.mean((value - returns) ** 2) - training.ENTROPY * entropy)  # fmt: skip

    gradient = training.gradients(policy, f, a, old, gain, returns)
    for name in ("actor_w0", "actor_b2", "critic_w1", "log_std"):
        at = tuple(0 for _ in policy.parameters[name].shape)
        before = policy.parameters[name][at]
        values = []
        for step in (1e-6, -1e-6):
            policy.parameters[name][at] = before + step
            values.append(loss())
        policy.parameters[name][at] = before
        assert gradient[name][at] == pytest.approx((values[0] - values[1]) / 2e-6, rel=1e-4, abs=1e-8)


def test_missing_weights_are_named(tmp_path):
    with pytest.raises(sd.InputError, match="no policy"):
        policy_module.TrainedRocking(sd.load_rig(), tmp_path / "none.npz")


def test_training_goes_on_counting(tmp_path):
    """The weights of the folder hold no moments of the optimiser, which starts anew; their updates count on."""
    policy, optimiser, updates = training.load(policy_module.WEIGHTS)
    assert (optimiser.steps, updates) == (0, 95)
    optimiser.steps = 32
    training.save(tmp_path / "weights.npz", policy, optimiser, updates + 1)
    _, optimiser, updates = training.load(tmp_path / "weights.npz")
    assert (optimiser.steps, updates) == (32, 96)
