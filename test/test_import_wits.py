"""WITS: its units, and streams by TCP and serial line."""

from __future__ import annotations

import os
import socket
import struct
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from table_text import KLBF, hook, written

from slider_drilling.commands.import_table import command
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.table_import import import_table, read_table
from slider_drilling.table_import.live_wits import open_stream, record_wits

WITS = "".join(f"&&\r\n0105240312\r\n01061458{k:02d}\r\n0114{200 + k}\r\n0120-9999\r\n!!\r\n" for k in range(3))


def test_wits_asks_for_its_units(tmp_path: Path) -> None:
    path = written(tmp_path, WITS, name="rig.wits")
    with pytest.raises(InputError, match="does not tell the units of HKLA; add --wits-units field"):
        read_table(path)
    np.testing.assert_allclose(hook(import_table(path, wits_units="field").log), [200, 201, 202])
    np.testing.assert_allclose(hook(import_table(path, wits_units="metric").log) * KLBF, [2e6, 2.01e6, 2.02e6])


def test_wits_from_a_tcp_stream(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def send() -> None:
            connection, _ = server.accept()
            with connection:
                connection.sendall(WITS.encode())

        sender = threading.Thread(target=send)
        sender.start()
        port, output = server.getsockname()[1], tmp_path / "live.mcap"
        arguments = [f"wits://127.0.0.1:{port}", "-o", str(output), "--wits-units", "field"]
        answer = CliRunner().invoke(command, arguments, catch_exceptions=False)
        sender.join()
    assert answer.exit_code == 0
    np.testing.assert_allclose(hook(read_log(output)), [200, 201, 202])
    assert (tmp_path / "live.wits").read_bytes() == WITS.encode()


def test_lost_connection_is_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"wits://127.0.0.1:{server.getsockname()[1]}"
        with open_stream(address) as receive:
            connection, _ = server.accept()
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            connection.close()
            with pytest.raises(InputError, match=f"{address}: the connection was lost"):
                receive()


def test_closed_standard_input_is_an_ended_stream(monkeypatch: pytest.MonkeyPatch) -> None:
    """Python has no sys.stdin then; the command line has put /dev/null in its place."""
    monkeypatch.setattr(sys, "stdin", None)
    with open(os.devnull, "rb") as null, moved_to(0, null.fileno()), open_stream("-") as receive:
        assert receive() == b""


@contextmanager
def moved_to(descriptor: int, source: int) -> Iterator[None]:
    kept = os.dup(descriptor)
    os.dup2(source, descriptor)
    try:
        yield
    finally:
        os.dup2(kept, descriptor)
        os.close(kept)


def test_wits_from_a_serial_line(tmp_path: Path) -> None:
    pytest.importorskip("serial")
    own, device = os.openpty()
    name, output = os.ttyname(device), tmp_path / "live.mcap"
    threading.Timer(0.3, os.write, (own, WITS.encode())).start()
    arguments = [f"serial://{name}?baud=9600", "-o", str(output), "--wits-units", "field", "--duration", "1.5"]
    answer = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert answer.exit_code == 0
    np.testing.assert_allclose(hook(read_log(output)), [200, 201, 202])


@pytest.mark.parametrize(
    ("address", "message"),
    [("wits://127.0.0.1", "give host and port"), ("wits://127.0.0.1:1", "cannot connect"),
     ("serial:///dev/no-such-line", "cannot open this serial line")],
)  # fmt: skip
def test_stream_that_cannot_be_reached_gets_one_line(tmp_path: Path, address: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        record_wits(address, tmp_path / "a.wits", 1.0)
    assert not list(tmp_path.iterdir())
