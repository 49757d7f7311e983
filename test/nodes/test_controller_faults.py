"""The controller beside a stopped process, a paused rig, a restart of its own, and no rig at all."""

import math
import signal
import time

import pytest
from rclpy.node import Node
from std_srvs.srv import Trigger
from turning import turn

from slider_drilling.control.interface import Measurements
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics, rocking_controller
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.rocking_controller import RockingController

RIG = ("mud_pump", "draw_works", "standpipe_pressure", "mwd_tool_face", "top_drive")


def stamps(listener, name: str = "top_drive_command") -> list[float]:
    return [stamp for stamp, *_ in listener.heard[name]]


@pytest.mark.parametrize("simulated", [True, False], ids=["rig's clock", "wall clock"])
def test_stopped_controller_keeps_what_it_learnt(simulated, start, listener):
    controller = start("rocking_controller", use_sim_time=simulated, tool_face_target=0.7)
    start_time = 0.0 if simulated else time.time()
    start("friction_simulator", elements=20, speed=1.0, wait_for_controller=True, start_time=start_time)
    listener.until_time(start_time + 2.0)
    controller.process.send_signal(signal.SIGSTOP)
    listener.listen(1.5)
    controller.process.send_signal(signal.SIGCONT)
    listener.until_time(listener.time + 3.0)
    assert "went back" not in controller.output and "starts anew" not in controller.output
    assert stamps(listener) == sorted(stamps(listener)), "the log is one run"
    assert listener.latest("tool_face_target")[1] == pytest.approx(0.7)


def test_paused_simulator_leaves_controller_as_it_is(start, listener):
    controller = start("rocking_controller", use_sim_time=False, stale_after=0.5)
    simulator = start("friction_simulator", elements=20, speed=3.0, wait_for_controller=True)
    listener.until_time(2.0)
    assert listener.call(Trigger, f"{simulator.name}/pause").success
    stood = listener.time
    listener.listen(2.0)  # four times stale_after
    assert listener.call(Trigger, f"{simulator.name}/resume").success
    listener.until_time(stood + 3.0)
    assert "went back" not in controller.output
    assert stamps(listener) == sorted(stamps(listener)), "the log is one run"


def test_ending_controller_stops_block_and_drive(start, listener):
    controller = start("rocking_controller", use_sim_time=True)
    start("friction_simulator", elements=20, command_timeout=60.0)
    listener.lower_at(2.0)
    ordered = listener.time
    controller.process.send_signal(signal.SIGINT)
    assert controller.end() == 0, controller.output
    moving = ("draw_works", "top_drive")
    listener.until(lambda: all(abs(listener.latest(name)[2]) < 1e-5 for name in moving), "block and drive at rest")
    assert listener.time < ordered + 60.0, "before the command timeout"
    assert listener.latest("mud_pump")[2] > 5.0


def test_normal_end_logs_no_error(start, listener):
    controller = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, duration=3.0)
    assert simulator.end() == 0, simulator.output
    controller.wait_for("the rig has left")
    controller.process.send_signal(signal.SIGINT)
    assert controller.end() == 0
    assert "[ERROR]" not in controller.output, controller.output


def wait(nodes: list[Node], seconds: float) -> None:
    end = time.monotonic() + seconds
    turn(nodes, lambda: time.monotonic() > end)


@pytest.mark.parametrize("simulated", [True, False])
def test_reactivated_controller_takes_whole_samples(simulated, make, capfd):
    simulator = make(FrictionSimulator, elements=20, speed=5.0, wait_for_controller=True)
    controller = make(RockingController, use_sim_time=simulated, stale_after=0.5)
    seen: list[Measurements] = []
    step = controller._controller.step
    controller._controller.step = lambda measurements: (seen.append(measurements), step(measurements))[1]
    nodes = [simulator, controller]
    turn(nodes, lambda: simulator.simulated > 2.0)
    controller.trigger_deactivate()
    wait(nodes, 1.0)
    count = len(seen)
    controller.trigger_activate()
    turn(nodes, lambda: len(seen) > count + 20)
    assert all(math.isfinite(one.hook_load + one.surface_torque + one.pump_speed) for one in seen)
    assert "silent" not in capfd.readouterr().err


def test_deactivated_controller_leaves_a_standing_rig(make):
    simulator = make(FrictionSimulator, elements=20, speed=5.0, wait_for_controller=True, command_timeout=60.0)
    controller = make(RockingController, use_sim_time=True)
    turn([simulator, controller], lambda: simulator._virtual.measurements.block_speed > 0.001)
    controller.trigger_deactivate()
    at = simulator.simulated
    turn([simulator, controller], lambda: simulator.simulated > at + 3.0)
    measured = simulator._virtual.measurements
    assert abs(measured.block_speed) + abs(measured.top_drive_speed) < 1e-5


class Said:
    """What nodes of this process have logged."""

    def __init__(self, capfd) -> None:
        self._capfd, self._lines = capfd, ""

    def count(self, text: str) -> int:
        self._lines += self._capfd.readouterr().err
        return self._lines.count(text)


def test_waiting_controller_says_so_again_and_again(make, monkeypatch, capfd):
    monkeypatch.setattr(rocking_controller, "REPORT_PERIOD", 0.2)
    controller, said = make(RockingController), Said(capfd)
    waiting = "waiting for a rig: nobody publishes standpipe_pressure, mud_pump/joint_states"
    turn([controller], lambda: said.count(waiting) >= 3)
    rig = [raw_topics.publisher(controller, TOPICS[name]) for name in RIG]
    turn([controller], lambda: said.count("no sample of top_drive comes") >= 3)
    assert len(rig) == len(RIG)


def test_stamps_a_day_off_are_said_once_and_when_they_change(make, monkeypatch, capfd):
    monkeypatch.setattr(rocking_controller, "REPORT_PERIOD", 0.2)
    controller = make(RockingController, use_sim_time=False)
    rig = {name: raw_topics.publisher(controller, TOPICS[name]) for name in RIG}
    turn([controller], lambda: controller._commands.are_made)
    said, sent, days = Said(capfd), [0.0], [1]

    def send_sample() -> None:
        stamp = time.time_ns() - days[0] * 86_400 * 10**9
        rig["mud_pump"].publish(cdr.encode_joint_state(stamp, "mud_pump", None, 12.0))
        rig["draw_works"].publish(cdr.encode_joint_state(stamp, "block", 0.0, 0.0, 4e5))
        rig["standpipe_pressure"].publish(cdr.encode_fluid_pressure(stamp, 1.8e7, 0.0))
        rig["top_drive"].publish(cdr.encode_joint_state(stamp, "top_drive", 0.0, 0.0, 0.0))
        sent.append(time.monotonic())

    def is_said(seconds: int, samples: int) -> bool:
        if time.monotonic() > sent[-1] + 0.1:
            send_sample()
        return said.count(f"{seconds} s behind this node's clock") >= 1 and len(sent) > samples

    turn([controller], lambda: is_said(86_400, 20))
    assert said.count("86400 s behind this node's clock") == 1
    days[0] = 3
    turn([controller], lambda: is_said(259_200, 0))
