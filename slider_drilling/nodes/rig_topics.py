"""One sample of the virtual rig on its topics."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from rclpy.publisher import Publisher

from slider_drilling.control.interface import Measurements
from slider_drilling.drillstring.virtual_rig import GroundTruth
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics

NAMES = (
    "mwd_tool_face",
    "truth_bit",
    "truth_weight_on_bit",
    "truth_depth",
    "standpipe_pressure",
    "mud_pump",
    "draw_works",
    "top_drive",
)


class RigPublishers:
    """Publishes /clock and the rig's channels, the top drive's last: it is the one that controllers act on.

    pressure_variance: Pa2. The last sample is kept, for a controller that came too late to hear it.
    """

    def __init__(self, node: Node, pressure_variance: float) -> None:
        self._variance = pressure_variance
        self._clock = raw_topics.publisher(node, raw_topics.CLOCK)
        self._publishers = {name: raw_topics.publisher(node, TOPICS[name]) for name in NAMES}
        self._last: list[tuple[Publisher, bytes]] = []

    @property
    def subscription_count(self) -> int:
        """Subscriptions to the top drive's readings."""
        return int(self._publishers["top_drive"].get_subscription_count())

    def publish(
        self,
        start_ns: int,
        stamp_ns: int,
        measurements: Measurements,
        truth: GroundTruth,
        before_the_beat: Callable[[], None],
    ) -> None:
        """start_ns: the stamp of the rig's time 0; before_the_beat is called before the top drive's reading goes."""
        m, out = measurements, self._publishers
        messages = [(self._clock, cdr.encode_clock(stamp_ns))]
        messages += [
            (
                out["mwd_tool_face"],
                cdr.encode_joint_state(start_ns + round(one.measured_at * 1e9), "tool_face", one.tool_face),
            )
            for one in m.mwd
        ]
        self._last = [
            *messages,
            (
                out["truth_bit"],
                cdr.encode_joint_state(stamp_ns, "bit", truth.tool_face, truth.tool_face_rate, truth.bit_torque),
            ),
            (out["truth_weight_on_bit"], cdr.encode_wrench_stamped(stamp_ns, (truth.weight_on_bit, 0.0, 0.0))),
            (out["truth_depth"], cdr.encode_joint_state(stamp_ns, "bit", truth.bit_depth, truth.rate_of_penetration)),
            (out["standpipe_pressure"], cdr.encode_fluid_pressure(stamp_ns, m.standpipe_pressure, self._variance)),
            (out["mud_pump"], cdr.encode_joint_state(stamp_ns, "mud_pump", None, m.pump_speed)),
            (
                out["draw_works"],
                cdr.encode_joint_state(stamp_ns, "block", m.block_position, m.block_speed, m.hook_load),
            ),
            (
                out["top_drive"],
                cdr.encode_joint_state(stamp_ns, "top_drive", m.top_drive_angle, m.top_drive_speed, m.surface_torque),
            ),
        ]
        for publisher, data in self._last[:-1]:
            publisher.publish(data)
        before_the_beat()
        publisher, data = self._last[-1]
        publisher.publish(data)

    def resend(self) -> None:
        """The last sample once more."""
        for publisher, data in self._last:
            publisher.publish(data)
