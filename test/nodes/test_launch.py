"""The launch files; skipped without `launch` and `ros2`, which a sourced ROS 2 has and the wheels lack."""

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from node_process import NodeProcess

from slider_drilling.log import read_log

launch = pytest.importorskip("launch")
launch_ros_actions = pytest.importorskip("launch_ros.actions")

needs_ros2 = pytest.mark.skipif(shutil.which("ros2") is None, reason="no ros2 command")


def described(repository: Path, name: str, **arguments: str) -> list[object]:
    """The nodes that a launch file would start."""
    spec = importlib.util.spec_from_file_location("under_test", repository / "launch" / f"{name}.launch.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    context = launch.LaunchContext()
    description = module.generate_launch_description()
    declared = [one for one in description.entities if isinstance(one, launch.actions.DeclareLaunchArgument)]
    for one in declared:
        context.launch_configurations[one.name] = arguments.get(one.name, "")
    assert not set(arguments) - {one.name for one in declared}
    (made,) = [one for one in description.entities if isinstance(one, launch.actions.OpaqueFunction)]
    return [one for one in made.execute(context) if isinstance(one, launch_ros_actions.Node)]


def names(nodes: list[object]) -> list[str]:
    return sorted(one.node_executable for one in nodes)


def test_recorder_is_launched_only_with_a_folder(repository):
    assert names(described(repository, "rocking")) == ["friction_simulator", "rocking_controller"]
    assert names(described(repository, "rocking", record="out")) == [
        "friction_simulator",
        "recorder",
        "rocking_controller",
    ]
    assert names(described(repository, "real_rig", record="out")) == ["recorder", "rocking_controller"]
    assert names(described(repository, "two_rigs", record="out")) == sorted(
        2 * ["friction_simulator", "recorder", "rocking_controller"]
    )


@pytest.mark.parametrize("program", ["dashboard", "twin"])
@pytest.mark.parametrize(
    ("file", "more"), [("rocking", {}), ("replay", {"log": "LOG"}), ("real_rig", {}), ("two_rigs", {})]
)
def test_page_and_twin_are_launched_on_request(program, file, more, repository, tmp_path):
    import slider_drilling as sd

    if more:
        commands = sd.rocking(sd.load_rig(), 4.0, amplitude=3.0, period=4.0)
        more = {"log": str(sd.simulate(sd.load_rig(), commands, elements=20).save(tmp_path / "a.mcap"))}
    without, shown = (names(described(repository, file, **{program: asked}, **more)) for asked in ("false", "true"))
    assert shown == sorted([*without, *[program] * (2 if file == "two_rigs" else 1)])
    with pytest.raises(ValueError, match=f"{program}:=perhaps: must be true or false"):
        described(repository, file, **{program: "perhaps"}, **more)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"speed": "fast"}, "speed:=fast: must be a number"),
        ({"respawn": "maybe"}, "respawn:=maybe: must be true or false"),
        ({"discovery": "world"}, "discovery:=world: must be localhost, subnet or off"),
        ({"parameters": "no_such.yaml"}, "parameters:=no_such.yaml: cannot be read"),
    ],
)
def test_bad_launch_argument_is_named(arguments, expected, repository):
    with pytest.raises(ValueError, match=expected):
        described(repository, "rocking", **arguments)


