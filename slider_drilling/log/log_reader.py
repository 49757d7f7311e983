"""What readers of log files have in common: messages in blocks, the channels they belong to, and what was lost."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema

from slider_drilling.errors import InputError
from slider_drilling.log.mcap_chunk import MessageBlock, iterate_messages


@dataclass
class LogReader(ABC):
    """One file of a log. Its attributes are filled while its messages are read.

    Attributes:
        path: The file.
        schemas: By id. Ids are unique over all logs that the file holds one after another.
        channels: By id, unique likewise; the lower 16 bits are the id in the file.
        attachments: Those that are whole.
        metadata: Metadata records.
        notes: What is damaged or lost, one sentence each.
        chunks_out_of_order: Whether chunks are not where the index says.
        profile: Of the file: `ros2`, `ros1`, or another one.
        is_part: Whether other files belong to the log, so that one that cannot be read is noted and skipped.
        is_skipped: Whether that happened.
    """

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    attachments: list[Attachment] = field(default_factory=list)
    metadata: list[Metadata] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    chunks_out_of_order: bool = False
    profile: str = "ros2"
    is_part: bool = False
    is_skipped: bool = False

    def blocks(self) -> Iterator[MessageBlock]:
        """Messages in blocks, in the order of the file.

        Raises:
            InputError: It cannot be read, and is the only file of the log.
        """
        try:
            yield from self.read_blocks()
        except InputError as error:
            if not self.is_part:
                raise
            self.is_skipped = True
            self.notes.append(f"skipped: {str(error).removeprefix(f'{self.path}: ')}")

    @abstractmethod
    def read_blocks(self) -> Iterator[MessageBlock]:
        """Messages in blocks, in the order of the file. Raises InputError where it cannot be read."""

    def messages(self) -> Iterator[tuple[Channel, Message]]:
        """Every message in the order of the file. Raises InputError where it cannot be read."""
        for block in self.blocks():
            for channel, sequence, logged, published, data in iterate_messages(block):
                yield self.channels[channel], Message(
                    channel_id=channel, sequence=sequence, log_time=logged, publish_time=published, data=data
                )

    def type_of(self, channel: Channel) -> str | None:
        """Name of a channel's message type; None where the file does not say."""
        schema = self.schemas.get(channel.schema_id)
        return None if schema is None else schema.name
