"""`slider-drilling run` from end to end, and its log in other programs."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fork_server import run_cli

from slider_drilling.commands import run
from slider_drilling.log import read_log
from slider_drilling.nodes.simulator_lock import SimulatorLock

LOADER = "fork_loaders:load_nodes"


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "slider_drilling", *map(str, arguments)]


@pytest.fixture
def environment(repository: Path, alone: None) -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(repository)}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The log of a run and what the run said."""
    folder = tmp_path_factory.mktemp("run")
    arguments = ("run", "--duration", 20, "--speed", "max", "--record", folder, "--target", 45)
    done = run_cli(*arguments, folder=folder, environment=os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"},
                   loader=LOADER)  # fmt: skip
    assert done.returncode == 0, done.stderr
    (log,) = folder.glob("*.mcap")
    assert sorted(path.suffix for path in folder.iterdir()) == [".html", ".mcap", ".png", ".yaml"]
    return log, done.stdout


def test_run_prints_a_summary(recorded):
    log, said = recorded
    assert "20.0 s" in said and "times real time" in said and f"wrote {log}" in said
    peak = float(re.search(r"peak ([\d.]+) kN m", said).group(1))
    assert peak == pytest.approx(np.abs(read_log(log).top_drive.effort).max() / 1e3, abs=0.006)


def test_log_opens_in_other_programs(recorded):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory
    from rosbags.highlevel import AnyReader

    log, _ = recorded
    with AnyReader([log]) as reader:
        torque = [
            reader.deserialize(raw, connection.msgtype).effort[0]
            for connection, _, raw in reader.messages()
            if connection.topic == "/top_drive/joint_states"
        ]
    with log.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        (attachment,) = reader.iter_attachments()
        assert (attachment.name, attachment.media_type) == ("rig.yaml", "application/yaml")
        again = [
            message.effort[0] for _, _, _, message in reader.iter_decoded_messages(topics=["/top_drive/joint_states"])
        ]
        summary = reader.get_summary()
    assert torque == again == read_log(log).top_drive.effort.tolist()
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert len(torque) == 201


def test_replay_of_a_run_matches_it(recorded, tmp_path):
    log, _ = recorded
    done = run_cli("replay", log, "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    rms = {name: channel["rms"] for name, channel in json.loads(done.stdout)["channels"].items()}
    sensors = read_log(log).rig().sensors
    for name in ("surface_torque", "hook_load", "standpipe_pressure"):
        assert rms[name] == pytest.approx(getattr(sensors, name).noise, rel=0.2), name


def test_target_option_sets_the_target(recorded):
    assert np.degrees(read_log(recorded[0]).tool_face_target.position[0]) == pytest.approx(45.0)


def test_interrupted_run_keeps_its_log(environment, wait_for_bytes, tmp_path):
    arguments = command("run", "--speed", 20, "--duration", 1e6, "--elements", 20, "--record", tmp_path)
    process = subprocess.Popen(arguments, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for_bytes(tmp_path, 50_000, process)
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)
    out, said = process.communicate(timeout=100.0)
    assert process.returncode == 130, said
    assert "Traceback" not in said
    (log,) = tmp_path.glob("*.mcap")
    assert read_log(log).notes == ()
    assert f"wrote {log}" in out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--rig", "no_such.yaml"], "no_such.yaml: no such rig file"),
        (["--speed", "fast"], "'fast' is neither a number nor max"),
        (["--duration", "-1"], "--duration = -1.0: must be above 0"),
        (["--target", "nan"], "--target = nan: must be a finite number"),
        (["--record", "/dev/null/x"], "/dev/null/x: cannot make this folder for logs"),
        (["--controller", "nowhere:Mine", "--elements", "20"], "controller = 'nowhere:Mine': cannot be imported"),
    ],
)
def test_mistake_is_one_line_and_exit_code_2(arguments, expected, alone, tmp_path):
    done = run_cli("run", *arguments, folder=tmp_path, loader=LOADER)
    assert done.returncode == 2
    lines = [line for line in done.stderr.splitlines() if line.strip() and not line.startswith("[INFO]")]
    assert len(lines) == 1 and expected in lines[0], done.stderr
    assert list(tmp_path.iterdir()) == []


def test_full_disk_is_one_line(recorded, environment, tmp_path):
    code = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000));"
        "from slider_drilling.cli import main; main()"
    )
    arguments = [sys.executable, "-Bc", code, "run", "--duration", "60", "--elements", "20", "--record", str(tmp_path)]
    done = subprocess.run(arguments, env=environment, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 2, done.stderr
    # A machine with little time to spare tells of its progress.
    lines = [line for line in done.stderr.splitlines() if line.strip() and not line.startswith(("[INFO]", "sliding:"))]
    assert len(lines) == 1 and "cannot write this log: File too large" in lines[0], done.stderr
    (path,) = tmp_path.glob("*.mcap")
    log = read_log(path)
    said = re.search(r"(\d+) messages over ([\d.]+) s are safe in it", lines[0])
    assert said and log.notes == () and log.rig_text is not None
    assert log.top_drive.time[-1] == pytest.approx(float(said[2]), abs=0.15) and log.top_drive.time[-1] > 5.0


STARTING = """\
import os, signal, sys
from pathlib import Path
import click
from slider_drilling.nodes import environment
environment.prepare()
from slider_drilling import cli
from slider_drilling.process.shutdown import raise_on_signals
from slider_drilling.nodes import session

KILL = "import os, signal\\nos.kill(os.getpid(), signal.{number})\\nfor _ in range(1000): pass"

class Rig:
    def __init__(self, shutdown_request, **options):
        if sys.argv[1] == "in code that was made": exec(KILL)
    def destroy_node(self): pass

class Recorder(session.Recorder):
    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        exec(KILL)

session.FrictionSimulator, session.Recorder = Rig, Recorder

def act():
    raise_on_signals()
    session.run_session(session.SessionOptions(record=Path("out")))

cli.run_group(click.Group("g", commands={"act": click.Command("act", callback=act)}), ["act"])
"""


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("when", ["in code that was made", "while its log is opened"])
def test_interrupted_start_leaves_no_log(number, when, environment, tmp_path):
    (tmp_path / "starting.py").write_text(STARTING.replace("{number}", number))
    done = subprocess.run(
        [sys.executable, "-m", "starting", when],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 128 + signal.Signals[number], done.stderr
    assert "interrupted" in done.stderr and not list(tmp_path.rglob("*.mcap"))


def test_second_simulation_takes_a_free_domain(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setattr(run, "_FIRST_DOMAIN", 150)
    monkeypatch.setenv("ROS_DOMAIN_ID", "150")
    held = SimulatorLock("")
    monkeypatch.delenv("ROS_DOMAIN_ID")
    run._take_free_domain()
    assert os.environ["ROS_DOMAIN_ID"] == "151"
    assert "in ROS domain 150; this one runs in domain 151: `export ROS_DOMAIN_ID=151`" in capsys.readouterr().err
    held.release()
    run._take_free_domain()
    assert os.environ["ROS_DOMAIN_ID"] == "151", "a domain that is given is kept"
    monkeypatch.setenv("ROS_DOMAIN_ID", "")
