"""Takes what a twin publishes into the state of the live page."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from sensor_msgs.msg import JointState
from std_msgs.msg import String

from slider_drilling.live.state import LiveState
from slider_drilling.messages.topics import GAP_DIAGNOSIS, GAP_THRESHOLD, GAP_TOPICS, TOPICS, TREND_TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.guarded import GuardedNode

# Key of the topic -> channel, and which of the message's numbers is its; the top drive's is published last.
_EXPECTED = {
    "expected_standpipe_pressure": ("standpipe_pressure", 0),
    "expected_draw_works": ("hook_load", 2),
    "expected_mwd_tool_face": ("tool_face", 0),
    "expected_top_drive": ("surface_torque", 2),
}


def subscribe_to_twin(node: GuardedNode, state: LiveState) -> None:
    """Subscribe a node to all that a twin publishes."""
    for key, (channel, number) in _EXPECTED.items():
        topic = TOPICS[key]
        take = partial(_take_expected, state, channel, number)
        raw_topics.subscription(node, topic, raw_topics.decoding(node, topic, take))
    for seconds, topic in GAP_TOPICS.items():
        _subscribe_numbers(node, topic, partial(_take_gaps, state, seconds))
    _subscribe_numbers(node, GAP_THRESHOLD, lambda _, thresholds: state.twin.set_thresholds(thresholds))
    for bound, topic in TREND_TOPICS.items():
        _subscribe_numbers(node, topic, partial(state.twin.set_trends, bound))
    node.create_subscription(
        String, GAP_DIAGNOSIS.name, lambda message: state.twin.set_diagnosis(message.data), raw_topics.LATCHED_WORDS
    )


def _take_expected(state: LiveState, channel: str, number: int, stamp_ns: int, *numbers: float) -> None:
    at = stamp_ns / 1e9
    state.twin.set_expected(channel, at, numbers[number])
    if channel == "surface_torque":
        state.twin.finish_expected(at, state.circulation_at(at))


def _take_gaps(state: LiveState, seconds: int, at: float, gaps: dict[str, float]) -> None:
    state.twin.set_gaps(seconds, gaps)


def _subscribe_numbers(node: GuardedNode, topic: Topic, use: Callable[[float, dict[str, float]], None]) -> None:
    """Call `use` with the stamp, s, and the position of each name of a JointState."""

    def take(message: JointState) -> None:
        stamp = message.header.stamp
        use(stamp.sec + stamp.nanosec / 1e9, dict(zip(message.name, message.position, strict=True)))

    node.create_subscription(JointState, topic.name, take, raw_topics.RELIABLE)
