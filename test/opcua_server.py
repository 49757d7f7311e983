"""A real OPC UA server with a rig's nodes, in a thread of its own."""

import asyncio
import threading
from datetime import datetime, timezone
from typing import Any

import asyncua
from asyncua import ua

BAD_VALUE = ua.DataValue(ua.Variant(1.0, ua.VariantType.Double), ua.StatusCode(0x80310000))  # BadNoCommunication
NO_BEAT = object()
VALUES = {
    "TopDrive.Angle": 180.0,
    "TopDrive.Speed": 30.0,
    "TopDrive.Torque": 5.0,
    "DrawWorks.Lowered": 1.5,
    "DrawWorks.Speed": 9.0,
    "DrawWorks.HookLoad": 900.0,
    "Mud.StandpipePressure": 180.0,
    "Mud.PumpSpeed": 60.0,
    "Mwd.ToolFace": 45.0,
}
WANTED = ("TopDrive.AngleWanted", "TopDrive.SpeedWanted", "DrawWorks.SpeedWanted", "Mud.PumpSpeedWanted")

NARROW = "TopDrive.AngleInteger"  # a command of 16 bits


def _data_value(value: Any) -> ua.DataValue:
    if isinstance(value, ua.DataValue):
        return value
    return ua.DataValue(ua.Variant(value), SourceTimestamp=datetime.now(timezone.utc))


class RigServer:
    """Its heartbeat counts while `alive`; `beat` replaces what it shows.

    Args:
        port: 0 for a free one.
    """

    def __init__(self, port: int = 0) -> None:
        self.alive, self.beat = True, NO_BEAT
        self._shown: dict[str, ua.DataValue] = {}
        self._port = port
        self._ready = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        self._thread = threading.Thread(target=lambda: self._loop.run_until_complete(self._serve()), daemon=True)
        self._thread.start()
        # A busy machine takes minutes for what is a second of its time; pytest's own timeout ends what never comes.
        while not self._ready.wait(0.1):
            assert self._thread.is_alive(), "the server's thread has failed"

    async def _serve(self) -> None:
        self._server = asyncua.Server()
        await self._server.init()
        self._server.set_endpoint(f"opc.tcp://127.0.0.1:{self._port}/rig/")
        self._server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        assert await self._server.register_namespace("rig") == 2
        objects = self._server.nodes.objects
        self._nodes = {}
        await objects.add_variable(ua.NodeId("Name", 2), "Name", "a rig")
        for name, value in {**VALUES, **dict.fromkeys(WANTED, 0.0), "Heartbeat": 0.0}.items():
            self._nodes[name] = await objects.add_variable(ua.NodeId(name, 2), name, value)
            await self._nodes[name].set_writable()
        narrow = ua.Variant(0, ua.VariantType.Int16)
        self._nodes[NARROW] = await objects.add_variable(ua.NodeId(NARROW, 2), NARROW, narrow)
        await self._nodes[NARROW].set_writable()
        for name in (*VALUES, "Heartbeat"):
            # Shown whatever its type is, as sloppy servers do; a variable of asyncua refuses another type than its own.
            self._shown[name] = _data_value(VALUES.get(name, 0.0))
            self._server.set_attribute_value_callback(
                self._nodes[name].nodeid, lambda *_, name=name: self._shown[name]
            )
        await self._server.start()
        self._port = self._server.bserver._server.sockets[0].getsockname()[1]
        self._ready.set()
        count = 0.0
        while not self._end.is_set():
            count += self.alive
            self._shown["Heartbeat"] = _data_value(count if self.beat is NO_BEAT else self.beat)
            await asyncio.sleep(0.05)
        await self._server.stop()

    @property
    def url(self) -> str:
        return f"opc.tcp://127.0.0.1:{self._port}/rig/"

    @property
    def port(self) -> int:
        return self._port

    def _run(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(30.0)

    def read(self, name: str) -> Any:
        return self._run(self._nodes[name].read_value())

    def write(self, name: str, value: Any) -> None:
        """A value, or a DataValue; of what the rig gives, of any type."""
        if name in self._shown:
            self._shown[name] = _data_value(value)
        else:
            self._run(self._server.write_attribute_value(self._nodes[name].nodeid, _data_value(value)))

    def forbid_writing(self, name: str) -> None:
        self._run(self._nodes[name].set_read_only())

    def spoil(self, name: str) -> None:
        """A value of bad quality, as of a sensor that is off."""
        self.write(name, BAD_VALUE)

    def mend(self) -> None:
        """As at the start."""
        self.alive, self.beat = True, NO_BEAT
        for name, value in {**VALUES, **dict.fromkeys(WANTED, 0.0)}.items():
            self.write(name, value)
        for name in WANTED:
            self._run(self._nodes[name].set_writable())

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(30.0)
