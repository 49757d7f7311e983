"""Reads bags of ROS 1 (.bag) through the rosbags package."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mcap.records import Channel, Schema

from slider_drilling.errors import InputError
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.mcap_chunk import MessageBlock, block_of_rows
from slider_drilling.log.unpack_file import unpacked_file

if TYPE_CHECKING:
    from rosbags.rosbag1 import Reader

ROS1_MAGIC = b"#ROSBAG V"
_ROWS = 10_000  # read at a time


class Ros1BagReader(LogReader):
    """One bag of ROS 1. Each publisher of a topic is a channel, as the bag keeps them apart."""

    def read_blocks(self) -> Iterator[MessageBlock]:
        """Messages in blocks, in the order of their times.

        Raises:
            InputError: The package rosbags is missing, or the bag is not indexed or cannot be read.
        """
        try:
            from rosbags.rosbag1 import Reader, ReaderError
        except ImportError:
            raise InputError(
                f"{self.path}: a bag of ROS 1 needs the package rosbags; `pip install slider_drilling[bags]`"
            ) from None
        self.profile = "ros1"
        try:
            with unpacked_file(self.path, self.notes) as path, Reader(path) as reader:
                self._read_connections(reader)
                yield from self._read_messages(reader)
        except FileNotFoundError:
            raise InputError(f"{self.path}: no such log; check the path") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot read this log: {error.strerror}") from None
        except ReaderError as error:
            hint = "; `rosbag reindex` repairs it" if "index" in str(error) else ""
            raise InputError(f"{self.path}: no whole bag of ROS 1: {str(error).rstrip('.')}{hint}") from None

    def _read_connections(self, reader: Reader) -> None:
        """Fill channels and schemas."""
        for connection in reader.connections:
            number = connection.id + 1  # 0 is no schema
            self.schemas[number] = Schema(
                id=number, name=connection.msgtype, encoding="ros1msg", data=connection.msgdef.data.encode()
            )
            caller = getattr(connection.ext, "callerid", None) or ""
            self.channels[number] = Channel(
                id=number, topic=connection.topic, message_encoding="ros1", schema_id=number,
                metadata={"callerid": caller},
            )  # fmt: skip

    def _read_messages(self, reader: Reader) -> Iterator[MessageBlock]:
        """Yield the messages. Raises one of the reader's errors where the bag is damaged."""
        rows: list[tuple[int, int, bytes]] = []
        for connection, time, data in reader.messages():
            rows.append((connection.id + 1, time, data))
            if len(rows) == _ROWS:
                yield block_of_rows(rows)
                rows = []
        if rows:
            yield block_of_rows(rows)
