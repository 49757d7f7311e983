"""Decides who may see the page and use its controls.

On a loopback address anybody on this machine may, but not a page of another site in the same browser. On any other
address everybody needs the token.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import SplitResult, parse_qs, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "slider_drilling_token"
# No site may put the page in a frame, where it could have its buttons pressed.
PROTECTION = (
    (b"content-security-policy", b"frame-ancestors 'none'"),
    (b"x-frame-options", b"DENY"),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
)
_READING = ("GET", "HEAD")
_MALFORMED = "malformed request\n"
_OTHER_SITE = "request from another site or under another host name\n"
_NO_TOKEN = "the token is missing: open the address that ends in ?token=...\n"
_HOST = re.compile(r"[A-Za-z0-9._-]+(:\d{1,5})?|\[[0-9A-Fa-f:.]+\](:\d{1,5})?")


def is_loopback(host: str) -> bool:
    """Whether an address can be reached from this machine only."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class MalformedRequestError(ValueError):
    """A request that no browser makes."""


@dataclass(frozen=True)
class RequestSource:
    """Where a request comes from.

    Attributes:
        host: The address under which it asks, without port.
        origin: The page that asks, as browsers name it; "" if it is not named.
        is_own: Whether that page is this one.
        site: Sec-Fetch-Site; "" where the browser does not send it.
        is_navigation: Whether a person opens the page in a window of its own.
    """

    host: str
    origin: str
    is_own: bool
    site: str
    is_navigation: bool

    @classmethod
    def of(cls, scope: Scope) -> RequestSource:
        """Raises MalformedRequestError."""
        if any(character < " " or character == "\x7f" for character in scope["path"]):
            raise MalformedRequestError
        heads = _headers(scope["headers"])
        netloc, origin = heads.get("host", ""), heads.get("origin", "")
        host = (_split(f"//{netloc}").hostname or "") if netloc else ""
        scheme = {"wss": "https", "ws": "http"}.get(scope.get("scheme", "http"), scope.get("scheme", "http"))
        page = _split(origin)
        mode, target = heads.get("sec-fetch-mode", ""), heads.get("sec-fetch-dest", "")
        return cls(
            host,
            origin,
            (page.scheme, page.netloc) == (scheme, netloc),
            heads.get("sec-fetch-site", ""),
            (mode, target) == ("navigate", "document") and scope.get("method", "") in _READING,
        )

    def is_allowed(self, reading: bool, loopback_only: bool) -> bool:
        """Whether the request comes from this page, or from a person who opens it.

        Args:
            reading: Whether the request only reads. Browsers name the origin of every other one.
            loopback_only: Whether the page may be asked for under a loopback address only.
        """
        if loopback_only and not is_loopback(self.host):
            return False
        own_page = self.is_own if self.origin else reading
        return own_page and (self.site in ("", "none", "same-origin") or self.is_navigation)


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
        try:
            source = RequestSource.of(scope)
            reading = scope["type"] == "http" and scope["method"] in _READING
            cookie, query = _cookie(_headers(scope["headers"])), _query_token(scope)
        except MalformedRequestError:
            await _reject(scope, send, 400, _MALFORMED)
            return
        if not source.is_allowed(reading, loopback_only=self._token is None):
            await _reject(scope, send, 403, _OTHER_SITE)
        elif self._token is None or _equal(cookie, self._token):
            await self._serve(scope, receive, send)
        elif _equal(query, self._token):
            await _set_cookie(scope, send, self._token)
        else:
            await _reject(scope, send, 403, _NO_TOKEN)


    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request; what the application raises because the browser has left is no error."""
        has_left = False

        async def watched_receive() -> MutableMapping[str, Any]:
            nonlocal has_left
            message = await receive()
            has_left = has_left or message["type"].endswith(".disconnect")
            return message

        async def watched_send(message: MutableMapping[str, Any]) -> None:
            nonlocal has_left
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", ()), *PROTECTION]
            try:
                await send(message)
            except OSError:
                has_left = True
                raise

        try:
            await self._app(scope, watched_receive, watched_send)
        except Exception:
            if not has_left:
                raise


def _headers(raw: Iterable[tuple[bytes, bytes]]) -> dict[str, str]:
    """The headers by name. Raises MalformedRequestError if host or origin is there twice."""
    heads: dict[str, str] = {}
    for name, value in raw:
        key = name.decode("latin-1").lower()
        if key in heads and key in ("host", "origin"):
            raise MalformedRequestError
        heads[key] = value.decode("latin-1")
    return heads


def _split(address: str) -> SplitResult:
    """The parts of a Host (after //) or an Origin. Raises MalformedRequestError."""
    try:
        parts = urlsplit(address)
    except ValueError:
        raise MalformedRequestError from None
    if parts.netloc and not _HOST.fullmatch(parts.netloc):
        raise MalformedRequestError
    return parts


def _equal(given: str | None, token: str) -> bool:
    return given is not None and hmac.compare_digest(given.encode("utf-8", "replace"), token.encode())


def _cookie(headers: dict[str, str]) -> str | None:
    try:
        cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return None
    return None if cookie is None else cookie.value


def _query_token(scope: Scope) -> str | None:
    try:
        return parse_qs(scope["query_string"].decode("latin-1"), max_num_fields=100).get("token", [None])[0]
    except ValueError:
        raise MalformedRequestError from None


async def _set_cookie(scope: Scope, send: Send, token: str) -> None:
    """Store the token in a cookie and redirect to the page, whose address does not hold it."""
    if scope["type"] != "http":
        await send({"type": "websocket.close", "code": 1008})
        return
    cookie = f"{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/"
    await _answer(send, 303, [(b"location", b"/"), (b"set-cookie", cookie.encode("latin-1"))], b"")


async def _reject(scope: Scope, send: Send, status: int, reason: str) -> None:
    if scope["type"] != "http":
        await send({"type": "websocket.close", "code": 1008})
        return
    await _answer(send, status, [(b"content-type", b"text/plain; charset=utf-8")], reason.encode())


async def _answer(send: Send, status: int, headers: list[tuple[bytes, bytes]], body: bytes) -> None:
    await send({"type": "http.response.start", "status": status, "headers": [*headers, *PROTECTION]})
    await send({"type": "http.response.body", "body": body})
