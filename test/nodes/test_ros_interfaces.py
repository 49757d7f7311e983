"""Interfaces for other ROS 2 programs: standard services, lifecycles, diagnostics, quality of service."""

import re
import signal

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from std_srvs.srv import Trigger

from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics

OK, ERROR = 0, 2


def triggered(listener, name):
    answer = listener.call(Trigger, name)
    return answer.success, answer.message


def test_simulator_pauses_steps_and_resets(start, listener):
    start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, speed=5.0, wait_for_controller=True)
    listener.until_time(1.0)
    assert triggered(listener, "friction_simulator/step") == (False, "not paused; pause first")
    success, message = triggered(listener, "friction_simulator/pause")
    assert success
    listener.until_status("friction_simulator: clock", OK, "paused")
    # The listener may not have heard the last sample yet.
    stood = float(re.fullmatch(r"paused at ([\d.]+) s", message)[1])
    listener.until(lambda: listener.time == pytest.approx(stood), "the last sample")
    assert triggered(listener, "friction_simulator/step")[0]
    listener.until(lambda: listener.time == pytest.approx(stood + 0.1))
    success, message = triggered(listener, "friction_simulator/reset")
    assert success and "as at its start" in message
    listener.until(lambda: listener.time == pytest.approx(stood + 0.2), "time goes on")
    assert listener.latest("draw_works")[1] == 0.0 and listener.latest("top_drive")[1] == 0.0
    assert triggered(listener, "friction_simulator/resume")[0]
    listener.until_time(stood + 1.0)
    stamps = [stamp for stamp, *_ in listener.heard["top_drive"]]
    assert stamps == sorted(set(stamps)), "one run"
    simulator.process.send_signal(signal.SIGINT)
    assert simulator.end() == 0


def test_rocking_is_stopped_and_started(start, listener):
    start("rocking_controller", use_sim_time=True)
    start("friction_simulator", elements=20)
    listener.until(lambda: any(abs(speed) > 1.0 for *_, speed, _ in listener.heard["top_drive"]), "rocks")
    assert triggered(listener, "rocking_controller/stop_rocking") == (True, "the top drive parks")
    # A drive that is braked in finite steps ends at zero but for rounding.
    listener.until(lambda: all(abs(speed) < 1e-9 for *_, speed, _ in listener.heard["top_drive"][-50:]), "parked")
    assert triggered(listener, "rocking_controller/start_rocking") == (True, "rocking")
    parked = listener.time
    listener.until(
        lambda: any(abs(speed) > 1.0 for stamp, _, speed, _ in listener.heard["top_drive"] if stamp > parked), "rocks"
    )
    success, message = triggered(listener, "rocking_controller/reset")
    assert success and "starts anew" in message


def test_lifecycle_manager_starts_and_stops_controller(start, listener):
    start("rocking_controller", use_sim_time=True, autostart=False)
    start("friction_simulator", elements=20, speed=5.0)

    def change(transition: int) -> bool:
        return listener.call(
            ChangeState, "rocking_controller/change_state", transition=Transition(id=transition)
        ).success

    def state() -> str:
        return listener.call(GetState, "rocking_controller/get_state").current_state.label

    assert state() == "unconfigured"
    assert listener.call(GetState, "friction_simulator/get_state").current_state.label == "active"
    assert change(Transition.TRANSITION_CONFIGURE) and change(Transition.TRANSITION_ACTIVATE)
    listener.until(lambda: len(listener.heard["top_drive_command"]) > 20)
    assert state() == "active"
    assert change(Transition.TRANSITION_DEACTIVATE)
    listener.until_status("friction_simulator: commands", ERROR, "no command on top_drive/command")
    assert change(Transition.TRANSITION_CLEANUP) and state() == "unconfigured"
    assert change(Transition.TRANSITION_CONFIGURE) and change(Transition.TRANSITION_ACTIVATE)
    # Whether every sample is answered in time again is the machine's affair.
    commands = "friction_simulator: commands"
    listener.until(lambda: listener.statuses[commands].level < bytes([ERROR]), "commands are back")


