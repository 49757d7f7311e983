"""`investigate --on ros`: a programme on the simulator's nodes, and on a rig that stands behind the topics."""

import time
from dataclasses import replace

import pytest

from slider_drilling.commands.investigate import run_on_ros
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import read_log
from slider_drilling.programmes import load_programme, parse_programme
from slider_drilling.programmes.progress import ProgrammeProgress, ProgrammeState

PROGRAMME = """\
schema: slider_drilling/programme/1
steps:
  - rock: {right: 0.5 turns, left: 0.5 turns, speed: 60 rpm, cycles: 1}
"""


@pytest.fixture
def programme(tmp_path):
    path = tmp_path / "programme1.yaml"
    path.write_text(PROGRAMME)
    return path


@pytest.fixture
def rig():
    return installed_file("config/rig.example.yaml")


@pytest.mark.slow
def test_rig_behind_the_topics_is_driven(programme, rig, start, namespace, tmp_path):
    """The simulator plays the rig: in real time, on the wall's clock, without a controller of its own."""
    simulator = start("friction_simulator", speed=1.0, elements=20, start_time=time.time() + 2.0)
    log = tmp_path / "log2.mcap"
    assert run_on_ros(rig, programme, log, effects=(), driven=namespace)
    assert simulator.process.poll() is None
    recorded = read_log(log)
    assert parse_programme(recorded.programme_text) == load_programme(programme)
    assert recorded.top_drive.position.max() == pytest.approx(3.14, abs=0.3)
    assert recorded.top_drive.position.min() == pytest.approx(-3.14, abs=0.3)
    assert recorded.rig().string.length == pytest.approx(4000.0)


@pytest.mark.slow
def test_simulated_rig_has_the_effect(programme, rig, alone, tmp_path):
    plain, biased = tmp_path / "log1.mcap", tmp_path / "log2.mcap"
    assert run_on_ros(rig, programme, plain, effects=(), driven=None)
    assert run_on_ros(rig, programme, biased, effects=("torque_sensor_bias:bias=900",), driven=None)
    first, second = (read_log(path).top_drive.effort.mean() for path in (plain, biased))
    assert second - first == pytest.approx(900.0, abs=60.0)


def test_programme_that_was_interrupted_is_not_done():
    """What is recorded of it is no run of the programme."""
    rig_session = pytest.importorskip("slider_drilling.nodes.rig_session")
    running = ProgrammeProgress(ProgrammeState.RUNNING, 1, 2, "rock", "", 9.0, "", ())
    assert rig_session.why_not_done(running) == "interrupted: step 1 of 2: rock; 9 s left"
    assert rig_session.why_not_done(replace(running, state=ProgrammeState.DONE)) == ""
    assert rig_session.why_not_done(replace(running, state=ProgrammeState.ABORTED, reason="asked for")) == "asked for"
    assert rig_session.why_not_done(None) == "it never began"


def test_failed_run_ends_with_one_line(programme, rig, alone, tmp_path):
    programme.write_text(PROGRAMME.replace("60 rpm", "600 rpm"))
    with pytest.raises(InputError, match=r"programme1.yaml: the run ended with code 2: .*rock.speed"):
        run_on_ros(rig, programme, tmp_path / "log1.mcap", effects=(), driven=None)
    assert not (tmp_path / "log1.mcap").exists()


@pytest.mark.slow
def test_aborted_run_gives_its_reason(programme, rig, alone, tmp_path):
    programme.write_text(PROGRAMME.replace("steps:", "limits: {right_torque: 1 kN m}\nsteps:"))
    with pytest.raises(InputError, match=r"programme1.yaml: aborted: torque to the right would reach"):
        run_on_ros(rig, programme, tmp_path / "log1.mcap", effects=(), driven=None)
