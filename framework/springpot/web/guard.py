"""What stands between the browser, where any site runs scripts, and a server of a user's files.

Loopback alone is no protection: a foreign page can send requests to it, and by DNS rebinding even
read the answers. So the Host must be this machine's own name, an Origin the server's own, and
whatever computes needs the token of the run, which only the page knows that was opened from the
terminal.
"""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[MutableMapping[str, Any], Receive, Send], Awaitable[None]]

TOKEN = b"x-springpot-token"
LARGEST = 32 << 20
"""Bytes of a request: text of some hundred thousand points."""
PATIENCE = 15.0
"""Seconds that a request may be silent before its body is whole."""
LONGEST = 60.0
"""Seconds within which the body must be whole: at loopback a second is enough for the largest."""
OWN_NAMES = frozenset({"127.0.0.1", "localhost", "[::1]"})

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:;"
    " connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Nothing from elsewhere, no inline script or style.

Pictures of networks and exported plots are data: and blob:.
"""
HEADERS = (
    (b"content-security-policy", POLICY.encode()),
    (b"cache-control", b"no-store"),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
)


class Refusal(Exception):
    """A request that is answered by a status and one line."""

    def __init__(self, status: int, says: str) -> None:
        super().__init__(says)
        self.status = status


class Guard:
    """Lets only requests of the page itself through to an application, and limits what they send.

    Parameters
    ----------
    app : callable
        The ASGI application behind it.
    token : str
        Of this run.
    largest : int
        Bytes of a request.
    """

    def __init__(self, app: App, token: str, largest: int = LARGEST) -> None:
        self._app, self._token, self._largest = app, token.encode(), largest

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            # Web sockets are no part of the page.
            return

        async def sealed(message: Message) -> None:
            if message["type"] == "http.response.start":
                # On every answer, refusals among them: none may be framed, sniffed or kept.
                message["headers"] = [*message.get("headers", ()), *HEADERS]
            await send(message)

        try:
            headers = _headers_of(scope)
            # Before a byte of the body is taken.
            self._check(scope, headers)
            limited = _limited(receive, self._largest, headers)
            await self._app(scope, limited, sealed)
        except Refusal as refusal:
            await _refuse(sealed, refusal)

    def _check(self, scope: MutableMapping[str, Any], headers: dict[bytes, bytes]) -> None:
        # By DNS rebinding a foreign name comes to mean this machine, and the browser names it here.
        host = headers.get(b"host", b"").decode("latin-1")
        if host.rpartition(":")[0] not in OWN_NAMES and host not in OWN_NAMES:
            raise Refusal(400, "this server answers only to 127.0.0.1 and localhost")
        # A browser tells here whose script asks; an address that was typed has none.
        origin = headers.get(b"origin")
        if origin is not None and origin != b"http://" + headers[b"host"]:
            raise Refusal(403, "this server answers only to its own page")
        # An address that was typed comes with "none"; a browser that knows no such header sends
        # nothing.
        site = headers.get(b"sec-fetch-site", b"none")
        # The browser comes to the page itself from a file, or by a link: there is nothing in it
        # that is not public.
        if scope["path"] == "/" and headers.get(b"sec-fetch-mode") == b"navigate":
            site = b"none"
        if site not in (b"same-origin", b"none"):
            raise Refusal(403, "this server answers only to its own page")
        # In constant time: how long a comparison takes would tell the token sign by sign.
        if scope["path"].startswith("/api/") and not hmac.compare_digest(
            headers.get(TOKEN, b""), self._token
        ):
            raise Refusal(
                401, "the token of this run is missing: open the address that springpot printed"
            )


def _headers_of(scope: MutableMapping[str, Any]) -> dict[bytes, bytes]:
    """The headers; one that stands twice is refused, for two readers could take different ones."""
    headers: dict[bytes, bytes] = {}
    for name, value in scope["headers"]:
        if name in headers and name in (b"host", b"origin", TOKEN, b"content-length"):
            raise Refusal(400, f"the header {name.decode('latin-1')} stands twice")
        headers[name] = value
    return headers


def _limited(receive: Receive, largest: int, headers: dict[bytes, bytes]) -> Receive:
    """`receive`, which ends when a body is too large, or too slow."""
    stated = headers.get(b"content-length", b"0")
    # What is told to be too large is refused before it is read; what grows beyond, below.
    if not stated.isdigit() or int(stated) > largest:
        raise Refusal(
            413,
            f"more than {largest >> 20} MiB at once are not taken: leave out what is not needed",
        )
    begun = asyncio.get_running_loop().time()
    taken, whole = 0, False

    async def limited() -> Message:
        nonlocal taken, whole
        if whole:
            # Now it tells when the browser goes, for which one waits as long as a fit takes.
            return await receive()
        # Two clocks: one who sends a byte now and then would never be silent for long.
        left = min(PATIENCE, begun + LONGEST - asyncio.get_running_loop().time())
        try:
            async with asyncio.timeout(left):
                message = await receive()
        except TimeoutError:
            raise Refusal(408, "the request took too long") from None
        taken += len(message.get("body", b""))
        if taken > largest:
            raise Refusal(
                413,
                f"more than {largest >> 20} MiB at once are not taken: leave out what is not"
                " needed",
            )
        whole = not message.get("more_body", False)
        return message

    return limited


async def _refuse(send: Send, refusal: Refusal) -> None:
    body = (str(refusal) + "\n").encode()
    # Plain text, closed at once: what is left of the body is not read as the next request.
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": refusal.status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
