"""A programme in the node: recorded with its file, ended with its node, aborted by a service."""

import json

import pytest
from fork_server import run_cli
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger
from turning import turn

from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import read_log
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.programme_run import ProgrammeRun
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.session import SessionOptions, run_session
from slider_drilling.programmes import load_programme, parse_programme
from slider_drilling.programmes.find_programme import find_programme, programme_text
from slider_drilling.programmes.progress import ProgrammeState
from slider_drilling.rig import load_rig

PROGRAMME = """\
schema: slider_drilling/programme/1
name: short
steps:
  - rock: {right: 1 turn, left: 1 turn, speed: 60 rpm, cycles: 1}
  - rest: {time: 2 s}
"""


@pytest.fixture
def programme(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text(PROGRAMME)
    return path


def test_log_holds_the_programme_that_ran(programme, tmp_path, alone):
    outcome = run_session(SessionOptions(duration=0.0, record=tmp_path / "log", programme=str(programme), elements=20))
    assert outcome.programme.state is ProgrammeState.DONE
    log = read_log(outcome.log)
    assert parse_programme(log.programme_text) == load_programme(programme)
    assert log.top_drive.position.max() == pytest.approx(6.28, abs=0.3)
    # The run ends by itself, some seconds after the programme.
    ended = outcome.programme.records[-1].end
    assert ended + 4.0 < outcome.simulated < ended + 8.0


def test_run_aborted_by_a_limit_exits_with_1(programme, alone):
    programme.write_text(PROGRAMME.replace("name: short", "limits: {right_torque: 1 kN m}"))
    run = ("run", "--programme", programme, "--elements", 20, "--json")
    done = run_cli(*run, folder=programme.parent, loader="fork_loaders:load_nodes")
    assert done.returncode == 1, done.stderr
    ended = json.loads(done.stdout)["programme"]
    assert ended["state"] == "aborted" and "torque to the right would reach" in ended["reason"]


def test_service_aborts_the_programme(programme, make):
    simulator = make(FrictionSimulator, elements=20, duration=30.0)
    controller = make(RockingController, use_sim_time=True, programme=str(programme), end_with_programme=True)
    client = controller.create_client(Trigger, "rocking_controller/abort")
    answers = []

    def is_rocking():
        if controller.programme_progress.step and not answers:
            answers.append(client.call_async(Trigger.Request()))
        return bool(answers)

    turn([simulator, controller], is_rocking, lambda: controller.shutdown_request.requested)
    assert answers[0].result().success
    assert controller.programme_progress.reason == "asked for by the service abort"
    assert simulator._virtual.measurements.top_drive_speed == pytest.approx(0.0, abs=1e-6)


def test_programme_gives_the_toolface(programme, make):
    controller = make(RockingController, programme=str(programme))
    (result,) = controller.set_parameters([Parameter("tool_face_target", Parameter.Type.DOUBLE, 0.5)])
    assert not result.successful and "gives the toolface of each slide" in result.reason


def test_node_runs_a_slide_sheet(tmp_path):
    """Also one that is built in; a sheet of another depth is refused, as `run --programme` does."""
    sheet = tmp_path / "slides.csv"
    rows = "from [m],to [m],mode,toolface [deg]\n{0},{1},rotate,\n{1},{2},slide,30\n"
    sheet.write_text(rows.format(4000.0, 4009.0, 4018.0))
    rig = load_rig(installed_file("config/rig.example.yaml"))
    run = ProgrammeRun(str(sheet), ends_node=True)
    run.load(rig)
    assert run.progress.steps == 2
    assert parse_programme(programme_text(sheet)) == find_programme(sheet).programme
    run = ProgrammeRun("commissioning", ends_node=True)
    run.load(rig)
    assert run.progress.steps == len(find_programme("commissioning").programme.steps)
    sheet.write_text(rows.format(3000.0, 3009.0, 3018.0))
    with pytest.raises(InputError, match=r"slides.csv: begins at 3000.0 m, the bit of the rig file is at 4000.0 m"):
        ProgrammeRun(str(sheet), ends_node=True).load(rig)


def test_node_refuses_a_programme_beyond_the_rig(programme, make):
    programme.write_text(PROGRAMME.replace("60 rpm", "180 rpm"))
    with pytest.raises(InputError, match=r"short.yaml: steps\[0\].rock.speed"):
        make(RockingController, programme=str(programme))
