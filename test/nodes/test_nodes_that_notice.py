"""What a rig must never do: go on unattended, be locked out, wait for ever, or not say so. Real processes."""

import re
import signal
import time

import pytest

from slider_drilling.log import read_log
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS

OK, WARN, ERROR = 0, 1, 2
COMMANDS = "friction_simulator: commands"


def test_a_rig_without_controller_stops_its_block_and_says_so_until_commands_return(start, ear):
    """It lowered the block for as long as it ran."""
    controller = start("rocking_controller", use_sim_time=True)
    start("friction_simulator", elements=20, speed=2.0, wait_for_controller=True)
    ear.until(lambda: any(block[2] > 0.001 for block in ear.heard["draw_works"]), "lowered")
    controller.kill()
    ear.until_status(COMMANDS, ERROR, "no command on top_drive/command and draw_works/command for 1 s")
    # A drive that is braked in finite steps ends at zero but for rounding.
    ear.until(lambda: all(abs(ear.heard[who][-1][2]) < 1e-9 for who in ("draw_works", "top_drive")), "stopped")
    last_command, depth = ear.heard["top_drive_command"][-1][0], ear.heard["draw_works"][-1][1]
    moving = max(stamp for stamp, _, speed, _ in ear.heard["draw_works"] if speed > 0.0)
    assert moving - last_command < 2.0, "the timeout, and what the drive needs to stop"
    ear.until_time(ear.time + 2.0)
    assert ear.heard["draw_works"][-1][1] == depth
    assert ear.heard["mud_pump"][-1][2] > 5.0, "the pump goes on"
    ear.sayer(TOPICS["top_drive_command"]).publish(cdr.encode_joint_state(time.time_ns(), "top_drive", 50.0, 0.0))
    ear.until_status(COMMANDS, ERROR, "ahead of the rig: that is the wall's clock")  # the silence did not hide it
    start("rocking_controller", use_sim_time=True)
    # Whether every sample is answered in time again is the machine's affair.
    ear.until(lambda: ear.statuses[COMMANDS].level < bytes([ERROR]), "commands are back")


@pytest.mark.parametrize("speed", [0.0, 5.0], ids=["lockstep", "real time"])
def test_one_command_stamped_ahead_locks_nobody_out(speed, start, ear):
    controller = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, speed=speed, wait_for_controller=True)
    typed = ear.sayer(TOPICS["top_drive_command"])
    # This publisher is enough for the rig to begin: its controller may come later.
    ear.until(lambda: any(stamp >= 1.0 for stamp, *_ in ear.heard["top_drive_command"]), "the controller's commands")
    typed.publish(cdr.encode_joint_state(time.time_ns(), "top_drive", 50.0, 0.0))
    ear.until_status(COMMANDS, ERROR, "ahead of the rig: that is the wall's clock; set use_sim_time on its node")
    told = ear.time
    if speed:  # in real time it is the machine's affair whether every sample is answered in time
        ear.until(lambda: ear.statuses[COMMANDS].level < bytes([ERROR]), "the next good command is taken")
    else:
        ear.until_status(COMMANDS, OK, "every sample is answered")
    ear.until_time(told + 5.0)
    assert all(abs(position) < 45.0 for _, position, *_ in ear.heard["top_drive"]), "the refused angle was not used"
    for program in (simulator, controller):
        program.process.send_signal(signal.SIGINT)
        assert program.end() == 0, program.said


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_lockstep_goes_on_when_its_controller_is_started_again(number, start, ear):
    """The sample that waited was for the one that is gone; nobody else ever heard it. DDS lists the dead a while."""
    first = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, patience=0.3)
    ear.until_time(2.0)
    first.process.send_signal(number)
    first.end()
    simulator.wait_for("to answer the sample of")
    stood = float(re.search(r"answer the sample of ([\d.]+) s", simulator.said)[1])
    ear.until_time(stood)
    start("rocking_controller", use_sim_time=True)
    ear.until_time(stood + 20.0)
    stamps = [stamp for stamp, *_ in ear.heard["top_drive"]]
    assert stamps.count(stood) > 1, "asked again"
    after = [stamp for stamp in stamps if stamp > stood]
    assert len(set(after)) == len(after) and after == sorted(after), "no step was made twice"
    simulator.process.send_signal(signal.SIGINT)
    assert simulator.end() == 0, simulator.said


