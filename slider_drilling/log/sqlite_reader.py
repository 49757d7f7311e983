"""Reads the sqlite3 files of rosbag2 (.db3), which ROS 2 wrote by default before Iron."""

from __future__ import annotations

import contextlib
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

from mcap.records import Channel, Schema

from slider_drilling.errors import InputError
from slider_drilling.log.log_reader import LogReader
from slider_drilling.log.mcap_chunk import MessageBlock, block_of_rows
from slider_drilling.log.unpack_file import unpacked_file
from slider_drilling.log.unpack_messages import unpack_messages
from slider_drilling.messages.message_types import MESSAGE_TYPES
from slider_drilling.messages.topics import canonical_type

SQLITE_MAGIC = b"SQLite format 3\x00"
_ROWS = 10_000  # read at a time


class SqliteReader(LogReader):
    """One sqlite3 file of a bag."""

    def read_blocks(self) -> Iterator[MessageBlock]:
        """Messages in blocks, in the order in which they were recorded.

        Raises:
            InputError: The file cannot be read, or is no bag.
        """
        try:
            with unpacked_file(self.path, self.notes) as path, contextlib.closing(_connect(path)) as database:
                self._read_topics(database)
                yield from self._read_messages(database)
        except sqlite3.Error as error:
            raise InputError(f"{self.path}: no sqlite3 bag of rosbag2: {error}") from None
        except FileNotFoundError:
            raise InputError(f"{self.path}: no such log; check the path") from None
        except OSError as error:
            raise InputError(f"{self.path}: cannot read this log: {error.strerror}") from None

    def _read_topics(self, database: sqlite3.Connection) -> None:
        """Fill channels and schemas. Raises sqlite3.Error."""
        tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        definitions: dict[str, tuple[str, str]] = {}
        if "message_definitions" in tables:
            rows = database.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
            definitions = {kind: (encoding, text) for kind, encoding, text in rows}
        columns = {row[1] for row in database.execute("PRAGMA table_info(topics)")}
        qos = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
        rows = database.execute(f"SELECT id, name, type, serialization_format, {qos} FROM topics")
        for number, topic, kind, encoding, profiles in rows:
            known = MESSAGE_TYPES.get(canonical_type(kind))
            own = ("ros2msg", known.definition) if known is not None else ("", "")
            schema_encoding, text = definitions.get(kind, own)
            self.schemas[number] = Schema(id=number, name=kind, encoding=schema_encoding, data=text.encode())
            self.channels[number] = Channel(
                id=number, topic=topic, message_encoding=encoding, schema_id=number,
                metadata={"offered_qos_profiles": str(profiles)},
            )  # fmt: skip

    def _read_messages(self, database: sqlite3.Connection) -> Iterator[MessageBlock]:
        """Yield the messages of known topics; where the file is damaged, those before."""
        cursor = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id")
        while True:
            try:
                rows = cursor.fetchmany(_ROWS)
            except sqlite3.Error as error:
                self.notes.append(f"is damaged ({error}); read up to there")
                return
            if not rows:
                return
            known = [row for row in rows if row[0] in self.channels and isinstance(row[2], bytes)]
            if len(known) < len(rows):
                self.notes.append(f"{len(rows) - len(known)} messages of topics that are not described were left out")
            if known:
                yield unpack_messages(block_of_rows(known))


def _connect(path: Path) -> sqlite3.Connection:
    """A connection that changes nothing. Raises sqlite3.Error."""
    address = f"file:{quote(str(path.resolve()))}?mode=ro"
    connection = sqlite3.connect(address, uri=True)
    try:
        connection.execute("SELECT name FROM sqlite_master").fetchall()
    except sqlite3.OperationalError:
        # A write-ahead log cannot be opened in a folder that must not be written to.
        connection.close()
        connection = sqlite3.connect(f"{address}&immutable=1", uri=True)
    return connection
