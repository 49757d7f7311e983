"""The recorder counts what it lost, and nothing else: publishers that come late or again, clocks, a full disk."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from node_process import DEADLINE
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from recorder_bench import LATCHED
from std_msgs.msg import String

from slider_drilling.log import read_log
from slider_drilling.log.info import log_info
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.message_sequence import SequenceCounter
from slider_drilling.nodes.spin import drain

DRIVE = TOPICS["top_drive"]


def test_lost_messages_are_counted(bench, tmp_path):
    one = bench(directory=str(tmp_path))
    publisher = raw_topics.publisher(one.node, DRIVE, QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT))
    one.send(publisher, range(1))
    sent = 1
    while one.recorder.lost == 0 and sent < 60_000:
        for value in range(sent, sent + 3000):
            publisher.publish(cdr.encode_joint_state(value * 10**6, "top_drive", float(value), 0.0, 0.0))
        sent += 3000
        drain(one.executor, lambda: one.recorder.messages)
    one.send(publisher, range(sent, sent + 1))
    sent += 1
    one.end()
    position = read_log(tmp_path).top_drive.position
    assert position[-1] == sent - 1
    assert one.recorder.lost == sent - len(position) > 0


def test_clock_topic_is_recorded_under_wall_time(bench, tmp_path):
    one = bench(directory=str(tmp_path))
    clock = raw_topics.publisher(one.node, raw_topics.CLOCK)
    drive = raw_topics.publisher(one.node, DRIVE)
    one.turn(lambda: one.recorder.publisher_count("/clock") > 0)
    for seconds in range(3):
        clock.publish(cdr.encode_clock(seconds * 10**9))
        one.send(drive, range(seconds, seconds + 1))
    one.end()
    info = log_info(tmp_path)
    assert {"/clock": 3, "/top_drive/joint_states": 3}.items() <= {t.topic: t.messages for t in info.topics}.items()
    assert info.seconds < 1000.0 and info.start_ns > 10**18


@pytest.mark.parametrize("begins", [5000, None], ids=["a clock comes", "none does"])
def test_early_messages_get_the_first_time(begins, bench, tmp_path):
    one = bench(directory=str(tmp_path), use_sim_time=True)
    clock = raw_topics.publisher(one.node, raw_topics.CLOCK)
    described = one.node.create_publisher(String, "rig_description", LATCHED)
    described.publish(String(data="schema: x"))
    one.turn(lambda: one.recorder._has_rig and one.recorder.publisher_count("/clock") > 0)
    if begins is not None:
        clock.publish(cdr.encode_clock(begins * 10**9))
        one.turn(lambda: one.recorder._simulated_ns is not None)
    one.end()
    info = log_info(tmp_path)
    assert {t.topic: t.messages for t in info.topics}.get("/rig_description") == 1
    assert (info.start_ns, info.seconds) == ((begins or 0) * 10**9, 0.0)


@pytest.mark.parametrize(
    ("numbers", "publishers", "lost"),
    [
        ([5, 6, 7], 1, 0),
        ([5, 7, 8, 12], 1, 4),
        ([100, 1, 101, 2, 102, 5, 103], 2, 2),
        ([9, 10, 1, 2, 3], 2, 0),
        ([5, 6, 52, 7, 53, 54, 8], 2, 0),
        ([5, 6, 52, 55, 7], 2, 2),
        ([500, 1001, 501, 7, 1002, 8], 3, 0),
        ([3, 4, 10], 0, 5),  # not in the graph any more
    ],
)
def test_sequence_counter_follows_each_publisher(numbers, publishers, lost):
    watch = SequenceCounter(lambda: {bytes([number]) for number in range(publishers)})
    assert sum(watch.count_missing(number) for number in numbers) == watch.lost == lost


@pytest.mark.parametrize("heads", [(46, 121), (121, 46), (300, 301)])
def test_recorder_started_late_counts_no_losses(heads, bench, tmp_path):
    """Several publishers of one topic, each of which has sent before the recorder came."""
    rig = Node("late_rig")
    publishers = [raw_topics.publisher(rig, DRIVE) for _ in heads]
    value = 0
    for publisher, count in zip(publishers, heads, strict=True):
        for _ in range(count):
            publisher.publish(cdr.encode_joint_state(value * 10**8, "top_drive", float(value), 0.0, 0.0))
            value += 1
    one = bench(directory=str(tmp_path))
    one.turn(lambda: one.recorder.publisher_count("/top_drive/joint_states") == len(heads))
    for _ in range(3):
        for publisher in publishers:
            one.send(publisher, range(value, value + 1))
            value += 1
    assert one.recorder.lost == 0
    one.end()
    rig.destroy_node()
    assert len(read_log(tmp_path).top_drive.position) == 3 * len(heads)


def test_full_disk_keeps_recording_and_ends_process(namespace, tmp_path):
    code = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000));"
        "from slider_drilling.nodes.programs import recorder; recorder()"
    )
    process = subprocess.Popen(
        [
            sys.executable,
            "-Bc",
            code,
            "--ros-args",
            "-r",
            f"__ns:={namespace}",
            "-p",
            f"directory:={tmp_path}",
            "-p",
            "file:=run.mcap",
        ],
        env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])},
        stderr=subprocess.PIPE,
        text=True,
    )
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = Node("rig", namespace=namespace)
        publisher = raw_topics.publisher(node, DRIVE)
        value, end = 0, time.monotonic() + DEADLINE
        while process.poll() is None and time.monotonic() < end:
            if publisher.get_subscription_count():
                publisher.publish(cdr.encode_joint_state(value * 10**8, "top_drive", float(value), float(value), 0.0))
                value += 1
            time.sleep(0.001)
    finally:
        rclpy.try_shutdown()
        process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30.0)
    assert process.returncode == 2, said
    found = re.search(r"run\.mcap: cannot write this log: File too large; (\d+) messages over [\d.]+ s are safe", said)
    assert found and "Traceback" not in said, said
    log = read_log(tmp_path / "run.mcap")
    assert not any("break" in note for note in log.notes)
    assert 300 < len(log.top_drive.time) <= int(found[1])
