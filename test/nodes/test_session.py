"""Simulator, controller and recorder over DDS in one process: repeatable, recorded, ended in order."""

import math
import os
import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from slider_drilling.control import FixedRocking
from slider_drilling.drillstring import VirtualRig
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.nodes.session import SessionOptions, run_session
from slider_drilling.rig import load_rig

ELEMENTS = 20
FIXED = "slider_drilling.control:FixedRocking"


def payloads(path: Path) -> dict[str, list[tuple[int, bytes]]]:
    found = defaultdict(list)
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            found[channel.topic].append((message.log_time, message.data))
    return dict(found)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two logs of the same 25 s in lockstep."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
        patch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
        plans = [
            SessionOptions(
                duration=25.0, record=tmp_path_factory.mktemp("log"), target=0.3, controller=FIXED, elements=ELEMENTS
            )
            for _ in range(2)
        ]
        outcomes = [run_session(plan) for plan in plans]
    assert all(not outcome.signal and outcome.simulated == 25.0 for outcome in outcomes)
    return [outcome.log for outcome in outcomes if outcome.log is not None]


def test_lockstep_repeats_bit_for_bit(runs):
    first, second = map(payloads, runs)
    assert (
        set(first)
        == set(second)
        == {
            "/top_drive/command",
            "/top_drive/joint_states",
            "/draw_works/command",
            "/draw_works/joint_states",
            "/standpipe_pressure",
            "/mud_pump/joint_states",
            "/mud_pump/command",
            "/mwd/tool_face",
            "/tool_face/target",
            "/truth/bit",
            "/truth/weight_on_bit",
            "/truth/depth",
            "/diagnostics",
            "/rig_description",
            "/clock",
        }
    )
    for topic, messages in first.items():
        differing = [k for k, pair in enumerate(zip(messages, second[topic], strict=True)) if pair[0] != pair[1]]
        assert not differing, (topic, differing[:5])


def test_every_sample_is_recorded(runs):
    log = read_log(runs[0])
    assert log.notes == ()
    for series in (log.top_drive, log.draw_works, log.mud_pump, log.standpipe_pressure, log.truth_bit):
        np.testing.assert_allclose(series.time, 0.1 * np.arange(251), atol=1e-9)
    np.testing.assert_array_equal(log.top_drive_command.time, log.top_drive.time)
    np.testing.assert_allclose(log.mwd_tool_face.arrival - log.mwd_tool_face.time, 6.0, atol=1e-9)
    assert set(log.tool_face_target.position) == {0.3}
    assert log.rig().string.length == pytest.approx(4000.0)
    assert np.sqrt(log.standpipe_pressure.variance[0]) == pytest.approx(log.rig().sensors.standpipe_pressure.noise)


def test_run_over_dds_equals_run_without(runs, repository):
    log = read_log(runs[0])
    rig = load_rig(repository / "config" / "rig.example.yaml")
    virtual, controller = VirtualRig(rig, 0, ELEMENTS), FixedRocking(rig, tool_face_target=0.3)
    measurements = virtual.measurements
    for k in range(len(log.top_drive.time)):
        assert log.top_drive.position[k] == pytest.approx(measurements.top_drive_angle, abs=1e-9), k
        assert log.top_drive.effort[k] == pytest.approx(measurements.surface_torque, abs=1e-3), k
        assert log.draw_works.position[k] == pytest.approx(measurements.block_position, abs=1e-9), k
        measurements = virtual.step(controller.step(measurements))


def test_real_time_gives_the_same_run(runs, alone, tmp_path):
    # In slow motion: an answer has 0.4 s of wall time, which a busy machine has, too.
    outcome = run_session(
        SessionOptions(duration=1.0, speed=0.25, record=tmp_path, target=0.3, controller=FIXED, elements=ELEMENTS)
    )
    assert outcome.wall > 3.9
    paced, lockstep = read_log(outcome.log), read_log(runs[0])
    np.testing.assert_allclose(paced.top_drive.time, 0.1 * np.arange(11), atol=1e-9)
    command = paced.top_drive_command
    answered = set(np.round(command.time[command.arrival < command.time + 0.05], 1))
    same = next((k for k in range(11) if round(0.1 * k, 1) not in answered), 10)
    np.testing.assert_array_equal(paced.top_drive.effort[: same + 1], lockstep.top_drive.effort[: same + 1])
    assert same > 1, "this machine answered not even the first samples in time"


BROKEN = {
    "raises": ("raise ZeroDivisionError('by nothing')", r"raised ZeroDivisionError: by nothing at broken_raises.py:7"),
    "nan": ("return RigCommand(math.nan, 0.0, 0.0, 0.0)", r"returned top_drive_angle = nan"),
    "nothing": ("return None", r"returned NoneType, not a RigCommand"),
}


@pytest.mark.parametrize("how", BROKEN)
def test_failing_controller_is_named_and_log_kept(how, alone, tmp_path, monkeypatch):
    body, expected = BROKEN[how]
    module = f"broken_{how}"
    (tmp_path / f"{module}.py").write_text(
        "import math\nfrom slider_drilling.control.interface import RigCommand\n"
        "class Mine:\n    def __init__(self, rig): pass\n"
        f"    def step(self, measurements):\n        if measurements.time > 0.95:\n            {body}\n"
        "        return RigCommand(0.0, 0.0, 0.0, 12.0)\n"
    )
    monkeypatch.chdir(tmp_path)
    plan = SessionOptions(duration=5.0, record=tmp_path / "log", controller=f"{module}:Mine", elements=ELEMENTS)
    with pytest.raises(InputError, match=expected):
        run_session(plan)
    (path,) = (tmp_path / "log").glob("*.mcap")
    assert read_log(path).top_drive.time[-1] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"controller": "no_such_module:Mine"}, "cannot be imported: ModuleNotFoundError"),
        ({"controller": "math"}, "must be module:Class"),
        ({"controller": "fractions:Fraction"}, "has no method step|raised TypeError"),
        ({"rig": "no_such_rig.yaml"}, r"no_such_rig\.yaml: no such rig file"),
    ],
)
def test_failed_start_leaves_no_log(change, expected, alone, tmp_path):
    with pytest.raises(InputError, match=expected):
        run_session(SessionOptions(duration=5.0, record=tmp_path, elements=ELEMENTS, **change))
    assert list(tmp_path.iterdir()) == []


def test_folder_that_cannot_be_made_is_refused(alone, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=re.escape(f"{tmp_path}/file/log: cannot make this folder")):
        run_session(SessionOptions(duration=5.0, record=tmp_path / "file" / "log", elements=ELEMENTS))


def test_session_holds_the_given_target(runs):
    log = read_log(runs[0])
    assert math.isclose(log.tool_face_target.position[0], 0.3)


def test_the_default_executor_gives_the_same_run(runs, alone, tmp_path, monkeypatch):
    from rclpy.executors import SingleThreadedExecutor

    from slider_drilling.nodes import spin

    monkeypatch.setattr(spin, "make_executor", lambda supported: SingleThreadedExecutor())
    outcome = run_session(
        SessionOptions(duration=5.0, record=tmp_path, target=0.3, controller=FIXED, elements=ELEMENTS)
    )
    first, second = payloads(outcome.log), payloads(runs[0])
    for topic in ("/top_drive/joint_states", "/top_drive/command", "/standpipe_pressure", "/truth/bit"):
        assert [data for _, data in first[topic]] == [data for _, data in second[topic]][:51], topic
