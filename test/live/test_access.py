"""Access to the live page: addresses, tokens, and requests of other sites."""

from __future__ import annotations

import asyncio
import stat
from pathlib import Path
from typing import Any

import pytest

from slider_drilling.errors import InputError
from slider_drilling.live.access import AccessControl, is_loopback
from slider_drilling.live.server import Address

TOKEN = "abcdef0123456789"


async def _inside(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"inside"})


def ask(
    token: str | None, kind: str = "http", query: str = "", path: str = "/", method: str = "GET", **heads: str
) -> dict[str, Any]:
    """The first message that comes back; underscores in the names of heads are dashes."""
    sent: list[dict[str, Any]] = []

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        return {"type": "http.request"}

    scope = {
        "type": kind,
        "path": path,
        "scheme": "ws" if kind == "websocket" else "http",
        "query_string": query.encode(),
        "headers": [(name.replace("_", "-").encode(), value.encode()) for name, value in heads.items()],
    }
    if kind == "http":
        scope["method"] = method
    asyncio.run(AccessControl(_inside, token)(scope, receive, send))
    return sent[0]


def test_loopback_needs_no_token() -> None:
    assert ask(None, host="127.0.0.1:8765")["status"] == 200
    assert ask(None, host="localhost:8765", origin="http://localhost:8765")["status"] == 200
    assert ask(None, host="[::1]:8765")["status"] == 200


OWN = {"host": "127.0.0.1:8765", "origin": "http://127.0.0.1:8765"}


def test_page_may_not_be_framed() -> None:
    for heads in ({"host": "127.0.0.1:8765"}, {"host": "evil.example"}, {"host": "["}):
        answer = dict(ask(None, **heads)["headers"])
        assert answer[b"content-security-policy"] == b"frame-ancestors 'none'"
        assert (answer[b"x-frame-options"], answer[b"referrer-policy"]) == (b"DENY", b"no-referrer")


@pytest.mark.parametrize(("heads", "status"), [
    ({"sec_fetch_site": "none", "sec_fetch_mode": "navigate", "sec_fetch_dest": "document"}, 200),
    ({"sec_fetch_site": "same-origin", "sec_fetch_mode": "cors", "sec_fetch_dest": "empty"}, 200),
    ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "navigate", "sec_fetch_dest": "document"}, 200),
    ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "navigate", "sec_fetch_dest": "iframe"}, 403),
    ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "no-cors", "sec_fetch_dest": "script"}, 403),
    ({"sec_fetch_site": "same-site", "sec_fetch_mode": "no-cors", "sec_fetch_dest": "image"}, 403),
])  # fmt: skip
def test_fetch_metadata_of_other_sites_is_refused(heads: dict[str, str], status: int) -> None:
    assert ask(None, host="127.0.0.1:8765", **heads)["status"] == status


def test_commands_must_name_their_origin() -> None:
    host = OWN["host"]
    assert ask(None, method="POST", host=host)["status"] == 403
    assert ask(None, "websocket", host=host)["type"] == "websocket.close"
    assert ask(None, method="POST", **OWN)["status"] == 200
    assert ask(None, "websocket", **OWN)["type"] == "http.response.start"
    assert ask(None, "websocket", **OWN, sec_fetch_site="cross-site")["type"] == "websocket.close"
    assert ask(None, host=host, origin="https://127.0.0.1:8765")["status"] == 403
    assert ask(None, host=host, origin="http://127.0.0.1:80")["status"] == 403


@pytest.mark.parametrize("heads", [
    {"host": "["},
    {"host": "[::1"},
    {"host": "127.0.0.1:port"},
    {"host": "user@127.0.0.1:8765"},
    {"host": "127.0.0.1:8765", "origin": "http://["},
    {"host": "127.0.0.1:8765", "origin": "http://a b"},
    {"host": "127.0.0.1:8765", "path": "/\r\nSet-Cookie: a=b"},
    {"host": "127.0.0.1:8765", "path": "/\x00"},
    {"host": "127.0.0.1:8765", "query": "&".join(["a=b"] * 200)},
])  # fmt: skip
def test_malformed_requests_are_answered_with_400(heads: dict[str, str]) -> None:
    assert ask(None, **heads)["status"] == 400


@pytest.mark.parametrize("path", ["//evil.com/", "/\\evil.com", "/\u20ac", "/\udc80", "/a/b"])
def test_token_redirects_to_the_page_only(path: str) -> None:
    answer = ask(TOKEN, host="rig-pc:8765", path=path, query=f"token={TOKEN}")
    assert (answer["status"], dict(answer["headers"])[b"location"]) == (303, b"/")


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


def test_browser_that_leaves_is_no_error() -> None:
    async def app_that_writes_on(scope: Any, receive: Any, send: Any) -> None:
        await receive()
        await send({"type": "websocket.send", "text": "x"})
        raise RuntimeError("Cannot call 'send' once a close message has been sent")

    async def run(came: str, fails: bool) -> None:
        async def receive() -> Any:
            return {"type": came}

        async def send(message: Any) -> None:
            if fails:
                raise OSError("client disconnected")

        scope = {"type": "websocket", "path": "/", "scheme": "ws", "query_string": b"", "headers": [
            (name.encode(), value.encode()) for name, value in OWN.items()]}  # fmt: skip
        await AccessControl(app_that_writes_on, None)(scope, receive, send)

    asyncio.run(run("websocket.disconnect", fails=False))
    asyncio.run(run("websocket.receive", fails=True))
    with pytest.raises(RuntimeError):
        asyncio.run(run("websocket.receive", fails=False))


def test_only_other_addresses_need_a_token(tmp_path: Path) -> None:
    assert Address().open_token() is None
    made = [Address("0.0.0.0").open_token() for _ in range(3)]
    assert len({one.token for one in made}) == 3 and all(len(one.token) == 32 for one in made)
    for one in made:
        assert stat.S_IMODE(one.path.stat().st_mode) == 0o600
        assert one.path.read_text().strip() == one.token and one.token not in one.query
        one.remove()
        assert not one.path.exists()


def test_token_file_is_made_and_kept(tmp_path: Path) -> None:
    path = tmp_path / "token"
    first = Address("127.0.0.1", token_file=str(path)).open_token()
    first.remove()
    assert Address("0.0.0.0", token_file=str(path)).open_token() == first
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.parametrize(("content", "mode", "expected"), [
    ("short", 0o600, "not a token"), ("with a space in it", 0o600, "not a token"), ("", 0o600, "not a token"),
    (TOKEN, 0o644, "others can read this token"), (TOKEN, 0o620, "others can read"),
])  # fmt: skip
def test_bad_token_file_is_refused(tmp_path: Path, content: str, mode: int, expected: str) -> None:
    path = tmp_path / "token"
    path.write_text(content)
    path.chmod(mode)
    with pytest.raises(InputError, match=f"token: {expected}"):
        Address("0.0.0.0", token_file=str(path)).open_token()
    with pytest.raises(InputError, match="cannot make this token file"):
        Address(token_file=str(tmp_path / "absent" / "token")).open_token()


@pytest.mark.parametrize("address", [Address(port=70000), Address(port=-1)])
def test_bad_ports_are_refused(address: Address) -> None:
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
