"""Lost controllers, restarts, wrong stamps and stuck code, with real processes."""

import math
import re
import signal
import threading
import time

import pytest

from slider_drilling.log import read_log
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS

OK, WARN, ERROR = 0, 1, 2
COMMANDS = "friction_simulator: commands"
WAITS_FOR = r"answer the sample of ([\d.]+) s"


def test_lost_controller_stops_block_until_commands_return(start, listener):
    controller = start("rocking_controller", use_sim_time=True)
    start("friction_simulator", elements=20)
    listener.lower_at(2.0)
    listener.latest("top_drive_command")  # the controller is heard here too
    controller.kill()
    listener.until_status(COMMANDS, ERROR, "no command on top_drive/command and draw_works/command for 1 s")
    # A drive that is braked in finite steps ends at zero but for rounding.
    listener.until(
        lambda: all(abs(listener.latest(who)[2]) < 1e-9 for who in ("draw_works", "top_drive")), "stopped"
    )
    last_command, depth = listener.latest("top_drive_command")[0], listener.latest("draw_works")[1]
    moving = max(stamp for stamp, _, speed, _ in listener.heard["draw_works"] if speed > 0.0)
    assert moving - last_command < 2.0, "the timeout, and what the drive needs to stop"
    listener.until_time(listener.time + 2.0)
    assert listener.heard["draw_works"][-1][1] == depth
    assert listener.latest("mud_pump")[2] > 5.0, "the pump goes on"
    listener.publisher(TOPICS["top_drive_command"]).publish(
        cdr.encode_joint_state(time.time_ns(), "top_drive", 50.0, 0.0)
    )
    listener.until_status(COMMANDS, ERROR, "ahead of the rig: that is the wall's clock")  # the silence did not hide it
    start("rocking_controller", use_sim_time=True)
    # Whether every sample is answered in time again is the machine's affair.
    listener.until(lambda: listener.statuses[COMMANDS].level < bytes([ERROR]), "commands are back")


@pytest.mark.parametrize("speed", [0.0, 5.0], ids=["lockstep", "real time"])
def test_command_stamped_ahead_does_not_block_controller(speed, start, listener):
    controller = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, speed=speed, wait_for_controller=True)
    typed = listener.publisher(TOPICS["top_drive_command"])
    # This publisher is enough for the rig to begin: its controller may come later.
    listener.until(
        lambda: any(stamp >= 1.0 for stamp, *_ in listener.heard["top_drive_command"]), "the controller's commands"
    )
    said = "ahead of the rig: that is the wall's clock; set use_sim_time on its node"

    typed_at = -math.inf

    def refused() -> bool:
        """Type once more after a while: on a busy machine the rig may not have found the publisher yet."""
        nonlocal typed_at
        if time.monotonic() - typed_at > 2.0:
            typed.publish(cdr.encode_joint_state(time.time_ns(), "top_drive", 50.0, 0.0))
            typed_at = time.monotonic()
        return COMMANDS in listener.statuses and said in listener.statuses[COMMANDS].message

    listener.until(refused, said)
    assert listener.statuses[COMMANDS].level == bytes([ERROR])
    lost_at = listener.time
    if speed:  # in real time it is the machine's affair whether every sample is answered in time
        listener.until(lambda: listener.statuses[COMMANDS].level < bytes([ERROR]), "the next good command is taken")
    else:
        listener.until_status(COMMANDS, OK, "every sample is answered")
    listener.until_time(lost_at + 5.0)
    assert all(abs(position) < 45.0 for _, position, *_ in listener.heard["top_drive"]), (
        "the refused angle was not used"
    )
    for program in (simulator, controller):
        program.process.send_signal(signal.SIGINT)
        assert program.end() == 0, program.output


