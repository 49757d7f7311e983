"""Decides who may see the page and use its controls.

On a loopback address anybody on this machine may, but not a page of another site in the same browser. On any other
address everybody needs the token.
"""

from __future__ import annotations

import hmac
import ipaddress
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "slider_drilling_token"


def is_loopback(host: str) -> bool:
    """Whether an address can be reached from this machine only."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class AccessControl:
    """An ASGI application in front of the page's that rejects requests without access.

    Args:
        app: The page's application.
        token: What requests must bring; None if no token is needed.
    """

    def __init__(self, app: App, token: str | None) -> None:
        self._app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        if not self._has_own_origin(headers):
            await _reject(scope, send, b"request from another site or under another host name\n")
        elif self._token is None or _equal(_cookie(headers), self._token):
            await self._app(scope, receive, send)
        elif _equal(_query_token(scope), self._token):
            await _set_cookie(scope, send, self._token)
        else:
            await _reject(scope, send, b"the token is missing: open the address that ends in ?token=...\n")

    def _has_own_origin(self, headers: dict[str, str]) -> bool:
        """Whether the request comes from this page; without a token its host must also be a loopback address."""
        host = headers.get("host", "")
        if self._token is None and not is_loopback(urlsplit(f"//{host}").hostname or ""):
            return False
        origin = headers.get("origin")
        return origin is None or urlsplit(origin).netloc == host


def _equal(given: str | None, token: str) -> bool:
    return given is not None and hmac.compare_digest(given.encode(), token.encode())


def _cookie(headers: dict[str, str]) -> str | None:
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return None
    return None if cookie is None else cookie.value


def _query_token(scope: Scope) -> str | None:
    return parse_qs(scope["query_string"].decode("latin-1")).get("token", [None])[0]


async def _set_cookie(scope: Scope, send: Send, token: str) -> None:
    """Store the token in a cookie and redirect to the address without it."""
    if scope["type"] != "http":
        await send({"type": "websocket.close", "code": 1008})
        return
    cookie = f"{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/"
    headers = [(b"location", scope["path"].encode("latin-1")), (b"set-cookie", cookie.encode("latin-1"))]
    await send({"type": "http.response.start", "status": 303, "headers": headers})
    await send({"type": "http.response.body", "body": b""})


async def _reject(scope: Scope, send: Send, reason: bytes) -> None:
    if scope["type"] != "http":
        await send({"type": "websocket.close", "code": 1008})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": reason})
