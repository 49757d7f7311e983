"""One simulator per domain and namespace, and sockets on the loopback interface only."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from fork_server import run_cli
from rclpy.context import Context
from rclpy.node import Node

from slider_drilling.log import read_log
from slider_drilling.nodes import environment

LOCAL = {"7F000001", "EFFF0001"}  # 127.0.0.1, and the group address of discovery, joined on the loopback


def sockets_of(process: int) -> list[str]:
    """Local addresses, hexadecimal, of every IP socket that a process holds."""
    links = [os.readlink(entry) for entry in Path(f"/proc/{process}/fd").iterdir() if entry.is_symlink()]
    held = {match[1] for link in links if (match := re.fullmatch(r"socket:\[(\d+)\]", link))}
    rows = [
        row.split()
        for table in ("udp", "tcp", "udp6", "tcp6")
        for row in Path(f"/proc/{process}/net/{table}").read_text().splitlines()[1:]
    ]
    # The kernel writes an address as it stands in memory, least byte first.
    return [row[1].partition(":")[0] for row in rows if row[9] in held]


def as_written(address: str) -> str:
    return bytes.fromhex(address)[::-1].hex().upper() if len(address) == 8 else address


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_node_listens_on_loopback_only(start, listener):
    controller = start("rocking_controller", use_sim_time=True)
    simulator = start("friction_simulator", elements=20, speed=5.0)
    listener.until_time(1.0)
    for program in (controller, simulator):
        addresses = [as_written(address) for address in sockets_of(program.process.pid)]
        assert addresses and set(addresses) <= LOCAL, addresses


PLAIN = """
import rclpy
from slider_drilling.nodes.log_player import LogPlayer
rclpy.init(args=["--ros-args", "-p", "autostart:=false"])
node = LogPlayer()
print(node.get_name())
node.destroy_node()
rclpy.shutdown()
"""


@pytest.mark.parametrize("given", [{}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}])
def test_a_node_of_a_plain_program_works_and_says_who_can_reach_it(given):
    """Without `environment.prepare`, which has set these variables in this process."""
    left_out = ("AMENT_PREFIX_PATH", "ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE")
    variables = {name: value for name, value in os.environ.items() if name not in left_out} | given
    ended = subprocess.run([sys.executable, "-c", PLAIN], env=variables, capture_output=True, text=True, timeout=120)
    assert ended.stdout.split() == ["log_player"] and ended.returncode == 0, ended.stderr
    assert ("everyone in this network can read and command the rig" in ended.stderr) == (not given)


def test_the_program_of_the_page_runs_and_stays_within_this_machine(repository, tmp_path):
    code = re.findall(r"```python\n(.*?)```", (repository / "docs/how_to/nodes.md").read_text(), re.DOTALL)[0]
    variables = {name: value for name, value in os.environ.items() if name != "ROS_AUTOMATIC_DISCOVERY_RANGE"}
    variables["PYTHONPATH"] = str(repository)
    ended = subprocess.run([sys.executable, "-c", code], env=variables, cwd=tmp_path, capture_output=True, text=True,
                           timeout=120)  # fmt: skip
    assert ended.returncode == 0 and "recording to" in ended.stderr + ended.stdout, ended.stderr
    assert "everyone in this network" not in ended.stderr


def test_more_than_four_programs_find_each_other(namespace, monkeypatch):
    variables = dict(os.environ)
    environment.restrict_to_loopback(variables)
    for name in variables.keys() - os.environ.keys() | {"ROS_AUTOMATIC_DISCOVERY_RANGE"}:
        monkeypatch.setenv(name, variables[name])
    with contextlib.ExitStack() as ending:
        nodes = []
        for number in range(8):
            context = Context()
            rclpy.init(args=[], context=context)
            ending.callback(rclpy.try_shutdown, context=context)
            nodes.append(Node(f"program_{number}", namespace=namespace, context=context))
            ending.callback(nodes[-1].destroy_node)
        wanted = {(node.get_name(), namespace) for node in nodes}
        end = time.monotonic() + 60.0
        while unknown := [
            (node.get_name(), wanted - found)
            for node in nodes
            if not wanted <= (found := set(node.get_node_names_and_namespaces()))
        ]:
            assert time.monotonic() < end, unknown
            time.sleep(0.1)


def test_second_run_is_refused_and_first_continues(namespace, wait_for_bytes, repository, tmp_path):
    arguments = ("run", "--speed", "20", "--duration", "1e6", "--elements", "20", "--record")
    first = subprocess.Popen(
        [sys.executable, "-m", "slider_drilling", *arguments, str(tmp_path / "first")],
        env=os.environ | {"PYTHONPATH": str(repository)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for_bytes(tmp_path, 20_000, first)
    done = run_cli(*arguments, tmp_path / "second", folder=tmp_path, loader="fork_loaders:load_nodes")
    assert done.returncode == 2, done.stderr
    (line,) = [line for line in done.stderr.splitlines() if line.strip() and not line.startswith("[INFO]")]
    assert line.startswith("another rig is simulated in ROS domain") and "ROS_DOMAIN_ID" in line
    assert not (tmp_path / "second").exists()
    (path,) = (tmp_path / "first").rglob("*.mcap")
    wait_for_bytes(tmp_path, path.stat().st_size + 20_000, first)
    first.send_signal(signal.SIGINT)
    _, said = first.communicate(timeout=100.0)
    assert first.returncode == 130, said
    (path,) = (tmp_path / "first").rglob("*.mcap")
    assert read_log(path).notes == ()
