"""Nodes as processes: started as `ros2 run` starts them, ended by signals, with their exit codes."""

import os
import signal
import subprocess
import sys

import pytest

from slider_drilling.log import read_log


@pytest.fixture
def recorded(start, tmp_path):
    """The log of a simulator that ended after its duration, and of others that ended at a signal."""
    recorder = start("recorder", new_interpreter=True, directory=tmp_path, file="run.mcap", use_sim_time=True)
    controller = start("rocking_controller", new_interpreter=True, use_sim_time=True)
    simulator = start("friction_simulator", new_interpreter=True, duration=20.0, elements=20, minimum_subscribers=2)
    assert simulator.end() == 0, simulator.output
    for program in (controller, recorder):
        program.process.send_signal(signal.SIGINT)
        assert program.end() == 0, program.output
    return tmp_path / "run.mcap"


def test_three_processes_run_in_lockstep_and_replay(recorded, start, tmp_path):
    again = start("recorder", directory=tmp_path, file="again.mcap", use_sim_time=True)
    again.wait_for("recording to")
    player = start("log_player", new_interpreter=True, log=recorded, rate=20.0, delay=0.5, minimum_subscribers=1)
    first = read_log(recorded)
    assert first.notes == ()
    assert first.top_drive is not None and len(first.top_drive.time) == 201
    assert first.top_drive_command is not None and len(first.top_drive_command.time) == 201
    assert first.rig().string.length == pytest.approx(4000.0)
    assert player.end() == 0, player.output
    again.process.send_signal(signal.SIGINT)
    assert again.end() == 0, again.output
    second = read_log(tmp_path / "again.mcap")
    for key in ("top_drive", "top_drive_command", "draw_works", "mud_pump", "mwd_tool_face", "truth_bit"):
        one, two = getattr(first, key), getattr(second, key)
        assert one.time.tolist() == two.time.tolist(), key
        assert one.position.tolist() == pytest.approx(two.position.tolist(), nan_ok=True), key
    assert first.rig_text == second.rig_text


def test_help_that_nobody_reads_ends_quietly():
    code = "import sys; from slider_drilling.nodes import programs; sys.argv[1:] = ['--help']; programs.recorder()"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run([sys.executable, "-c", code], stdout=write, stderr=subprocess.PIPE, text=True, timeout=60)
    os.close(write)
    assert (done.returncode, done.stderr) == (1, "")


ENDINGS = {
    "interrupt": (signal.SIGINT,),
    "interrupt_twice": (signal.SIGINT, signal.SIGINT),
    "terminate": (signal.SIGTERM,),
    "kill": (signal.SIGKILL,),
}


def test_log_is_readable_however_recorder_ends(start, wait_for_bytes, tmp_path):
    start("rocking_controller", use_sim_time=True)
    recorders = {
        how: start("recorder", directory=tmp_path / how, file="run.mcap", use_sim_time=True) for how in ENDINGS
    }
    start("friction_simulator", elements=20, minimum_subscribers=1 + len(recorders))
    for how, recorder in recorders.items():
        wait_for_bytes(tmp_path / how, 100_000, recorder.process)
        for number in ENDINGS[how]:
            recorder.process.send_signal(number)
    for how, recorder in recorders.items():
        assert recorder.end() == (-signal.SIGKILL if how == "kill" else 0), recorder.output
        assert "Traceback" not in recorder.output
        assert sorted(path.name for path in (tmp_path / how).iterdir()) == ["metadata.yaml", "run.mcap"]
        log = read_log(tmp_path / how / "run.mcap")
        assert log.top_drive is not None and log.top_drive.time[-1] > 5.0
        assert log.rig_text is not None
        if how == "kill":
            assert "recovered up to the last complete chunk" in " ".join(log.notes)
        else:
            assert log.notes == ()


@pytest.mark.parametrize("name", ["friction_simulator", "rocking_controller"])
def test_waiting_node_ends_on_interrupt(name, start):
    program = start(name, **({"patience": 0.1} if name == "friction_simulator" else {}))
    if name == "friction_simulator":
        program.wait_for("waiting for a controller: nobody publishes top_drive/command")
    else:
        program.wait_for("rocking with")
    program.process.send_signal(signal.SIGINT)
    assert program.end() == 0, program.output


def test_simulator_can_be_interrupted_during_start(start):
    program = start("friction_simulator", new_interpreter=True)
    program.wait_for("preparing the plant")
    program.process.send_signal(signal.SIGINT)
    assert program.end() == 0, program.output
    assert "Traceback" not in program.output


def test_lost_controller_is_named(start):
    controller = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, patience=0.3)
    simulator.wait_for("in lockstep")
    controller.process.kill()
    simulator.wait_for("waiting for")
    simulator.wait_for("to answer the sample of")
    assert "top_drive/command" in simulator.output


@pytest.mark.parametrize(
    ("name", "parameters", "expected"),
    [
        ("friction_simulator", {"rig": "no_such.yaml"}, "no_such.yaml: no such rig file"),
        ("friction_simulator", {"speed": -1.0}, "parameter speed: "),
        (
            "friction_simulator",
            {"duration": 300},
            "parameter duration: must be a number with a decimal point, such as 0.0",
        ),
        (
            "rocking_controller",
            {"controller": "slider_drilling.control:FixedRocking", "amplitude": 1e6},
            "parameter amplitude: ",
        ),
        ("rocking_controller", {"controller": "nowhere"}, "controller = 'nowhere': must be module:Class"),
        ("recorder", {"directory": "/dev/null/logs"}, "/dev/null/logs: cannot make this folder for logs"),
        ("recorder", {"file": "log.txt"}, "must be a name ending in .mcap"),
        ("log_player", {"log": "no_such.mcap"}, "no_such.mcap: no such log"),
    ],
)
def test_mistake_is_one_line_and_exit_code_2(name, parameters, expected, start):
    program = start(name, **parameters)
    assert program.end() == 2
    lines = [line for line in program.output.splitlines() if not line.startswith("[")]
    assert len(lines) == 1 and expected in lines[0], program.output
