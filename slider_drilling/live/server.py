"""Serves the page from a web server in a thread of its own."""

from __future__ import annotations

import socket
import threading
import time
from dataclasses import dataclass
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.live.access import AccessControl, is_loopback
from slider_drilling.live.page_requests import RequestQueue
from slider_drilling.live.state import LiveState
from slider_drilling.live.token_file import TokenFile, open_token_file
from slider_drilling.units import SI, Units

LOCAL, PORT = "127.0.0.1", 8765
_START_TIMEOUT = 30.0  # s, enough on a busy machine


@dataclass(frozen=True)
class Address:
    """Where to serve the page.

    Attributes:
        host: Address of this machine to listen on.
        port: 0 for a free one.
        token_file: Of the token that is needed on addresses that other machines reach; "" for a temporary one.
    """

    host: str = LOCAL
    port: int = PORT
    token_file: str = ""

    def checked(self) -> Address:
        """The address. Raises InputError for an invalid port."""
        if not 0 <= self.port <= 65535:
            raise InputError(f"live page: port = {self.port}: must be from 0 to 65535; 0 takes a free one")
        return self

    def open_token(self) -> TokenFile | None:
        """The token that the address needs; None for a loopback address without a token file. Raises InputError."""
        needs_one = self.token_file or not is_loopback(self.host)
        return open_token_file(self.token_file) if needs_one else None


class PageServer:
    """Serves the page until `stop`. Raises InputError if NiceGUI is not installed or the address is taken.

    Attributes:
        url: The page's address, without the token.
        token: The token and its file; None if none is needed.
    """

    def __init__(self, state: LiveState, requests: RequestQueue, address: Address, units: Units = SI) -> None:
        address = address.checked()
        try:
            import uvicorn
            from fastapi import FastAPI
            from nicegui import ui
        except ImportError:
            raise InputError(
                "the live page needs NiceGUI; install it with `pip install 'slider_drilling[live]'`"
            ) from None

        from slider_drilling.live.page import TITLE, register_page

        listening = _listen(address)
        host = address.host if address.host not in ("0.0.0.0", "::") else socket.gethostname()
        self.url = f"http://{f'[{host}]' if ':' in host else host}:{listening.getsockname()[1]}/"
        self.token = address.open_token()
        application = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        register_page(state, requests, units)
        ui.run_with(
            application,
            title=TITLE,
            dark=None,
            tailwind=False,
            show_welcome_message=False,
            binding_refresh_interval=None,
            reconnect_timeout=30.0,
            message_history_length=50,
        )
        settings = uvicorn.Config(
            AccessControl(application, None if self.token is None else self.token.token),
            log_level="error",
            access_log=False,
            lifespan="on",
            ws="auto",
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(settings)
        self._thread = threading.Thread(
            target=self._server.run, kwargs={"sockets": [listening]}, daemon=True, name="live page"
        )
        self._thread.start()
        try:
            self._wait_until_started()
        except InputError:
            self.stop()
            raise

    def stop(self) -> None:
        """Stop the server; open pages report the lost connection."""
        self._server.should_exit = True
        self._thread.join(timeout=5.0)
        if self.token is not None:
            self.token.remove()

    def _wait_until_started(self) -> None:
        deadline = time.monotonic() + _START_TIMEOUT
        while not self._server.started:
            if not self._thread.is_alive() or time.monotonic() > deadline:
                raise InputError(f"live page: the web server at {self.url} did not start")
            time.sleep(0.01)


def _listen(address: Address) -> Any:
    """A listening socket. Raises InputError if the address is not available."""
    kind = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    listening = socket.socket(kind, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((address.host, address.port))
    except OSError as error:
        listening.close()
        raise InputError(
            f"live page: {address.host}:{address.port}: {error.strerror or error}; "
            "choose another --live-host or --live-port"
        ) from None
    return listening
