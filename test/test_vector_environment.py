"""Many rigs at once: equal to the rigs one by one, gymnasium's rules, seeds, and bad arguments."""

import numpy as np
import pytest

pytest.importorskip("gymnasium")

import gymnasium
from gymnasium.utils.env_checker import check_env

import slider_drilling as sd
from slider_drilling.blind.foreign.plant import ForeignPlant, slow_changes
from slider_drilling.control import FixedRocking
from slider_drilling.control.interface import RigCommand
from slider_drilling.drillstring import Commands, InitialState, Modifiers
from slider_drilling.drillstring.drives import DriveState, follow_command
from slider_drilling.drillstring.kernel_arrays import CHANNELS
from slider_drilling.slide_scenarios import run_scenario
from slider_drilling.slide_scenarios.campaign import noise_seed
from slider_drilling.slide_scenarios.contenders import SHIFTED_ROCKING
from slider_drilling.slide_scenarios.faulty_rig import FaultyRig
from slider_drilling.training.draw import draw_rigs
from slider_drilling.training.observation import MeasurementObserver
from slider_drilling.training.scoring import score_controller

ELEMENTS = 20


def slides(n=4, **options):
    return sd.vector_env(n, **{"elements": ELEMENTS, "duration": 20.0, **options})


def rocking(step, n):
    """(n, 2) actions that rock and lower, each slot at its own pace."""
    phase = np.arange(n) + 0.3 * step
    return np.column_stack([3.0 * np.sin(phase), 0.003 + 0.002 * np.cos(phase)]).astype(np.float32)


def test_slots_equal_single_rigs():
    """Bit for bit, with noise, effects, and MWD that is late, lost and wrong."""
    many = slides(12, samples=1, actions="command", duration=60.0)
    many.reset(seed=5)
    effects = set()
    single = {}
    for slot in range(12):
        scenario, seed = many.episode(slot)
        effects.add(scenario.about)
        single[slot] = FaultyRig(scenario, seed, ELEMENTS)
        assert single[slot].rig.measurements == many.measurements(slot)
    assert len(effects) > 3, "the rigs have effects"
    received = 0
    for step in range(220):
        speed = 4.0 * np.sin(0.05 * step + np.arange(12))
        block = np.full(12, 0.004 * np.cos(0.02 * step))
        commands = np.column_stack([0.1 * step * speed, speed, block, np.full(12, 12.0)])
        many.step(commands)
        for slot, rig in single.items():
            expected = rig.step(RigCommand(*commands[slot]))
            assert many.measurements(slot) == expected
            received += len(expected.mwd)
    assert received >= 4


def test_foreign_slots_equal_foreign_plant():
    """The true channels: drives, plant, and slow changes in every step."""
    many = slides(3, foreign=1.0, samples=1, effects=False)
    many.reset(seed=2)
    drawn = [many._slots.rigs.rigs[k] for k in many.rig_index]
    for slot, each in enumerate(drawn):
        rig = each.scenario.true_rig()
        changes = slow_changes(each.structure, 20.0, np.random.default_rng(each.seed))
        start = InitialState(twist=float(many._twist[slot]))
        plant = ForeignPlant(rig, ELEMENTS, 0.1, start, Modifiers(), each.structure, changes)
        drives = DriveState(pump_speed=float(many._slots.rigs.pump_speed[many.rig_index[slot]]))
        rows = [advance(plant, 0, drives)]
        angle = 0.0
        for step in range(40):
            speed, block = (float(value) for value in rocking(step, 3)[slot])
            angle += 0.1 * speed
            command = RigCommand(angle, speed, block, drives.pump_speed)
            drives = follow_command(drives, command, rows[-1][0], rig.top_drive, 0.1)
            rows.append(advance(plant, step + 1, drives))
        many.reset(seed=2)
        for step in range(40):
            many.step(rocking(step, 3))
            np.testing.assert_allclose(many._slots.records.truth[slot], rows[step + 1], rtol=1e-9, atol=1e-9)


