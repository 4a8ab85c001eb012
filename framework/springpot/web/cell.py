"""The workbench in a cell of a notebook: page and server, joined by the channel of the kernel."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import anywidget
import traitlets

from springpot.processes import LEAVING
from springpot.registry import parse_model

from .desk import Desk
from .server import Message, Server, page_files
from .sessions import State

if TYPE_CHECKING:
    from springpot.rheology.model import Model

HEIGHT = 900
"""Pixels of the page within its cell."""
Say = Callable[[dict[str, Any], list[bytes]], object]


class KernelChannel:
    """Requests of pages, answered by the workbench's server in a thread of its own.

    A kernel hears them in several threads, and while a cell runs in some of them only.

    Parameters
    ----------
    server : Server
        Who answers.
    desk : Desk
        Its workers, which are started with the first request.
    say : callable
        Tells a page ``{"id", "status"}``, then parts of the body, and at last ``{"id", "end"}``;
        called from that thread.
    """

    def __init__(self, server: Server, desk: Desk, say: Say) -> None:
        self._app, self._desk, self._say = server.app(), desk, say
        self._opened: asyncio.Task[None] | None = None
        self._gone: dict[str, asyncio.Event] = {}
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(
            target=self._loop.run_forever, name="springpot-workbench", daemon=True
        )
        self._thread.start()

    def heard(self, said: dict[str, Any], parts: Sequence[bytes]) -> None:
        """Begin to answer a request, or end the answer that its page has given up.

        Parameters
        ----------
        said : dict
            ``{"id", "method", "path"}`` or ``{"id", "gone": True}``.
        parts : sequence of bytes
            Of the request's body.
        """
        name = str(said["id"])
        if said.get("gone"):
            self._loop.call_soon_threadsafe(self._leave, name)
            return
        body = b"".join(bytes(part) for part in parts)
        asyncio.run_coroutine_threadsafe(self._answer(name, said, body), self._loop)

    def _leave(self, name: str) -> None:
        if name in self._gone:
            self._gone[name].set()

    async def _answer(self, name: str, said: dict[str, Any], body: bytes) -> None:
        gone = self._gone[name] = asyncio.Event()
        if self._opened is None:
            self._opened = asyncio.ensure_future(self._desk.open())
        await self._opened
        given = [body]

        async def receive() -> Message:
            if given:
                return {"type": "http.request", "body": given.pop()}
            # As of a browser that listens: until it goes.
            await gone.wait()
            return {"type": "http.disconnect"}

        async def send(message: Message) -> None:
            if gone.is_set():
                return
            if message["type"] == "http.response.start":
                self._say({"id": name, "status": message["status"]}, [])
                return
            ended = not message.get("more_body", False)
            self._say({"id": name, "end": ended}, [message.get("body", b"")])

        try:
            await self._app(_scope(said), receive, send)
        finally:
            del self._gone[name]

    def close(self) -> None:
        """End all workers, and the thread."""
        if self._loop.is_closed():
            return
        # Longer than the desk itself waits: a worker that hangs must not hold the notebook.
        wait = 2.0 * LEAVING
        asyncio.run_coroutine_threadsafe(self._desk.close(), self._loop).result(wait)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(wait)
        self._loop.close()


def _scope(said: dict[str, Any]) -> dict[str, Any]:
    address = urlsplit(str(said["path"]))
    return {
        "type": "http",
        "method": str(said["method"]),
        "path": address.path,
        "query_string": address.query.encode(),
        "headers": [],
    }


class WorkbenchCell(anywidget.AnyWidget):
    """The workbench as a widget of JupyterLab and of what else shows widgets of a kernel.

    Parameters
    ----------
    data : str or dict, optional
        As for `Workbench`.
    model : str
        Expression of the model that is judged at first; empty for any material.
    watch : str
        Folder whose files are watched.
    height : int
        Pixels of the page within its cell.
    """

    _esm = page_files()["cell.js"][0].decode()
    page = traitlets.Unicode().tag(sync=True)
    files = traitlets.Dict().tag(sync=True)
    session = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(HEIGHT).tag(sync=True)

    def __init__(
        self,
        data: str | dict[str, str] | None = None,
        model: str = "",
        watch: str = "",
        height: int = HEIGHT,
    ) -> None:
        # First: a widget that is only half made is closed, too.
        desk = Desk()
        self._channel = KernelChannel(Server(desk, data, model, watch), desk, self.send)
        texts = {name: content.decode() for name, (content, _) in page_files().items()}
        program = {name: text for name, text in texts.items() if name.endswith(".js")}
        super().__init__(page=_document(texts), files=program, height=height)
        self.on_msg(lambda _, said, parts: self._channel.heard(said, parts))

    @property
    def _state(self) -> State | None:
        """What the page shows."""
        if not self.session:
            return None
        saved = json.loads(self.session)
        branch = saved["branches"][saved["branch"]]
        return State.of(branch["states"][branch["at"]])

    @property
    def ladder(self) -> tuple[str, ...]:
        """Expression of each rung shown, from the foot; none before there are data."""
        state = self._state
        if state is None:
            return ()
        rungs = [State(state.data, state.model)]
        for effect in state.accepted:
            rungs.append(rungs[-1].accepting(effect))
        return tuple(rung.expression for rung in rungs)

    @property
    def model(self) -> Model | None:
        """The model with all effects that were accepted; None before there are data.

        Raises
        ------
        ModelError
            If it is of a plugin that is not installed any more.
        """
        ladder = self.ladder
        if not ladder:
            return None
        return parse_model(ladder[-1])

    @property
    def excluded(self) -> tuple[int, ...]:
        """Rows that the page leaves out, from 0."""
        state = self._state
        if state is None:
            return ()
        return state.excluded

    def close(self) -> None:
        """End its workers, and take it off the page."""
        super().close()
        self._channel.close()


def _document(texts: dict[str, str]) -> str:
    """The page without what only its server has: style sheets stand within, the program comes."""
    head, rest = texts["index.html"].split("</head>")
    lines = head.splitlines()
    kept = [line for line in lines if "/page/" not in line]
    styles = f"<style>{texts['panels.css']}{texts['style.css']}</style>"
    return "\n".join([*kept, styles, "</head>"]) + rest
