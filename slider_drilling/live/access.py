"""Who may see the page and press its buttons.

On this machine's own address anybody on it may; a page of another site, open in the same browser, may not. On any
other address everybody needs the token.
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
    """Whether an address reaches this machine only."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class AccessControl:
    """ASGI in front of the page's own: lets through who may pass. token: None where none is asked for."""

    def __init__(self, app: App, token: str | None) -> None:
        self._app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        heads = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        if not self._comes_from_here(heads):
            await _refuse(scope, send, b"this page was asked for by another site or under another name\n")
        elif self._token is None or _equal(_cookie(heads), self._token):
            await self._app(scope, receive, send)
        elif _equal(_query_token(scope), self._token):
            await _let_in(scope, send, self._token)
        else:
            await _refuse(scope, send, b"this page needs the token that its address came with: ?token=...\n")

    def _comes_from_here(self, heads: dict[str, str]) -> bool:
        """Whether the request's origin is this page; without a token its name must also be this machine's own."""
        host = heads.get("host", "")
        if self._token is None and not is_loopback(urlsplit(f"//{host}").hostname or ""):
            return False
        origin = heads.get("origin")
        return origin is None or urlsplit(origin).netloc == host


def _equal(given: str | None, token: str) -> bool:
    return given is not None and hmac.compare_digest(given.encode(), token.encode())


def _cookie(heads: dict[str, str]) -> str | None:
    try:
        found = SimpleCookie(heads.get("cookie", "")).get(COOKIE)
    except CookieError:
        return None
    return None if found is None else found.value


def _query_token(scope: Scope) -> str | None:
    return parse_qs(scope["query_string"].decode("latin-1")).get("token", [None])[0]


async def _let_in(scope: Scope, send: Send, token: str) -> None:
    """Keep the token in a cookie and ask for the page again without it in the address."""
    if scope["type"] != "http":
        await send({"type": "websocket.close", "code": 1008})
        return
    cookie = f"{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/"
    heads = [(b"location", scope["path"].encode("latin-1")), (b"set-cookie", cookie.encode("latin-1"))]
    await send({"type": "http.response.start", "status": 303, "headers": heads})
    await send({"type": "http.response.body", "body": b""})


async def _refuse(scope: Scope, send: Send, why: bytes) -> None:
    if scope["type"] != "http":
        await send({"type": "websocket.close", "code": 1008})
        return
    heads = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": 403, "headers": heads})
    await send({"type": "http.response.body", "body": why})