def test_slow_sensors_and_frequent_toolfaces_fit():
    """Several toolfaces a sample, many on their way: as a single rig."""
    rig = sd.load_rig().with_({"sensors.rate": 1.0, "sensors.mwd.period": 0.5, "sensors.mwd.latency": 7.0})
    many = sd.vector_env(1, [rig], elements=ELEMENTS, duration=600.0, samples=1, actions="command")
    many.reset(seed=1)
    single = FaultyRig(*many.episode(0), ELEMENTS)
    for _ in range(500):
        many.step(np.array([[0.0, 0.0, 0.0025, 12.0]]))
        expected = single.step(RigCommand(0.0, 0.0, 0.0025, 12.0))
        assert many.measurements(0).surface_torque == expected.surface_torque
        assert not expected.mwd or many.measurements(0).mwd == expected.mwd[-1:]


def advance(plant, sample, d):
    row = (0.1 * sample, d.top_drive_angle, d.top_drive_speed, d.block_position, d.block_speed, d.pump_speed)
    response = plant.advance(Commands(*(np.array([value]) for value in row)))
    return np.array([getattr(response, name)[0] for name in CHANNELS])


def test_controllers_see_the_same_observation():
    many = slides(3, samples=1)
    observed, _ = many.reset(seed=1)
    observers = [MeasurementObserver() for _ in range(3)]
    for step in range(180):
        for slot, observer in enumerate(observers):
            shown = observer.observe(many.measurements(slot), float(many.targets[slot]))
            np.testing.assert_allclose(observed[slot], shown, rtol=1e-6, atol=1e-6)
        observed = many.step(rocking(step, 3))[0]
    assert (observed[:, -1] > 0.0).any()


def test_threads_and_slots_change_no_bit():
    results = []
    for n, threads in ((6, 1), (6, 4), (3, None)):
        many = slides(n, threads=threads, drawn=3, foreign=0.4)
        many.reset(seed=4)
        results.append([many.step(rocking(step, n))[0][:3] for step in range(25)])
    assert np.array_equal(results[0], results[1]) and np.array_equal(results[0], results[2])


def test_seed_fixes_episodes():
    many = slides()
    first, again, other = (many.reset(seed=seed)[0] for seed in (7, 7, 8))
    assert np.array_equal(first, again) and not np.array_equal(first, other)


@pytest.mark.parametrize("mode", ["next_step", "same_step", "disabled"])
def test_autoreset_follows_gymnasium(mode):
    many = slides(2, duration=3.0, autoreset=mode)
    many.reset(seed=0)
    for step in range(2):
        assert not many.step(rocking(step, 2))[3].any()
    observed, _, ended, cut, info = many.step(rocking(2, 2))
    assert cut.all() and not ended.any()
    if mode == "same_step":
        assert (observed[:, 0] == 0.0).all() and (info["final_obs"][:, 0] == 3.0).all()
        return
    assert (observed[:, 0] == 3.0).all()
    if mode == "next_step":
        observed, earned, _, cut, _ = many.step(rocking(3, 2))
        assert (observed[:, 0] == 0.0).all() and (earned == 0.0).all() and not cut.any()
        return
    with pytest.raises(RuntimeError, match="reset it"):
        many.step(rocking(3, 2))
    observed, _ = many.reset(options={"reset_mask": np.array([True, True])})
    assert (observed[:, 0] == 0.0).all()


class OneSlot(gymnasium.Env):
    """A slot as a single environment, for gymnasium's checker."""

    def __init__(self):
        self.many = slides(1, autoreset="disabled", drawn=2)
        self.action_space, self.observation_space = self.many.single_action_space, self.many.single_observation_space

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        observed, _ = self.many.reset(seed=None if seed is None else [seed])
        return observed[0], {}

    def step(self, action):
        observed, earned, ended, cut, _ = self.many.step(action[None])
        return observed[0], float(earned[0]), bool(ended[0]), bool(cut[0]), {}


def test_gymnasium_checker_passes():
    check_env(OneSlot(), skip_render_check=True)


def test_registered_id_makes_one_and_many():
    many = gymnasium.make_vec("slider_drilling.training.registered:slider_drilling/Slide-v0", num_envs=2,
                              vectorization_mode="vector_entry_point", elements=ELEMENTS)  # fmt: skip
    observed, _ = many.reset(seed=0)
    assert many.observation_space.contains(observed)
    one = gymnasium.make("slider_drilling/Slide-v0", elements=ELEMENTS)
    assert one.observation_space.contains(one.reset(seed=0)[0])