class Launched:
    """A running `ros2 launch`."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        environment = os.environ | {
            "ROS_LOG_DIR": str(folder / "ros_log"),
            "AMENT_PREFIX_PATH": sys.prefix,
            "PYTHONUNBUFFERED": "1",
        }
        self._file = folder / "output"
        with self._file.open("wb") as file:
            self.process = subprocess.Popen(
                ["ros2", "launch", *arguments], cwd=folder, env=environment, stdout=file, stderr=subprocess.STDOUT
            )

    @property
    def output(self) -> str:
        return self._file.read_text()

    def wait_for(self, *texts: str) -> None:
        end = time.monotonic() + 120.0
        while not all(text in self.output for text in texts):
            assert time.monotonic() < end and self.process.poll() is None, (texts, self.output)
            time.sleep(0.05)

    def pids(self, program: str) -> list[int]:
        """Of the processes so called that were started, the last one last."""
        return [
            int(line.rpartition("[")[2].rstrip("]"))
            for line in self.output.splitlines()
            if f"[{program}-" in line and "process started with pid" in line
        ]

    def end(self) -> int:
        return self.process.wait(timeout=120.0)


@pytest.fixture
def run_launch(namespace, repository, tmp_path):
    """Starts launch files; what is still there at the end is ended."""
    started = []

    def start(name: str, *arguments: str) -> Launched:
        started.append(
            Launched(tmp_path, str(repository / "launch" / f"{name}.launch.py"), f"namespace:={namespace}", *arguments)
        )
        return started[-1]

    yield start
    for one in started:
        if one.process.poll() is None:
            one.process.kill()
            one.process.wait()


def is_there(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.fixture
def small(tmp_path: Path) -> str:
    """A parameter file: a coarse string, and a duration that arguments win over."""
    path = tmp_path / "small.yaml"
    path.write_text("/**/friction_simulator:\n  ros__parameters: {elements: 20, duration: 7.0, speed: 3.0}\n")
    return f"parameters:={path}"


@needs_ros2
def test_launch_arguments_override_parameter_file(run_launch, small, tmp_path):
    launched = run_launch("rocking", "duration:=11", "speed:=max", f"record:={tmp_path / 'out'}", small)
    assert launched.end() == 0, launched.output
    assert "in lockstep" in launched.output
    (path,) = (tmp_path / "out").glob("*.mcap")
    log = read_log(path)
    assert log.top_drive.time[-1] == pytest.approx(11.0)
    left = run_launch("rocking", small)
    left.wait_for("at 3 times real time")
    assert left.end() == 0, left.output


@needs_ros2
def test_launch_fails_with_node_and_restarts_no_mistake(run_launch, small):
    launched = run_launch("rocking", "controller:=no_such:Mine", small)
    assert launched.end() == 1, launched.output
    assert launched.output.count("cannot be imported") == 1
    assert "rocking_controller-2 failed: exit code 2" in launched.output


def test_simulator_does_not_wait_for_a_twin(repository):
    def waited_for(**arguments: str) -> list[object]:
        nodes = described(repository, "rocking", record="out", dashboard="true", **arguments)
        (simulator,) = [one for one in nodes if one.node_executable == "friction_simulator"]
        return list(simulator._Node__parameters[-1].values())

    assert waited_for(twin="true")[-1] == waited_for()[-1] == 3


@needs_ros2
def test_launch_goes_on_without_its_twin(run_launch, small, listener, tmp_path):
    launched = run_launch("rocking", "duration:=1e5", "speed:=5", "twin:=true", "respawn:=false", small)
    listener.until_status("twin: measurements", 0, "every channel is there")
    (pid,) = launched.pids("twin")
    os.kill(pid, signal.SIGKILL)
    launched.wait_for("twin-3 failed: exit code -9; the other nodes go on")
    listener.until_time(listener.time + 2.0)
    assert listener.heard["top_drive_command"][-1][0] > listener.time - 1.0
    launched.process.send_signal(signal.SIGINT)
    assert launched.end() == 1, "the launch tells that its twin failed"


LIMIT_FILES = """#!/bin/sh
# Files of the recorder, and of nobody else, end at a size: a full disk.
case "$*" in *__node:=recorder*) trap "" XFSZ; ulimit -f 200;; esac
exec "$@"
"""


@needs_ros2
def test_full_log_disk_leaves_the_controller_running(run_launch, small, listener, tmp_path, monkeypatch):
    """On the launch file of a real rig; the rig is a simulator beside it."""
    wrapper = tmp_path / "env"
    wrapper.write_text(LIMIT_FILES.replace("exec", f"exec {shutil.which('env')}"))
    wrapper.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    launched = run_launch("real_rig", f"record:={tmp_path / 'out'}", small)
    rig = NodeProcess("friction_simulator", listener.node.get_namespace(), tmp_path, elements=20, speed=5.0,
                      wait_for_controller=True, start_time=time.time())  # fmt: skip
    try:
        listener.until_status("recorder: log", 2, "not recording")
        launched.wait_for("failed: exit code 2; the other nodes go on")
        listener.until_time(listener.time + 5.0)
        assert listener.heard["top_drive_command"][-1][0] > listener.time - 1.0
        (pid,) = launched.pids("rocking_controller")
        assert is_there(pid)
        os.kill(pid, signal.SIGINT)
        assert launched.end() == 1, "the launch tells that its recorder failed"
        assert "recorder-2 failed: exit code 2" in launched.output
    finally:
        rig.kill()


def test_only_rig_and_controller_end_a_launch(repository, tmp_path, monkeypatch):
    """Every launch file gives every node its role."""
    import slider_drilling as sd
    from slider_drilling.nodes import launch_helpers

    commands = sd.rocking(sd.load_rig(), 4.0, amplitude=3.0, period=4.0)
    log = sd.simulate(sd.load_rig(), commands, elements=20).save(tmp_path / "a.mcap")
    roles: dict[str, set[str]] = {"required": set(), "optional": set(), "ending": set()}
    original = launch_helpers.run_together

    def note(**given):
        for role, nodes in given.items():
            roles[role] |= {node.node_executable for node in nodes}
        return original(**given)

    monkeypatch.setattr(launch_helpers, "run_together", note)
    monkeypatch.setattr("slider_drilling.nodes.simulated_rig.run_together", note)
    for name in ("rocking", "two_rigs", "real_rig", "replay", "managed"):
        if name == "managed":
            described(repository, name, twin="true")
            continue
        more = {"log": str(log)} if name == "replay" else {}
        described(repository, name, record="out", dashboard="true", twin="true", **more)
    assert roles["optional"] == {"recorder", "dashboard", "twin"}
    assert roles["required"] == {"rocking_controller", "friction_simulator"}
    assert roles["ending"] == {"friction_simulator", "log_player"}


def test_unknown_launch_argument_is_reported(repository, caplog):
    context = launch.LaunchContext()
    context.launch_configurations["tool_face_traget"] = "1"
    context.launch_configurations["target_degg"] = "1"
    spec = importlib.util.spec_from_file_location("under_test", repository / "launch" / "real_rig.launch.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    description = module.generate_launch_description()
    for one in description.entities:
        if isinstance(one, launch.actions.DeclareLaunchArgument):
            context.launch_configurations[one.name] = ""
    (made,) = [one for one in description.entities if isinstance(one, launch.actions.OpaqueFunction)]
    made.execute(context)
    said = caplog.text
    assert "argument target_degg is not known and changes nothing; did you mean target_deg?" in said
    assert "argument tool_face_traget is not known" in said


@needs_ros2
def test_launch_restarts_crashed_nodes_and_ends_on_sigterm(run_launch, small, listener, tmp_path):
    launched = run_launch("rocking", "duration:=1e5", "speed:=10", f"record:={tmp_path / 'out'}", small)
    listener.until_time(2.0)
    for program in ("rocking_controller", "recorder"):
        (pid,) = launched.pids(program)
        os.kill(pid, signal.SIGKILL)
        launched.wait_for(f"[{program}-", "process has died")
        listener.until(lambda program=program: len(launched.pids(program)) == 2, program)
    listener.statuses.clear()
    listener.until_status("recorder: log", 0, "recording")
    listener.until_status("friction_simulator: commands", 0, "every sample is answered")
    nodes = [launched.pids(program)[-1] for program in ("friction_simulator", "rocking_controller", "recorder")]
    assert all(map(is_there, nodes))
    launched.process.send_signal(signal.SIGTERM)
    assert launched.end() != 0
    listener.until(lambda: not any(map(is_there, nodes)), "nodes outlive their launch")
    logs = sorted((tmp_path / "out").rglob("*.mcap"))
    assert len(logs) == 2
    assert "does not end as an MCAP file" not in " ".join(read_log(logs[1]).notes)


@needs_ros2
def test_interrupted_launch_ends_all_nodes_without_traceback(run_launch, small, tmp_path):
    launched = run_launch("rocking", "speed:=10", f"record:={tmp_path / 'out'}", small)
    launched.wait_for("[recorder-3]: process started")
    pids = [launched.pids(program)[0] for program in ("friction_simulator", "rocking_controller", "recorder")]
    for pid in pids:
        os.kill(pid, signal.SIGINT)
    launched.process.send_signal(signal.SIGINT)
    assert launched.end() == 0, launched.output
    assert "Traceback" not in launched.output and "has died" not in launched.output
