"""Subscribes to topics as they appear, each with the quality of service its publishers offer, and counts losses."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from slider_drilling.errors import InputError
from slider_drilling.log.bag import RecordedTopic
from slider_drilling.messages.topics import Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.message_definitions import message_definition, qos_as_metadata
from slider_drilling.nodes.message_sequence import SequenceCounter
from slider_drilling.nodes.raw_topics import publisher_ids


@dataclass(frozen=True)
class ReceivedMessage:
    """One message.

    Attributes:
        topic: Its full name.
        data: The bytes as they came.
        number: Counts the topic's messages, lost ones included.
        topic_info: What the topic is, with its first message; None with the others.
    """

    topic: str
    data: bytes
    number: int
    topic_info: RecordedTopic | None


class TopicFilter:
    """Which topics to subscribe to beside the expected ones.

    Args:
        topics: Names of topics to take.
        regex: Take topics whose full name matches; "" for none.
        everything: Take all topics.
        exclude: Leave out topics whose full name matches, whatever else holds; "" for none.

    Raises:
        InputError: `regex` or `exclude` is not a regular expression.
    """

    def __init__(self, topics: tuple[str, ...], regex: str, everything: bool, exclude: str) -> None:
        self.named = tuple(name for name in topics if name)
        self._everything = everything
        self._regex, self._exclude = _compiled("regex", regex), _compiled("exclude", exclude)

    def is_excluded(self, topic: str) -> bool:
        """Whether to leave a topic out, whatever else holds."""
        return self._exclude is not None and self._exclude.fullmatch(topic) is not None

    def accepts(self, topic: str, named: set[str]) -> bool:
        """Whether to take a topic that appeared; named: resolved names of `self.named`."""
        fits = self._everything or topic in named or (self._regex is not None and bool(self._regex.fullmatch(topic)))
        return fits and not self.is_excluded(topic)


def _compiled(name: str, expression: str) -> re.Pattern[str] | None:
    try:
        return re.compile(expression) if expression else None
    except re.error as error:
        raise InputError(
            f"recorder: parameter {name} = {expression!r}: not a regular expression: {error}"
        ) from None


@dataclass
class SubscribedTopic:
    """A topic with a subscription.

    Attributes:
        kind: Its type as `package/msg/Name`.
        subscription: The present one; another replaces it if publishers offer less.
        sequence: Counts the messages that never came.
        received: Count of the topic's messages, lost ones included.
        described: Whether a message with its `topic_info` has been passed on.
    """

    kind: str
    subscription: Subscription
    sequence: SequenceCounter
    received: int = 0
    described: bool = False


class TopicSubscriptions:
    """The subscriptions of a recording node; `discover`, called now and then, adds topics as they appear.

    Args:
        node: Makes the subscriptions.
        topic_filter: Which topics to take beside those of `subscribe`.
        receive: Called with every message.
    """

    def __init__(self, node: Node, topic_filter: TopicFilter, receive: Callable[[ReceivedMessage], None]) -> None:
        self._node = node
        self._filter = topic_filter
        self._named = {node.resolve_topic_name(name) for name in topic_filter.named}
        self._receive = receive
        self._topics: dict[str, SubscribedTopic] = {}
        self._refused: set[str] = set()

    @property
    def lost(self) -> int:
        """Count of the messages of all topics that never came."""
        return sum(topic.sequence.lost for topic in self._topics.values())

    def lost_by_topic(self) -> dict[str, int]:
        """Count of the messages that never came, for each topic with any."""
        return {name: topic.sequence.lost for name, topic in self._topics.items() if topic.sequence.lost}

    def publisher_count(self, topic: str) -> int:
        """How many publishers the subscription to a topic has; 0 without a subscription."""
        subscribed = self._topics.get(topic)
        return subscribed.subscription.get_publisher_count() if subscribed is not None else 0

    def received(self, topic: str) -> int:
        """How many messages of a topic came, lost ones included."""
        return self._topics[topic].received if topic in self._topics else 0

    def subscribe(self, topic: Topic, quality: QoSProfile) -> None:
        """Subscribe before anybody publishes, to get the first message. Does nothing for a topic that is subscribed."""
        name = self._node.resolve_topic_name(topic.name)
        if name not in self._topics and not self._filter.is_excluded(name):
            subscription = self._make_subscription(name, topic.type, quality)
            self._topics[name] = SubscribedTopic(topic.type, subscription, self._sequence_counter(name))

    def discover(self) -> None:
        """Subscribe to topics that appeared; if a publisher offers less than a subscription asks for, ask for less."""
        for name, topic in self._topics.items():
            if topic.subscription.qos_profile.reliability == ReliabilityPolicy.RELIABLE:
                quality = self._offered_quality(name)
                if quality is not None and quality.reliability == ReliabilityPolicy.BEST_EFFORT:
                    self._node.destroy_subscription(topic.subscription)
                    topic.subscription = self._make_subscription(name, topic.kind, quality)
        for name, kinds in self._node.get_topic_names_and_types():
            if name not in self._topics and name not in self._refused and self._filter.accepts(name, self._named):
                self._add(name, kinds)

    def _add(self, name: str, kinds: list[str]) -> None:
        quality = self._offered_quality(name)
        if quality is None:
            return
        try:
            message_definition(kinds[0])
            subscription = self._make_subscription(name, kinds[0], quality)
        except (ImportError, AttributeError) as error:
            self._refused.add(name)
            self._node.get_logger().warning(f"{name} is not recorded: its type {kinds[0]} is not installed: {error}")
            return
        if len(kinds) > 1:
            self._node.get_logger().warning(f"{name} has several types: {', '.join(kinds)}; the first is recorded")
        self._topics[name] = SubscribedTopic(kinds[0], subscription, self._sequence_counter(name))

    def _sequence_counter(self, name: str) -> SequenceCounter:
        return SequenceCounter(lambda: publisher_ids(self._node, name))

    def _offered_quality(self, name: str) -> QoSProfile | None:
        """What every publisher of the topic offers; None if it has no publisher."""
        profiles = [endpoint.qos_profile for endpoint in self._node.get_publishers_info_by_topic(name)]
        if not profiles:
            return None
        is_reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in profiles)
        is_latched = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in profiles)
        return QoSProfile(
            depth=raw_topics.DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
        )

    def _make_subscription(self, name: str, kind: str, quality: QoSProfile) -> Subscription:
        def receive(*arguments: Any) -> None:
            # The events executor passes data and information as one pair, the others as two arguments.
            data, information = arguments[0] if len(arguments) == 1 else arguments
            self._on_message(name, data, information)

        # rclpy reads from the signature whether the callback wants information beside the message.
        receive.__signature__ = inspect.signature(lambda data, information: None)  # type: ignore[attr-defined]
        # `discover` adapts to a publisher that offers less; no warning is needed.
        events = SubscriptionEventCallbacks(incompatible_qos=lambda event: None)
        return self._node.create_subscription(
            raw_topics.message_class(kind), name, receive, quality, event_callbacks=events, raw=True
        )

    def _on_message(self, name: str, data: bytes, information: dict[str, Any]) -> None:
        topic = self._topics[name]
        sent = information.get("publication_sequence_number")
        if sent is not None:
            topic.received += topic.sequence.count_missing(sent)
        topic_info = None if topic.described else self._describe(name, topic.kind)
        topic.described = True
        self._receive(ReceivedMessage(name, data, topic.received, topic_info))
        topic.received += 1

    def _describe(self, name: str, kind: str) -> RecordedTopic:
        publishers = self._node.get_publishers_info_by_topic(name)
        qualities = tuple(qos_as_metadata(endpoint.qos_profile) for endpoint in publishers)
        hashes = [str(endpoint.topic_type_hash) for endpoint in publishers]
        return RecordedTopic(name, kind, message_definition(kind), qualities, hashes[0] if hashes else "")
