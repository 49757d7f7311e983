"""Bytes written by hand against mcap_ros2's codec, an independent one."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from slider_drilling.errors import InputError
from slider_drilling.messages import cdr
from slider_drilling.messages.decoder import TopicDecoder
from slider_drilling.messages.message_types import MESSAGE_TYPES
from slider_drilling.messages.topics import DIAGNOSTIC_ARRAY, FLUID_PRESSURE, JOINT_STATE, TOPICS, WRENCH_STAMPED

STAMPS = st.integers(0, 2**31 * 10**9 - 1)
VALUES = st.none() | st.floats(allow_nan=False)


def decoded(kind, data):
    schema = Schema(id=1, name=kind, encoding="ros2msg", data=MESSAGE_TYPES[kind].definition.encode())
    return DecoderFactory().decoder_for("cdr", schema)(data)


def stamp_ns(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


@given(STAMPS, st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=12), VALUES, VALUES, VALUES)
def test_joint_state_agrees_with_mcap_ros2(stamp, name, position, velocity, effort):
    message = decoded(JOINT_STATE, cdr.encode_joint_state(stamp, name, position, velocity, effort))
    assert stamp_ns(message) == stamp
    assert message.name == [name]
    assert [list(message.position), list(message.velocity), list(message.effort)] == [
        [] if value is None else [value] for value in (position, velocity, effort)
    ]


@given(STAMPS, VALUES, VALUES, VALUES)
def test_joint_state_comes_back(stamp, position, velocity, effort):
    values = (position, velocity, effort)
    data = cdr.encode_joint_state(stamp, "top_drive", *values)
    read = cdr.decode_joint_state(data, "top_drive")
    assert read[0] == stamp == cdr.header_stamp_ns(data)
    for value, back in zip(values, read[1:], strict=True):
        assert math.isnan(back) if value is None else back == value


def test_named_joint_is_read_among_several():
    """Big-endian, with a frame and two joints, as no encoder here writes it."""
    data = (b"\x00\x00\x00\x00" + struct.pack(">iII8s", 5, 7, 8, b"rig_a77\0")
            + struct.pack(">II4sI10s2xI", 2, 4, b"saw\0", 10, b"top_drive\0", 2) + struct.pack(">4x2d", 1.0, 2.0)
            + struct.pack(">II", 0, 2) + struct.pack(">2d", 3.0, 4.0))
    stamp, position, velocity, effort = cdr.decode_joint_state(data, "top_drive")
    assert (stamp, position, effort) == (5_000_000_007, 2.0, 4.0)
    assert math.isnan(velocity)
    with pytest.raises(InputError, match="saw, top_drive, none named block"):
        cdr.decode_joint_state(data, "block")


def test_messages_have_the_rig_frame_or_none():
    framed = cdr.encode_joint_state(1_500_000_000, "top_drive", 1.0, 2.0, 3.0)
    assert decoded(JOINT_STATE, framed).header.frame_id == cdr.FRAME_ID
    assert decoded(FLUID_PRESSURE, cdr.encode_fluid_pressure(0, 1.0, 2.0)).header.frame_id == cdr.FRAME_ID
    assert decoded(WRENCH_STAMPED, cdr.encode_wrench_stamped(0, (1.0, 2.0, 3.0))).header.frame_id == cdr.FRAME_ID
    assert decoded(DIAGNOSTIC_ARRAY, cdr.encode_diagnostic_array(0, [])).header.frame_id == cdr.FRAME_ID
    empty = framed[:12] + b"\x01\0\0\0\0\0\0\0" + framed[28:]
    assert decoded(JOINT_STATE, empty).header.frame_id == ""
    assert cdr.decode_joint_state(empty, "top_drive") == cdr.decode_joint_state(framed, "top_drive")


@given(STAMPS, st.floats(allow_nan=False), st.floats(allow_nan=False))
def test_fluid_pressure(stamp, pressure, variance):
    data = cdr.encode_fluid_pressure(stamp, pressure, variance)
    message = decoded(FLUID_PRESSURE, data)
    assert (stamp_ns(message), message.fluid_pressure, message.variance) == (stamp, pressure, variance)
    assert TopicDecoder(TOPICS["standpipe_pressure"]).decode_one(data) == (stamp, (pressure, variance))


def test_wrench_stamped():
    message = decoded(WRENCH_STAMPED, cdr.encode_wrench_stamped(1_500_000_000, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)))
    assert stamp_ns(message) == 1_500_000_000
    assert (message.wrench.force.x, message.wrench.force.z, message.wrench.torque.y) == (1.0, 3.0, 5.0)


def test_diagnostic_array():
    status = [(1, "node: part", "it is late", "", [("by_s", "0.5"), ("", "odd")]), (0, "x", "", "rig", [])]
    message = decoded(DIAGNOSTIC_ARRAY, cdr.encode_diagnostic_array(3, status))
    assert stamp_ns(message) == 3
    assert [(one.level, one.name, one.message, one.hardware_id, [(v.key, v.value) for v in one.values])
            for one in message.status] == status


@pytest.mark.parametrize("cut", range(0, 92, 3))
def test_broken_messages_are_refused(cut):
    data = cdr.encode_joint_state(0, "top_drive", 1.0, 2.0, 3.0)
    assert len(data) == 92
    with pytest.raises(InputError):
        cdr.decode_joint_state(data[:cut], "top_drive")
    if cut < 12:
        with pytest.raises(InputError):
            cdr.header_stamp_ns(data[:cut])


def test_length_beyond_the_message_is_refused():
    data = bytearray(cdr.encode_joint_state(0, "top_drive", 1.0))
    data[32:36] = b"\xff\xff\xff\x7f"
    with pytest.raises(InputError, match="no JointState"):
        cdr.decode_joint_state(bytes(data), "top_drive")
