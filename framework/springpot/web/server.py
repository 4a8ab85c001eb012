"""The server: the page's own files, and one stream of lines for each thing that the page asks.

It stands between the browser, where any site runs scripts, and a user's files. Loopback alone is no
protection: a foreign page can send requests to it, and by DNS rebinding even read the answers. So
the Host must be this machine's own name, an Origin the server's own, and whatever computes needs
the token of the run, which only the page knows that was opened from the terminal. All that the page
consists of is read once, so that no name from a browser ever opens a file.
"""

from __future__ import annotations

import asyncio
import base64
import hmac
import json
from collections.abc import AsyncIterator, Awaitable, Callable, MutableMapping
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple

from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from springpot.errors import DataError
from springpot.files import json_of
from springpot.report.page import assets_in, modules

from .desk import Desk, Line
from .sessions import State

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[MutableMapping[str, Any], Receive, Send], Awaitable[None]]

TOKEN = b"x-springpot-token"


class ServerLimits(NamedTuple):
    """What a page may ask for, and how long it may take."""

    largest: int
    """Bytes of a request: text of some hundred thousand points."""
    patience: float
    """Seconds that a request may be silent before its body is whole."""
    longest: float
    """Seconds within which the body must be whole: at loopback a second is enough for the
    largest.
    """
    beat: float
    """Seconds between signs of life of a computation."""
    most_data: int
    """Data sets that the server keeps; a page sends again what has gone."""
    connections: int
    """Connections at once.

    A page holds six, and a process may open 256 files where the least is allowed.
    """


SERVER = ServerLimits(
    largest=33_554_432, patience=15.0, longest=60.0, beat=0.5, most_data=32, connections=128
)
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

    def __init__(self, app: App, token: str, largest: int = SERVER.largest) -> None:
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
        left = min(SERVER.patience, begun + SERVER.longest - asyncio.get_running_loop().time())
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


KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}


@cache
def page_files() -> dict[str, tuple[bytes, str]]:
    """Content and media type of each file of the page by name, modules of reports included."""
    files = modules() | assets_in("springpot.web", "page")
    kinds = {name: KINDS.get(name[name.rfind(".") :]) for name in files}
    # A file of no known kind is no part of the page, such as one that an editor left behind.
    return {name: (files[name], kind) for name, kind in kinds.items() if kind is not None}


Answer = AsyncIterator[Line]


class Streamed(Response):
    """Lines as they come; left when the browser leaves."""

    def __init__(self, lines: Callable[[], Answer]) -> None:
        super().__init__(media_type="application/x-ndjson")
        self._lines = lines

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """Send them."""
        headers = [(b"content-type", b"application/x-ndjson")]
        # Sent before there is an answer: stages are to be seen while it is computed.
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        # A browser that closes the page ends what nobody waits for any more.
        gone = asyncio.create_task(_gone(receive))
        stream = self._lines()
        step: asyncio.Task[Line] | None = None
        try:
            while not gone.done():
                # One that a sign of life outran is waited for again, not asked for twice.
                step = step or asyncio.ensure_future(anext(stream))
                await asyncio.wait(
                    {step, gone}, timeout=SERVER.beat, return_when=asyncio.FIRST_COMPLETED
                )
                if gone.done():
                    return
                # While nothing is told the line shows the page that the server lives.
                body = b'{"beat": true}\n'
                if step.done():
                    try:
                        body, step = step.result(), None
                    except StopAsyncIteration:
                        break
                await send({"type": "http.response.body", "body": body, "more_body": True})
            await send({"type": "http.response.body", "body": b""})
        finally:
            gone.cancel()
            if step is not None:
                step.cancel()
                with suppress(asyncio.CancelledError, StopAsyncIteration):
                    await step
            # So that the desk hears at once that this listener has left.
            await stream.aclose()  # type: ignore[attr-defined]


async def _gone(receive: Receive) -> None:
    message: Message = {}
    while message.get("type") != "http.disconnect":
        message = await receive()


