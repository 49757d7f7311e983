"""A node's topics as bytes in the encoding of the logs: names, quality of service, publishers and subscriptions."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from typing import Any

from ament_index_python import InvalidResourceNameError, get_resource
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from rclpy.subscription import Subscription

from slider_drilling.errors import InputError
from slider_drilling.messages.decoder import TopicDecoder
from slider_drilling.messages.topics import JOINT_STATE, Topic
from slider_drilling.nodes.guarded import guarded

# Not among the topics of a log: carries a controller's pump speed to the rig.
PUMP_COMMAND = Topic("mud_pump/command", JOINT_STATE, "mud_pump")
# Remapped into the rig's namespace by `run_node.own_clock`.
CLOCK = Topic("/clock", "rosgraph_msgs/msg/Clock")
RIG_DESCRIPTION = Topic("rig_description", "std_msgs/msg/String")

# A lost sample is a lost step in lockstep and a gap in a log.
DEPTH = 1000
RELIABLE = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Latched words that replace each other: a log must not lose those that come at once.
LATCHED_WORDS = QoSProfile(
    depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


def decoding(node: Node, topic: Topic, use: Callable[..., None]) -> Callable[[bytes], None]:
    """A callback that decodes messages of a topic; one that cannot be decoded is logged and dropped.

    Args:
        node: Logs the error.
        topic: Of a type whose numbers a log keeps.
        use: Called with the stamp, ns, and the numbers, NaN where not given.
    """
    decoder = TopicDecoder(topic)

    def receive(data: bytes) -> None:
        try:
            stamp_ns, numbers = decoder.decode_one(data)
        except InputError as error:
            node.get_logger().warning(f"{topic.name}: {error}", throttle_duration_sec=5.0)
            return
        use(stamp_ns, *numbers)

    return receive


def flush(node: Node, timeout: float = 2.0) -> None:
    """Wait up to `timeout` s until every subscriber has received what the node sent; its end discards the rest."""
    deadline = time.monotonic() + timeout
    for publisher in node.publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))


def publisher_ids(node: Node, topic: str) -> set[bytes]:
    """The GIDs of the present publishers of a topic, given by its full name."""
    return {bytes(endpoint.endpoint_gid) for endpoint in node.get_publishers_info_by_topic(topic)}


def message_class(kind: str) -> Any:
    """The class of `package/msg/Name`.

    The name may come from a log or from another node, so only installed message packages are imported: importing runs
    code.

    Raises:
        ImportError: No message of this name is installed.
    """
    package, _, name = kind.split("/")
    try:
        listed, _ = get_resource("rosidl_interfaces", package)
    except (LookupError, OSError, InvalidResourceNameError):
        listed = ""
    if f"msg/{name}.msg" not in listed.split():
        raise ImportError(f"{package} is not an installed message package with {name}")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def has_header(kind: str) -> bool:
    """Whether messages of a type start with a std_msgs/Header, which starts with the stamp."""
    return next(iter(message_class(kind).get_fields_and_field_types().values()), "") == "std_msgs/Header"


def publisher(node: Node, topic: Topic, qos: QoSProfile = RELIABLE) -> Publisher:
    """A publisher of bytes, such as `messages.cdr` encodes; `qos_overrides` parameters apply."""
    return _with_qos_overrides(
        topic,
        lambda options: node.create_publisher(
            message_class(topic.type), topic.name, _copy(qos), qos_overriding_options=options
        ),
    )


def subscription(
    node: Node,
    topic: Topic,
    receive: Callable[[bytes], None],
    events: SubscriptionEventCallbacks | None = None,
) -> Subscription:
    """A subscription whose callback gets a message's bytes; `qos_overrides` parameters apply."""
    return _with_qos_overrides(
        topic,
        lambda options: node.create_subscription(
            message_class(topic.type),
            topic.name,
            receive,
            _copy(RELIABLE),
            raw=True,
            event_callbacks=events,
            qos_overriding_options=options,
        ),
    )


def _with_qos_overrides(topic: Topic, make: Callable[[QoSOverridingOptions], Any]) -> Any:
    """Make a publisher or subscription. Raises InputError for a `qos_overrides` parameter that cannot be used."""
    try:
        return make(QoSOverridingOptions.with_default_policies())
    except (InvalidQosOverridesError, RuntimeError, InvalidParameterTypeException) as error:
        if isinstance(error, RuntimeError) and "QoS override" not in str(error):
            raise
        raise InputError(f"{topic.name}: qos_overrides: {error}") from None


class SensorSubscription:
    """A reliable subscription that becomes best-effort if a publisher is.

    DDS does not connect a reliable subscription with a best-effort publisher. A best-effort subscription, however, may
    lose messages of a reliable publisher, which costs steps in lockstep. A `qos_overrides` parameter makes it
    best-effort from the start.
    """

    def __init__(self, node: Node, topic: Topic, receive: Callable[[bytes], None]) -> None:
        self._node, self._topic, self._receive = node, topic, receive
        self._best_effort: Subscription | None = None
        events = SubscriptionEventCallbacks(incompatible_qos=guarded(node, topic.name, self._on_incompatible))
        self._reliable = subscription(node, topic, receive, events=events)

    @property
    def name(self) -> str:
        """The topic's name, relative to the namespace."""
        return self._topic.name

    def get_publisher_count(self) -> int:
        """How many publishers are connected."""
        return int((self._best_effort or self._reliable).get_publisher_count())

    def _on_incompatible(self, event: Any) -> None:
        """Replace the reliable subscription; beside it, a reliable publisher's messages would come twice."""
        if self._best_effort is not None:
            return
        self._node.get_logger().info(
            f"{self._topic.name}: the publisher is best-effort, so samples may be lost"
        )
        self._best_effort = self._node.create_subscription(
            message_class(self._topic.type), self._topic.name, self._receive, _copy(BEST_EFFORT), raw=True
        )
        self._node.destroy_subscription(self._reliable)


def entities(node: Node) -> set[Any]:
    """The publishers, subscriptions, services and timers of a node."""
    return {*node.publishers, *node.subscriptions, *node.services, *node.timers}


def destroy(node: Node, unwanted: set[Any]) -> None:
    """Destroy some of a node's entities."""
    kinds = (
        (node.publishers, node.destroy_publisher),
        (node.subscriptions, node.destroy_subscription),
        (node.services, node.destroy_service),
        (node.timers, node.destroy_timer),
    )
    for present, destroy_entity in kinds:
        for entity in unwanted.intersection(present):
            destroy_entity(entity)


def _copy(qos: QoSProfile) -> QoSProfile:
    """A copy, since rclpy writes overrides into the profile."""
    return QoSProfile(depth=qos.depth, reliability=qos.reliability, durability=qos.durability)
