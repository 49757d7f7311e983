"""Subscriptions to topics as they turn up, each as its publishers offer it, with what never came counted."""

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
from slider_drilling.nodes.message_sequence import SequenceWatch


@dataclass(frozen=True)
class ReceivedMessage:
    """One message. number: counts the topic's messages, lost ones too; described: what its topic is, the first time."""

    topic: str
    data: bytes
    number: int
    described: RecordedTopic | None


class TopicFilter:
    """Which topics to listen to beside those that are expected. Raises InputError for an expression that is none."""

    def __init__(self, topics: tuple[str, ...], regex: str, everything: bool, exclude: str) -> None:
        self.named = tuple(name for name in topics if name)
        self._everything = everything
        self._regex, self._exclude = _compiled("regex", regex), _compiled("exclude", exclude)

    def is_excluded(self, topic: str) -> bool:
        """Whether not to listen to it, whatever else holds."""
        return self._exclude is not None and self._exclude.fullmatch(topic) is not None

    def takes(self, topic: str, named: set[str]) -> bool:
        """Whether to listen to a topic that turned up; named: resolved names of `self.named`."""
        fits = self._everything or topic in named or (self._regex is not None and bool(self._regex.fullmatch(topic)))
        return fits and not self.is_excluded(topic)


def _compiled(name: str, expression: str) -> re.Pattern[str] | None:
    try:
        return re.compile(expression) if expression else None
    except re.error as error:
        raise InputError(f"recorder: parameter {name} = {expression!r}: no regular expression: {error}") from None


@dataclass
class SubscribedTopic:
    """A topic that is listened to. received: messages, lost ones too; described: whether its Recorded is out."""

    kind: str
    subscription: Subscription
    watch: SequenceWatch
    received: int = 0
    described: bool = False


class TopicSubscriptions:
    """The subscriptions of one node. `look_around` is to be called now and then: it finds topics and their quality."""

    def __init__(self, node: Node, wanted: TopicFilter, receive: Callable[[ReceivedMessage], None]) -> None:
        self._node = node
        self._wanted = wanted
        self._named = {node.resolve_topic_name(name) for name in wanted.named}
        self._receive = receive
        self._channels: dict[str, SubscribedTopic] = {}
        self._refused: set[str] = set()

    @property
    def lost(self) -> int:
        """Messages of all topics that never came."""
        return sum(channel.watch.lost for channel in self._channels.values())

    def losses(self) -> dict[str, int]:
        """Of each topic, where there are any."""
        return {topic: one.watch.lost for topic, one in self._channels.items() if one.watch.lost}

    def publishers_of(self, topic: str) -> int:
        """How many publishers the subscription has; 0 without a subscription."""
        channel = self._channels.get(topic)
        return channel.subscription.get_publisher_count() if channel is not None else 0

    def expect(self, topic: Topic, quality: QoSProfile) -> None:
        """Listen before anybody publishes: the first message counts. Once: another subscription would hear it twice."""
        name = self._node.resolve_topic_name(topic.name)
        if name not in self._channels and not self._wanted.is_excluded(name):
            self._channels[name] = SubscribedTopic(
                topic.type, self._subscribe(name, topic.type, quality), SequenceWatch()
            )

    def look_around(self) -> None:
        """Listen to what turned up; where a publisher offers less than a subscription asks for, ask for less."""
        for topic, channel in self._channels.items():
            if channel.subscription.qos_profile.reliability == ReliabilityPolicy.RELIABLE:
                quality = self._quality(topic)
                if quality is not None and quality.reliability == ReliabilityPolicy.BEST_EFFORT:
                    self._node.destroy_subscription(channel.subscription)
                    channel.subscription = self._subscribe(topic, channel.kind, quality)
        for topic, kinds in self._node.get_topic_names_and_types():
            if topic not in self._channels and topic not in self._refused and self._wanted.takes(topic, self._named):
                self._take(topic, kinds)

    def _take(self, topic: str, kinds: list[str]) -> None:
        quality = self._quality(topic)
        if quality is None:
            return
        try:
            message_definition(kinds[0])
            subscription = self._subscribe(topic, kinds[0], quality)
        except (ImportError, AttributeError) as error:
            self._refused.add(topic)
            self._node.get_logger().warning(f"{topic} is not recorded: its type {kinds[0]} is not installed: {error}")
            return
        if len(kinds) > 1:
            self._node.get_logger().warning(f"{topic} has several types: {', '.join(kinds)}; the first is recorded")
        self._channels[topic] = SubscribedTopic(kinds[0], subscription, SequenceWatch())

    def _quality(self, topic: str) -> QoSProfile | None:
        """What every publisher of the topic offers; None where there is none."""
        profiles = [one.qos_profile for one in self._node.get_publishers_info_by_topic(topic)]
        if not profiles:
            return None
        reliable = all(one.reliability == ReliabilityPolicy.RELIABLE for one in profiles)
        lasting = all(one.durability == DurabilityPolicy.TRANSIENT_LOCAL for one in profiles)
        return QoSProfile(
            depth=raw_topics.DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if lasting else DurabilityPolicy.VOLATILE,
        )

    def _subscribe(self, topic: str, kind: str, quality: QoSProfile) -> Subscription:
        def receive(*arguments: Any) -> None:
            # The events executor hands over data and information as one pair, the others as two arguments.
            data, information = arguments[0] if len(arguments) == 1 else arguments
            self._on_message(topic, data, information)

        # rclpy tells from the signature whether information is wanted beside the message.
        receive.__signature__ = inspect.signature(lambda data, information: None)  # type: ignore[attr-defined]
        # A publisher that cannot be heard is found, and heard, by look_around: no need for a warning at once.
        events = SubscriptionEventCallbacks(incompatible_qos=lambda event: None)
        return self._node.create_subscription(
            raw_topics.message_class(kind), topic, receive, quality, event_callbacks=events, raw=True
        )

    def _on_message(self, topic: str, data: bytes, information: dict[str, Any]) -> None:
        channel = self._channels[topic]
        sent = information.get("publication_sequence_number")
        if sent is not None:
            channel.received += channel.watch.skipped(sent)
        described = None
        if not channel.described:
            channel.described = True
            described = self._describe(topic, channel.kind)
        self._receive(ReceivedMessage(topic, data, channel.received, described))
        channel.received += 1

    def _describe(self, topic: str, kind: str) -> RecordedTopic:
        publishers = self._node.get_publishers_info_by_topic(topic)
        hashes = [str(one.topic_type_hash) for one in publishers]
        return RecordedTopic(
            topic,
            kind,
            message_definition(kind),
            tuple(qos_as_metadata(one.qos_profile) for one in publishers),
            hashes[0] if hashes else "",
        )
