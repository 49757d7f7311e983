"""The connection to a rig's server, in a thread of its own: it reads samples, writes commands, and reconnects."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.messages.health import Level, Status
from slider_drilling.opcua.command_gate import CommandGate
from slider_drilling.opcua.mapping import Point, RigMapping
from slider_drilling.opcua.values import Heartbeat, usable_number

_RETRY = 1.0  # s between two attempts to connect
_COMMAND_CHECK = 0.01  # s between two looks for commands
_MIN_TIMEOUT = 1.0  # s that the server has for an answer
_FLOAT_MAX = 3.4e38  # of a number of 32 bits
_STOP_TIMEOUT = 5.0  # s for the last writes and the end of the connection


@dataclass(frozen=True)
class Sample:
    """One reading of the rig.

    Attributes:
        values: By name, SI units; what is not usable is missing.
        mwd_time: When the MWD toolface was measured, as the server says, UTC; None if it does not.
    """

    values: dict[str, float]
    mwd_time: datetime | None = None


@dataclass
class LinkHealth:
    """What the connection reports. The thread of the connection writes it, that of the nodes reads it.

    Attributes:
        connected: Whether the server answers.
        reason: Why it does not; empty until it first fails.
        alive: Whether the rig's heartbeat changes.
        unusable: Names whose values are not usable numbers.
        refused: Why the last command of a name could not be written, by name.
    """

    connected: bool = False
    reason: str = ""
    alive: bool = False
    unusable: tuple[str, ...] = field(default=())
    refused: dict[str, str] = field(default_factory=dict)


class ServerLink:
    """Reads everything once a period and writes what the gate gives, until `stop`.

    Args:
        mapping: Of the rig.
        gate: Gives the commands; None to write nothing.
        use_sample: Called with each sample of a living rig, in the link's thread.
        fail: Called with the error that makes the link give up, in the link's thread.

    Raises:
        InputError: asyncua is not installed, or a node id, the password file or the security setting cannot be used.
    """

    def __init__(
        self,
        mapping: RigMapping,
        gate: CommandGate | None,
        use_sample: Callable[[Sample], None],
        fail: Callable[[InputError], None],
    ) -> None:
        try:
            import asyncua
        except ImportError:
            raise InputError("the OPC UA bridge needs asyncua: `pip install 'slider_drilling[bridge]'`") from None
        if gate is not None and not mapping.heartbeat:
            raise InputError(f"{mapping.url}: heartbeat: missing; without one, commands would go to a dead rig, too")
        self.health = LinkHealth()
        self._asyncua = asyncua
        self._mapping, self._gate, self._use_sample, self._fail = mapping, gate, use_sample, fail
        self._password = read_text(mapping.password_file, "password file").strip() if mapping.password_file else ""
        written = mapping.write if gate is not None else {}
        self._ids = {name: self._node_id(f"read.{name}", point.node) for name, point in mapping.read.items()}
        self._write_ids = {name: self._node_id(f"write.{name}", point.node) for name, point in written.items()}
        self._heartbeat_id = self._node_id("heartbeat", mapping.heartbeat) if mapping.heartbeat else None
        self._was_connected = False
        self._measured: dict[str, float] = {}
        self._loop = asyncio.new_event_loop()
        self._stopping = asyncio.Event()
        for name in ("asyncua", "asyncua.client", "asyncua.common"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # the link says itself what went wrong
        self._thread = threading.Thread(target=self._run, name="opcua link")
        self._thread.start()

    def stop(self) -> None:
        """Stop the rig's drives as far as this link commanded them, and end the connection."""
        if self._thread.is_alive():
            with contextlib.suppress(RuntimeError):  # the loop has ended meanwhile
                self._loop.call_soon_threadsafe(self._stopping.set)
        self._thread.join()

    def statuses(self) -> list[Status]:
        """The health of server, rig and values."""
        health, url = self.health, self._mapping.url
        if not health.connected and not health.reason:
            return [Status(Level.WARN, "server", f"{url}: connecting")]
        if not health.connected:
            return [Status(Level.ERROR, "server", f"{url}: {health.reason}; trying again")]
        server = Status(Level.OK, "server", f"connected to {url}")
        if self._heartbeat_id is None:
            beat = Status(Level.WARN, "heartbeat", "none in the mapping: a dead rig looks alive")
        elif health.alive:
            beat = Status(Level.OK, "heartbeat", "changes")
        else:
            beat = Status(Level.ERROR, "heartbeat", "stands still: nothing is published, no command is written")
        names = ", ".join(health.unusable)
        values = Status(Level.WARN, "values", f"not usable: {names}") if names else Status(Level.OK, "values", "usable")
        return [server, beat, values]

    def _node_id(self, key: str, text: str) -> Any:
        try:
            return self._asyncua.ua.NodeId.from_string(text)
        except Exception as error:  # asyncua raises several kinds
            raise InputError(f"{key}: node = {text!r}: not a node id such as ns=2;s=Name: {error}") from None

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._connect_again_and_again())
        except InputError as error:
            self._fail(error)
        except Exception as error:
            self._fail(InputError(f"{self._mapping.url}: {type(error).__name__}: {_one_line(error)}"))
        finally:
            self._loop.close()

    async def _connect_again_and_again(self) -> None:
        ua = self._asyncua.ua
        while not self._stopping.is_set():
            try:
                await self._session()
            # A connection that breaks cancels the requests that wait for an answer.
            except (OSError, ua.UaError, asyncio.TimeoutError, asyncio.CancelledError) as error:
                self.health = LinkHealth(reason=f"{type(error).__name__} {_one_line(error)}".strip())
                if self._gate is not None:
                    self._gate.drop()
                with contextlib.suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(self._stopping.wait(), _RETRY)

    async def _session(self) -> None:
        """One connection, until it breaks or the link is stopped."""
        mapping = self._mapping
        client = self._asyncua.Client(mapping.url, timeout=max(_MIN_TIMEOUT, 2.0 * mapping.period))
        if mapping.user:
            client.set_user(mapping.user)
            client.set_password(self._password)
        if mapping.security:
            await self._set_security(client, mapping.security)
        async with client:
            types = await self._check_nodes(client)
            self._was_connected = True
            self.health = LinkHealth(connected=True)
            try:
                await self._exchange(client, types)
            finally:
                if self._gate is not None:
                    await asyncio.wait_for(self._write_stop(client, types, self._gate.commanding), _STOP_TIMEOUT)

    async def _set_security(self, client: Any, security: str) -> None:
        for file in security.split(",")[2:]:
            if not Path(file).is_file():
                raise InputError(f"security: {file}: no such file")
        try:
            await client.set_security_string(security)
        except (ValueError, OSError, AttributeError, self._asyncua.ua.UaError) as error:
            raise InputError(f"security = {security!r}: {_one_line(error)}") from None

    async def _check_nodes(self, client: Any) -> dict[str, Any]:
        """The data types of the nodes that commands are written to.

        Raises:
            InputError: A node is missing or takes no numbers, at the first connection.
        """
        ua = self._asyncua.ua
        given = {f"read.{name}": node for name, node in self._ids.items()}
        given |= {f"write.{name}": node for name, node in self._write_ids.items()}
        given |= {} if self._heartbeat_id is None else {"heartbeat": self._heartbeat_id}
        nodes = [client.get_node(one) for one in given.values()]
        found = await client.read_attributes(nodes, ua.AttributeIds.NodeClass)
        for (key, node), value in zip(given.items(), found, strict=True):
            if not value.StatusCode.is_good():
                self._refuse(f"{key}: the server has no node {node.to_string()}: {value.StatusCode.name}")
        types = {}
        for name, node in self._write_ids.items():
            types[name] = await client.get_node(node).read_data_type_as_variant_type()
            if types[name] not in _number_types(ua):
                self._refuse(f"write.{name}: node {node.to_string()} takes {types[name].name}, not numbers")
        return types

    def _refuse(self, reason: str) -> None:
        """The mapping is wrong; of a server that has been in use, the server is, and it may mend."""
        if self._was_connected:
            raise self._asyncua.ua.UaError(reason)
        raise InputError(f"{self._mapping.url}: {reason}")

    async def _exchange(self, client: Any, types: dict[str, Any]) -> None:
        """Read everything once a period, write what came meanwhile."""
        ua, period = self._asyncua.ua, self._mapping.period
        heartbeat = None if self._heartbeat_id is None else Heartbeat(self._mapping.heartbeat_timeout)
        nodes = [client.get_node(one) for one in (*self._ids.values(), self._heartbeat_id) if one is not None]
        due = self._loop.time()
        while not self._stopping.is_set():
            found = await client.read_attributes(nodes, ua.AttributeIds.Value)
            self.health.alive = heartbeat is None or heartbeat.update(found[len(self._ids)], time.monotonic())
            self._use(dict(zip(self._ids, found, strict=False)))
            await self._stop_what_ended(client, types)
            due = max(due + period, self._loop.time())
            while not self._stopping.is_set() and self._loop.time() < due:
                await self._write_commands(client, types)
                await asyncio.sleep(min(_COMMAND_CHECK, period))

    def _use(self, found: dict[str, Any]) -> None:
        numbers = {name: usable_number(value) for name, value in found.items()}
        usable = {name: one * self._mapping.read[name].factor for name, one in numbers.items() if one is not None}
        mwd = found.get("mwd_tool_face")
        mwd_time = None if mwd is None else mwd.SourceTimestamp
        missing = [name for name, one in numbers.items() if one is None]
        if mwd is not None and mwd_time is None and "mwd_tool_face" in usable:
            missing.append("mwd_tool_face has no source time")
        self.health.unusable = tuple(missing)
        self._measured = usable if self.health.alive else {}
        if self.health.alive:
            self._use_sample(Sample(usable, mwd_time))

    async def _write_commands(self, client: Any, types: dict[str, Any]) -> None:
        if self._gate is None:
            return
        if self.health.alive:
            await self._write(client, types, self._gate.take(time.monotonic()))
        else:
            self._gate.drop()

    async def _stop_what_ended(self, client: Any, types: dict[str, Any]) -> None:
        """Stop what is no longer commanded; all of a rig that has died, which would find it when it comes back."""
        if self._gate is not None:
            alive = self.health.alive
            await self._write_stop(
                client, types, self._gate.silent(time.monotonic()) if alive else self._gate.commanding
            )

    async def _write_stop(self, client: Any, types: dict[str, Any], names: list[str]) -> None:
        if self._gate is not None and names:
            stops = self._gate.stop_values(names, self._measured)
            refused = await self._write(client, types, stops)
            self._gate.end(name for name in names if name not in refused and self._gate.is_stopped(name, stops))

    async def _write(self, client: Any, types: dict[str, Any], commands: dict[str, float]) -> set[str]:
        """Write commands, SI units; the others are written if the server refuses one. Returns the refused."""
        ua, refused = self._asyncua.ua, {}
        for name, value in commands.items():
            number = value / self._point(name).factor
            if not _fits(number, types[name].name):
                refused[name] = f"{number:g} does not fit {types[name].name}"
                continue
            try:
                variant = _variant(ua, number, types[name])
                await client.get_node(self._write_ids[name]).write_value(ua.DataValue(variant))
            except ua.UaStatusCodeError as error:
                refused[name] = _one_line(error)
        kept = {name: reason for name, reason in self.health.refused.items() if name not in commands}
        self.health.refused = kept | refused
        return set(refused)

    def _point(self, name: str) -> Point:
        return self._mapping.write[name]


def _number_types(ua: Any) -> tuple[Any, ...]:
    kinds = ("Double", "Float", "Int16", "Int32", "Int64", "UInt16", "UInt32", "UInt64")
    return tuple(getattr(ua.VariantType, kind) for kind in kinds)


def _fits(number: float, kind: str) -> bool:
    """Whether a node of a data type such as Int16 can hold a number."""
    if "Int" not in kind:
        return kind == "Double" or abs(number) <= _FLOAT_MAX
    bits = int(kind.rpartition("Int")[2])
    low, high = (0, 2**bits) if kind.startswith("U") else (-(2 ** (bits - 1)), 2 ** (bits - 1))
    return low <= round(number) < high


def _variant(ua: Any, value: float, kind: Any) -> Any:
    is_real = kind in (ua.VariantType.Double, ua.VariantType.Float)
    return ua.Variant(value if is_real else round(value), kind)


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())[:300]
