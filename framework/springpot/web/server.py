"""The server: the page's own files, and one stream of lines for each thing that the page asks."""

from __future__ import annotations

import asyncio
import base64
import json
from collections.abc import AsyncIterator, Callable, MutableMapping
from contextlib import suppress
from typing import Any

from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from springpot.errors import DataError
from springpot.inputs import json_of

from .desk import Desk, Line
from .guard import App, Message, Receive, Refusal, Send
from .pagefiles import page_files
from .state import State

BEAT = 0.5
"""Seconds between signs of life of a computation."""
MOST_DATA = 32
"""Data sets that the server keeps; a page sends again what has gone."""

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
                await asyncio.wait({step, gone}, timeout=BEAT, return_when=asyncio.FIRST_COMPLETED)
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
    """

    def __init__(
        self, desk: Desk, data: str | dict[str, str] | None = None, model: str = ""
    ) -> None:
        self._desk, self._given, self._model = desk, data, model
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
            if name == "kind":
                nothing = ""
            arguments[name] = given.get(name) or nothing
        if task in ("leave", "again"):
            arguments |= {"source": data["source"], "joined": data["joined"]}
        key = ""
        if task in KEPT:
            key = f"{task} {state.key}"
        return self._stream(task, arguments, LANES[task], key)

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
                    while len(self._texts) > MOST_DATA:
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
    "leave": "long",
    "held": "long",
}
LANES |= {"curve": "short", "again": "short"}
"""Which workers do what the page asks of data."""
EXTRA = {"curve": ("hands",), "held": ("hands",), "leave": ("kind",)}
"""What these tasks are told beside the state."""
KEPT = frozenset({"answer", "ranking", "mastercurve"})
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