def test_flood_of_refused_commands_stops_nothing(start, listener):
    start("rocking_controller", use_sim_time=True)
    start("friction_simulator", elements=20, wait_for_controller=True)
    typed = listener.publisher(TOPICS["top_drive_command"])
    listener.until(lambda: bool(listener.heard["top_drive_command"]), "the controller's commands")
    enough = threading.Event()

    def flood() -> None:
        while not enough.wait(0.002):
            typed.publish(cdr.encode_joint_state(time.time_ns(), "top_drive", 50.0, 0.0))

    flooding = threading.Thread(target=flood)
    flooding.start()
    try:
        listener.until_status(COMMANDS, ERROR, "ahead of the rig")
        listener.until_time(listener.time + 20.0)
        listener.until_status(COMMANDS, ERROR, "ahead of the rig")
    finally:
        enough.set()
        flooding.join()
    listener.until_status(COMMANDS, OK, "every sample is answered")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_lockstep_continues_after_controller_restart(number, start, listener):
    first = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, patience=0.3)
    listener.until_time(2.0)
    first.process.send_signal(number)
    first.end()
    # On a busy machine it may have waited for the first controller, too, and that one's last answer may come late.
    waited = len(re.findall(WAITS_FOR, simulator.output))

    def stands() -> bool:
        waits = re.findall(WAITS_FOR, simulator.output)
        return len(waits) > waited + 1 and waits[-1] == waits[-2]

    listener.until(stands, "the rig stands")
    stood = float(re.findall(WAITS_FOR, simulator.output)[-1])
    listener.until_time(stood)
    start("rocking_controller", use_sim_time=True)
    listener.until_time(stood + 20.0)
    samples = listener.heard["top_drive"]
    stamps = [stamp for stamp, *_ in samples]
    assert stamps.count(stood) > 1, "asked again"
    # A sample that is asked again is the same one; a step that was made twice would have another angle.
    assert stamps == sorted(stamps) and len(set(samples)) == len(set(stamps)), "no step was made twice"
    simulator.process.send_signal(signal.SIGINT)
    assert simulator.end() == 0, simulator.output


def test_controller_survives_restart_of_simulator(start, listener):
    controller = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, speed=5.0, wait_for_controller=True)
    listener.until_time(4.0)
    simulator.kill()
    listener.until_status("rocking_controller: measurements", ERROR, "the rig is silent since")
    again = start("friction_simulator", elements=20, duration=20.0, minimum_subscribers=2)
    listener.until_status("rocking_controller: measurements", OK, "every surface channel is there")
    assert again.end() == 0, again.output
    controller.wait_for("the rig's clock went back")


@pytest.mark.parametrize("stamp", ["whole second", "zero"])
def test_target_is_taken_with_any_stamp(stamp, start, listener):
    start("rocking_controller", use_sim_time=True, tool_face_target=0.25)
    start("friction_simulator", elements=20, speed=2.0, wait_for_controller=True)
    typed = listener.publisher(TOPICS["tool_face_target"])
    listener.until(lambda: any(stamp >= 1.0 for stamp, *_ in listener.heard["tool_face_target"]), "own targets")
    at = 0 if stamp == "zero" else round(listener.heard["tool_face_target"][-1][0] * 1e9)
    typed.publish(cdr.encode_joint_state(at, "tool_face", -1.5))
    started = listener.time
    listener.until(
        lambda: any(stamp > started and target == -1.5 for stamp, target, *_ in listener.heard["tool_face_target"])
    )


def test_two_rigs_keep_their_own_time(start, tmp_path):
    programs, simulators = [], []
    for name, begins in (("/a", 0.0), ("/b", 5000.0)):
        programs += [
            start("rocking_controller", within=name, use_sim_time=True),
            start("recorder", within=name, directory=tmp_path, file=f"{name[1:]}.mcap", use_sim_time=True),
        ]
        simulators.append(
            start(
                "friction_simulator", within=name, elements=20, duration=20.0, start_time=begins, speed=20.0,
                minimum_subscribers=2, wait_for_controller=True,
            )
        )
    for program in simulators:
        assert program.end() == 0, program.output
    for program in programs:
        program.process.send_signal(signal.SIGINT)
        assert program.end() == 0, program.output
    for name, begins in (("a", 0.0), ("b", 5000.0)):
        (path,) = tmp_path.rglob(f"{name}.mcap")
        log = read_log(path)
        assert log.notes == () and log.start == begins
        assert len(log.top_drive.time) == 201
        # The other rig's clock is 5000 s off; what a busy recorder is late, at 20 times real time, is seconds.
        assert abs(log.top_drive.arrival - log.top_drive.time).max() < 60.0, "arrivals are on the rig's own clock"


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
def test_stuck_controller_can_be_interrupted(number, start, listener, tmp_path):
    (tmp_path / "stuck_controller.py").write_text(STUCK)
    stuck = start("rocking_controller", use_sim_time=True, controller="stuck_controller:Mine")
    start("friction_simulator", elements=20, patience=0.3).wait_for("to answer the sample of 1.100 s")
    stuck.process.send_signal(number)
    assert stuck.end() == 0, stuck.output