def test_failed_configuration_is_reported_and_node_stays(start, listener, tmp_path):
    player = start("log_player", log=tmp_path / "no_such.mcap", autostart=False)
    answer = listener.call(
        ChangeState, "log_player/change_state", transition=Transition(id=Transition.TRANSITION_CONFIGURE)
    )
    assert not answer.success
    player.wait_for("no_such.mcap: no such log")
    assert listener.call(GetState, "log_player/get_state").current_state.label == "unconfigured"
    assert listener.call(
        ChangeState, "log_player/change_state", transition=Transition(id=Transition.TRANSITION_UNCONFIGURED_SHUTDOWN)
    ).success
    assert player.end() == 0, player.output


def test_aggregated_diagnostics_distinguish_two_rigs(start, listener, namespace):
    found, own = {}, namespace.strip("/")

    def keep(message: DiagnosticArray) -> None:
        # Other tests of this machine may be in the same domain.
        found.update({status.name: status.hardware_id for status in message.status if own in status.name})

    listener.node.create_subscription(DiagnosticArray, "/diagnostics", keep, 100)
    for name in ("/a", "/b"):
        start("rocking_controller", within=name, use_sim_time=True)
        start("friction_simulator", within=name, elements=20, speed=5.0)
    expected = {
        f"{own}/{rig}/{node}": f"{own}/{rig} rig.example"
        for rig in "ab"
        for node in ("friction_simulator", "rocking_controller")
    }
    listener.until(lambda: set(expected) <= {name.partition(":")[0] for name in found}, "statuses")
    assert {name.partition(":")[0]: hardware for name, hardware in found.items()} == expected


def publish_rig(listener, qos):
    """Publishers of a rig's channels, and a function that sends one sample."""
    names = ("mud_pump", "draw_works", "standpipe_pressure", "top_drive")
    out = {name: raw_topics.publisher(listener.node, TOPICS[name], qos) for name in names}

    def send(stamp_ns: int) -> None:
        out["mud_pump"].publish(cdr.encode_joint_state(stamp_ns, "mud_pump", None, 12.0))
        out["draw_works"].publish(cdr.encode_joint_state(stamp_ns, "block", 0.0, 0.0, 4e5))
        out["standpipe_pressure"].publish(cdr.encode_fluid_pressure(stamp_ns, 1.8e7, 0.0))
        out["top_drive"].publish(cdr.encode_joint_state(stamp_ns, "top_drive", 0.0, 0.0, 0.0))

    return send


@pytest.mark.parametrize("override", [False, True], ids=["as they come", "qos_overrides"])
def test_best_effort_sensors_are_received(override, start, listener, namespace):
    name = f"qos_overrides.{namespace}/top_drive/joint_states.subscription.reliability"
    controller = start("rocking_controller", **({name: "best_effort"} if override else {}))
    controller.wait_for("rocking with")
    send = publish_rig(listener, raw_topics.BEST_EFFORT)
    stamps = iter(range(10**9, 10**12, 10**8))

    def is_answered() -> bool:
        send(next(stamps))
        return len(listener.heard["top_drive_command"]) > 3

    listener.until(is_answered, "an answer")
    controller.process.send_signal(signal.SIGINT)
    assert controller.end() == 0
    warning = "top_drive/joint_states: the publisher is best-effort"
    assert (warning in controller.output) != override, controller.output


def test_bad_qos_override_is_one_line(start, namespace):
    name = f"qos_overrides.{namespace}/top_drive/joint_states.subscription.reliability"
    controller = start("rocking_controller", **{name: "perfect"})
    assert controller.end() == 2
    lines = [line for line in controller.output.splitlines() if not line.startswith("[")]
    assert len(lines) == 1 and "reliability" in lines[0] and "perfect" in lines[0], controller.output