def test_a_simulator_that_dies_is_noticed_and_the_next_one_is_answered(start, ear):
    """Simulated time stands still with it: only the wall's clock tells."""
    controller = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, speed=5.0, wait_for_controller=True)
    ear.until_time(4.0)
    simulator.kill()
    ear.until_status("rocking_controller: measurements", ERROR, "the rig is silent since")
    again = start("friction_simulator", elements=20, duration=20.0, minimum_subscribers=2)
    ear.until_status("rocking_controller: measurements", OK, "every surface channel is there")
    assert again.end() == 0, again.said
    controller.wait_for("the rig's clock went back")


@pytest.mark.parametrize("stamp", ["whole second", "zero"])
def test_a_target_is_taken_whatever_its_stamp(stamp, start, ear):
    """Stamps of the controller's own targets are whole seconds; it took others of the same for its own, silently."""
    start("rocking_controller", use_sim_time=True, tool_face_target=0.25)
    start("friction_simulator", elements=20, speed=2.0, wait_for_controller=True)
    typed = ear.sayer(TOPICS["tool_face_target"])
    ear.until(lambda: any(stamp >= 1.0 for stamp, *_ in ear.heard["tool_face_target"]), "own targets")
    ear.until(lambda: ear.heard["top_drive"], "a sample")  # discovered by itself, it may be later
    at = 0 if stamp == "zero" else round(ear.heard["tool_face_target"][-1][0] * 1e9)
    typed.publish(cdr.encode_joint_state(at, "tool_face", -1.5))
    begun = ear.time
    ear.until(lambda: any(stamp > begun and target == -1.5 for stamp, target, *_ in ear.heard["tool_face_target"]))


def test_two_rigs_in_one_graph_keep_their_own_time(start, tmp_path):
    """A namespace is enough: each has its clock within it."""
    programs, simulators = [], []
    for name, begins in (("/a", 0.0), ("/b", 5000.0)):
        programs += [
            start("rocking_controller", within=name, use_sim_time=True),
            start("recorder", within=name, directory=tmp_path, file=f"{name[1:]}.mcap", use_sim_time=True),
        ]
        simulators.append(
            start(
                "friction_simulator", within=name, elements=20, duration=60.0, start_time=begins, minimum_subscribers=2
            )
        )
    for program in simulators:
        assert program.end() == 0, program.said
    for program in programs:
        program.process.send_signal(signal.SIGINT)
        assert program.end() == 0, program.said
    for name, begins in (("a", 0.0), ("b", 5000.0)):
        (path,) = tmp_path.rglob(f"{name}.mcap")
        log = read_log(path)
        assert log.notes == () and log.start == begins
        assert len(log.top_drive.time) == 601
        assert abs(log.top_drive.arrival - log.top_drive.time).max() < 1.0, "arrivals are on the rig's own clock"


STUCK = """
from slider_drilling.control.interface import RigCommand
class Mine:
    def __init__(self, rig): pass
    def step(self, measurements):
        while measurements.time > 1.0:
            try: print("stuck", flush=True)
            except Exception: pass
        return RigCommand(0.0, 0.0, 0.0, 12.0)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_controller_stuck_in_its_step_can_be_interrupted(number, start, ear, tmp_path):
    (tmp_path / "stuck_controller.py").write_text(STUCK)
    stuck = start("rocking_controller", use_sim_time=True, controller="stuck_controller:Mine")
    start("friction_simulator", elements=20, patience=0.3).wait_for("to answer the sample of 1.100 s")
    stuck.process.send_signal(number)
    assert stuck.end() == 0, stuck.said
