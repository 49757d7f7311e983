"""Access to the live page: addresses, tokens, and requests of other sites."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from slider_drilling.errors import InputError
from slider_drilling.live.access import AccessControl, is_loopback
from slider_drilling.live.server import Address

TOKEN = "abcdef0123456789"


async def _inside(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"inside"})


def ask(token: str | None, kind: str = "http", query: str = "", **heads: str) -> dict[str, Any]:
    """The first message that comes back; underscores in the names of heads are dashes."""
    sent: list[dict[str, Any]] = []

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        return {"type": "http.request"}

    scope = {
        "type": kind,
        "path": "/",
        "query_string": query.encode(),
        "headers": [(name.replace("_", "-").encode(), value.encode()) for name, value in heads.items()],
    }
    asyncio.run(AccessControl(_inside, token)(scope, receive, send))
    return sent[0]


def test_loopback_needs_no_token() -> None:
    assert ask(None, host="127.0.0.1:8765")["status"] == 200
    assert ask(None, host="localhost:8765", origin="http://localhost:8765")["status"] == 200
    assert ask(None, host="[::1]:8765")["status"] == 200


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize("heads", [
    {"host": "evil.example:8765"},
    {"host": "127.0.0.1:8765", "origin": "http://evil.example"},
    {"host": "127.0.0.1:8765", "origin": "null"},
    {},
])  # fmt: skip
def test_other_sites_are_rejected(kind: str, heads: dict[str, str]) -> None:
    answer = ask(None, kind, **heads)
    assert answer.get("status") == 403 if kind == "http" else answer["type"] == "websocket.close"


def test_token_is_replaced_by_a_cookie() -> None:
    host = "rig-pc:8765"
    assert ask(TOKEN, host=host)["status"] == 403
    assert ask(TOKEN, host=host, query="token=wrong")["status"] == 403
    assert ask(TOKEN, "websocket", host=host)["type"] == "websocket.close"
    let_in = ask(TOKEN, host=host, query=f"token={TOKEN}")
    assert let_in["status"] == 303
    heads = dict(let_in["headers"])
    assert heads[b"location"] == b"/"
    cookie = heads[b"set-cookie"].decode()
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie
    pair = cookie.partition(";")[0]
    assert ask(TOKEN, host=host, cookie=pair)["status"] == 200
    assert ask(TOKEN, host=host, cookie=f"{pair}x")["status"] == 403
    assert ask(TOKEN, host=host, cookie=pair, origin="http://evil.example")["status"] == 403
    assert ask(TOKEN, host=host, cookie="=;;;")["status"] == 403


def test_other_addresses_get_a_token() -> None:
    assert Address().checked().token == ""
    made = {Address("0.0.0.0").checked().token for _ in range(3)}
    assert len(made) == 3 and all(len(one) == 32 for one in made)
    assert Address("192.168.1.4", token=TOKEN).checked().token == TOKEN


@pytest.mark.parametrize(
    "address", [Address(port=70000), Address(port=-1), Address(token="short"), Address(token="with a space in it")]
)
def test_bad_addresses_are_refused(address: Address) -> None:
    with pytest.raises(InputError, match="live page"):
        address.checked()


@pytest.mark.parametrize(
    ("host", "own"),
    [
        ("127.0.0.1", True),
        ("127.8.8.8", True),
        ("::1", True),
        ("LOCALHOST", True),
        ("0.0.0.0", False),
        ("192.168.0.2", False),
        ("rig.example", False),
    ],
)
def test_loopback_addresses_are_recognised(host: str, own: bool) -> None:
    assert is_loopback(host) is own