def test_reward_pays_hole_on_target():
    many = slides(8, duration=200.0, effects=False)
    many.reset(seed=0)
    lower = np.tile(np.array([0.0, 0.0025], np.float32), (8, 1))
    for _ in range(150):
        before = many._deepest.copy()
        _, earned, _, _, info = many.step(lower)
    hole = np.maximum(info["bit_depth"] - before, 0.0)
    assert hole.max() > 0.0
    np.testing.assert_allclose(earned, hole / 0.0025 * (1.0 - 2.0 * np.abs(info["error"]) / np.pi), atol=1e-9)


def test_scores_are_those_of_a_campaign():
    drawn = draw_rigs(2, sd.load_rig(), 3, 250.0, True, 0.0)
    scores = score_controller(FixedRocking, drawn, 3, ELEMENTS)
    for number, (each, score) in enumerate(zip(drawn, scores, strict=True)):
        single = run_scenario(each.scenario, SHIFTED_ROCKING, noise_seed(3, number), ELEMENTS).score
        assert score == single


@pytest.mark.parametrize(
    ("options", "message"),
    [({"n": 0}, "n = 0"), ({"duration": 0.0}, "duration = 0"), ({"samples": 0}, "samples = 0"),
     ({"actions": "torque"}, "actions = 'torque'"), ({"autoreset": "never"}, "autoreset = 'never'"),
     ({"effects": ("gravity",)}, "'gravity' is unknown"), ({"foreign": 1.5}, "foreign = 1.5"),
     ({"threads": 0}, "threads = 0"), ({"drawn": 0}, "drawn = 0"), ({"rig": []}, "at least one rig"),
     *(({name: value}, f"^vector_env: {name} = {value!r}: give ") for value in ("a", [2], True)
       for name in ("n", "drawn", "samples", "threads", "duration", "foreign")),
     ({"n": None}, "^vector_env: n = None: give a whole"), ({"samples": None}, "samples = None: give a whole"),
     *(({name: 2.5}, f"^vector_env: {name} = 2.5: give a whole") for name in ("n", "drawn", "samples", "threads")),
     *(({"rig": value}, "^vector_env: rig = .*: give a rig as `load_rig`") for value in ("x", 5, ["x"], {})),
     *(({"effects": value}, "^vector_env: effects = ") for value in ("heave", 5, None)),
     *(({name: value}, f"^vector_env: {name} = ") for name in ("actions", "autoreset") for value in (5, ["speed"]))],
)  # fmt: skip
def test_bad_argument_is_named(options, message):
    with pytest.raises(sd.InputError, match=message.replace("[2]", r"\[2\]")):
        slides(**{"n": 2, **options})


@pytest.mark.parametrize("option", [{"foreign": 0.5}, {"effects": ["heave"]}])
def test_rigs_that_are_given_refuse_what_would_change_them(option):
    with pytest.raises(sd.InputError, match=f"{next(iter(option))}: several rigs are used exactly as they are"):
        slides(2, rig=[sd.load_rig()], **option)


@pytest.mark.parametrize("seed", [-1, 2.5, True, "ab", [0, -1], [0, 1.5]])
def test_bad_seeds_are_refused(seed):
    with pytest.raises(sd.InputError, match=r"seed = .*: give a whole number from 0 on, or one for each slot"):
        slides(2).reset(seed=seed)


def test_every_slot_starts_before_some_start_again():
    """A slot that never started has no string."""
    many = slides(2, autoreset="disabled")
    with pytest.raises(sd.InputError, match="no slot has started yet"):
        many.reset(options={"reset_mask": np.array([True, False])})
    many.reset(seed=0)
    many.reset(options={"reset_mask": np.array([True, False])})


def test_bad_actions_are_refused():
    many = slides(2)
    with pytest.raises(RuntimeError, match="reset"):
        many.step(np.zeros((2, 2), np.float32))
    many.reset(seed=0)
    with pytest.raises(sd.InputError, match="shape"):
        many.step(np.zeros((2, 3), np.float32))
    with pytest.raises(sd.InputError, match="not finite"):
        many.step(np.full((2, 2), np.nan, np.float32))