class Server:
    """What the page asks, handed to the desk.

    Parameters
    ----------
    desk : Desk
        Who computes.
    data : str or dict, optional
        What the page begins with: what was named on the command line, or ``{"name", "content"}`` in
        base64.
    model : str
        Expression of the model that it begins with.
    folder : str
        What is watched, with what is said of all of its files: ``DIR?storage=Pa``.
    """

    def __init__(
        self,
        desk: Desk,
        data: str | dict[str, str] | None = None,
        model: str = "",
        folder: str = "",
    ) -> None:
        self._desk, self._given, self._model, self._folder = desk, data, model, folder
        self._texts: dict[str, dict[str, Any]] = {}

    def app(self) -> App:
        """The ASGI application; to be put behind a `Guard`."""
        routes = [
            Route("/", self._file, methods=["GET"]),
            Route("/page/{name}", self._file, methods=["GET"]),
            Route("/api/start", self._begin, methods=["GET"]),
            Route(
                "/api/library",
                lambda request: self._stream("library", {}, key="library"),
                methods=["GET"],
            ),
            Route("/api/data", self._data, methods=["POST"]),
            # Last: it would take the others' addresses too.
            Route("/api/{task}", self._ask, methods=["POST"]),
        ]
        return Starlette(routes=routes, exception_handlers={DataError: _bad, Refusal: _refused})

    async def _file(self, request: Request) -> Response:
        # Looked up among the page's own: nothing that a browser says is ever part of a path.
        file = page_files().get(request.path_params.get("name", "index.html"))
        if file is None:
            return Response("there is no such page\n", 404, media_type="text/plain")
        content, kind = file
        return Response(content, headers={"content-type": kind})

    async def require(self) -> None:
        """Check that what the command line named can be used, or merely leaves a reader a question.

        Raises
        ------
        DataError
            With the one line of every other command.
        """
        if isinstance(self._given, str) or self._model:
            done = await self._begun()
            if "error" in done and not done["fault"]:
                raise DataError(done["error"])

    async def _begin(self, request: Request) -> Response:
        """What was named on the command line, opened.

        Its error stands in the page as it would on a terminal.
        """
        if self._given is None:
            return JSONResponse({"model": self._model})
        return JSONResponse({"model": self._model, "data": await self._begun()})

    async def _begun(self) -> Any:
        if isinstance(self._given, dict):
            lines = self._desk.ask("understand", dict(self._given))
        else:
            lines = self._desk.ask("begin", {"spec": self._given or "", "model": self._model})
        return await self._last(self._remembered(lines))

    async def _data(self, request: Request) -> Response:
        """A file's bytes as they are, its name and what the user says of it in the query."""
        asked = request.query_params
        body = await _body_of(request)
        if "dataset" in asked:
            # Cut short: it need not be our page that asks.
            return self._stream("dataset", {"name": asked["dataset"][:200]}, remember=True)
        arguments = {
            "name": asked.get("name", "data.csv")[:400],
            "choice": asked.get("choice", "")[:2000],
            "content": base64.b64encode(body).decode(),
        }
        # By digest: the page need not send again what is here.
        onto = self._texts.get(asked.get("onto", ""))
        if onto is not None:
            arguments |= {"onto": onto["text"], "onto_name": onto["source"]}
        return self._stream("understand", arguments, remember=True)

    async def _ask(self, request: Request) -> Response:
        task = request.path_params["task"]
        try:
            given = json_of((await _body_of(request)).decode())
            if not isinstance(given, dict):
                raise ValueError
        except ValueError:
            raise DataError("the request is no JSON object") from None
        if task == "race":
            asked = {
                "name": str(given.get("name", ""))[:200],
                "report": given.get("report") is True,
            }
            return self._stream("race", asked)
        if task == "watch":
            return self._watch(given)
        # Only what is listed: no address can name another function.
        if task not in LANES:
            return Response("there is no such task\n", 404, media_type="text/plain")
        state = State.of(given.get("state") or {})
        data = self._texts.get(state.data)
        if data is None:
            raise DataError("these data are no longer here: drop the file again")
        arguments = {"state": state.to_dict(), "text": data["text"]}
        for name in EXTRA.get(task, ()):
            nothing: Any = {}
            if name in ("kind", "law"):
                nothing = ""
            arguments[name] = given.get(name) or nothing
        if task in ("leave", "again", "turned"):
            arguments |= {"source": data["source"], "joined": data["joined"]}
        key = ""
        if task in KEPT:
            key = f"{task} {state.key}"
        lane = "quiet" if given.get("quiet") else LANES[task]
        return self._stream(task, arguments, lane, key, remember=task == "turned")

    def _watch(self, given: dict[str, Any]) -> Response:
        """What is new in the folder that the command line named; of none, nothing."""
        if not self._folder:
            return Response(b'{"result": {}}\n', media_type="application/x-ndjson")
        asked = {name: str(given.get(name) or "")[:100] for name in ("known", "base", "before")}
        for name in ("base", "before"):
            digest = asked[name]
            if digest not in ("", *self._texts):
                raise DataError("these data are no longer here: drop the file again")
            if digest:
                # What grows is a data set each time: that it grew from is not the one to go.
                self._texts[digest] = self._texts.pop(digest)
                asked[name] = self._texts[digest]["text"]
        return self._stream("watch", {**asked, "folder": self._folder}, remember=True)

    def _stream(
        self,
        task: str,
        arguments: dict[str, Any],
        lane: str = "short",
        key: str = "",
        remember: bool = False,
    ) -> Response:
        def lines() -> Answer:
            asked = self._desk.ask(task, arguments, lane, key)
            if remember:
                return self._remembered(asked)
            return asked

        return Streamed(lines)

    async def _remembered(self, lines: Answer) -> Answer:
        """The lines, while the text of data in them stays here: the page knows it by its digest."""
        async for line in lines:
            if line.startswith(b'{"result"'):
                result = json.loads(line)["result"]
                # A question of a reader comes without data.
                if "digest" in result:
                    known = {key: result[key] for key in ("text", "source", "joined")}
                    self._texts[result["digest"]] = known
                    while len(self._texts) > SERVER.most_data:
                        # A dictionary keeps its order: the first one came first.
                        del self._texts[next(iter(self._texts))]
            yield line

    @staticmethod
    async def _last(lines: Answer) -> Any:
        last = b"{}"
        async for line in lines:
            last = line
        return json.loads(last)


LANES = {
    "answer": "long",
    "ranking": "long",
    "mastercurve": "long",
    "spectrum": "long",
    "leave": "long",
    "held": "long",
    "laws": "long",
}
SHORT = ("first", "curve", "again", "turned", "trial")
LANES |= dict.fromkeys(SHORT, "short")
"""Which workers do what the page asks of data."""
EXTRA = {"curve": ("hands",), "held": ("hands",), "leave": ("kind",), "trial": ("law",)}
"""What these tasks are told beside the state."""
KEPT = frozenset({"first", "answer", "ranking", "mastercurve", "spectrum", "laws"})
"""Pure functions of the state alone."""


async def _body_of(request: Request) -> bytes:
    try:
        return await request.body()
    except ClientDisconnect:
        raise Refusal(400, "the browser left before all was sent") from None


async def _refused(request: Request, error: Exception) -> Response:
    status = 500
    if isinstance(error, Refusal):
        status = error.status
    return Response(f"{error}\n", status, headers={"connection": "close"}, media_type="text/plain")


async def _bad(request: Request, error: Exception) -> Response:
    return JSONResponse({"error": str(error), "fault": False}, 400)
