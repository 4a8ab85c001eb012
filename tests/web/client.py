"""Requests to a workbench, byte by byte."""

from __future__ import annotations

import contextlib
import json
import socket
from typing import Any

from springpot.web import Workbench


def token_of(bench: Workbench) -> str:
    return bench.address.partition("#token=")[2]


def raw(
    bench: Workbench, head: str, body: bytes = b"", patience: float = 300.0
) -> tuple[int, bytes]:
    """Send a request as it stands; its status, and all that came back."""
    with socket.create_connection(("127.0.0.1", bench.port), timeout=patience) as line:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            line.sendall(head.replace("\n", "\r\n").encode() + b"\r\n\r\n" + body)
        answer = b""
        while part := _received(line):
            answer += part
    return int(answer.split(None, 2)[1]), answer


def _received(line: socket.socket) -> bytes:
    try:
        return line.recv(1 << 16)
    except ConnectionResetError:
        return b""


def head(
    bench: Workbench, method: str = "GET", path: str = "/", host: str | None = None, **more: str
) -> str:
    own = f"127.0.0.1:{bench.port}" if host is None else host
    lines = [f"{method} {path} HTTP/1.1", f"Host: {own}", "Connection: close"]
    return "\n".join(
        [*lines, *(f"{name.replace('_', '-')}: {value}" for name, value in more.items())]
    )


def ask(
    bench: Workbench, path: str, body: bytes | dict[str, Any] = b"", method: str = "POST"
) -> dict[str, Any]:
    """The last line of an answer, with the token as the page sends it."""
    content = json.dumps(body).encode() if isinstance(body, dict) else body
    start = head(
        bench, method, path, X_Springpot_Token=token_of(bench), Content_Length=str(len(content))
    )
    _, answer = raw(bench, start, content)
    lines = [line for line in unchunked(answer).splitlines() if line.startswith(b"{")]
    found: dict[str, Any] = json.loads(lines[-1])
    return found


def unchunked(answer: bytes) -> bytes:
    top, _, rest = answer.partition(b"\r\n\r\n")
    if b"chunked" not in top.lower():
        return rest
    body = b""
    while rest:
        size, _, rest = rest.partition(b"\r\n")
        count = int(size, 16)
        body, rest = body + rest[:count], rest[count + 2 :]
    return body
