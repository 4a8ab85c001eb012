"""Starts the workbench: a free port of the loopback address, a token, then the browser.

A connection ends when the head of a request is not whole in time. uvicorn closes one that is idle
behind an answer, and the guard one whose body does not come; a client that sends half a head would
stay for ever, and enough of them would take every file that the process may open.
"""

from __future__ import annotations

import asyncio
import base64
import os
import secrets
import shutil
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from springpot.errors import OptionError, OutputError

from .server import SERVER

if TYPE_CHECKING:
    from springpot.measurement.measurement import Measurement

    from .cell import WorkbenchCell


class Punctual(H11Protocol):
    """uvicorn's connection with a deadline for the head of each request."""

    _late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a head.

        Where there are too many connections, end the one that waits longest.
        """
        super().connection_made(transport)
        self._await_head()
        if len(self.connections) > SERVER.connections:
            _end_oldest(self.connections)

    def data_received(self, data: bytes) -> None:
        """Take what came; half a head starts the clock, a whole one stops it."""
        super().data_received(data)
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the clock."""
        self._stop()
        super().connection_lost(exc)

    def _await_head(self) -> None:
        if self.conn.their_state is not h11.IDLE:
            self._stop()
        elif self._late is None and not self.transport.is_closing():
            self._late = self.loop.call_later(SERVER.patience, self.transport.close)

    def _stop(self) -> None:
        if self._late is not None:
            self._late.cancel()
            self._late = None


def _end_oldest(connections: set[Any]) -> None:
    """Close the connection that has waited longest for a head, but none that is being answered."""
    waiting = [
        (each._late.when(), each.transport) for each in connections if each._late is not None
    ]
    if waiting:
        _, transport = min(waiting, key=lambda pair: pair[0])
        transport.abort()


HOST = "127.0.0.1"


class Workbench:
    """A server that runs, and how to end it.

    Parameters
    ----------
    data : str or dict, optional
        What is open at first: a path or name as on the command line, or ``{"name", "content"}`` in
        base64.
    model : str
        Expression of the model that is judged at first; empty for any material.
    port : int
        Where to listen; 0 takes a free one.
    watch : str
        Folder whose files are watched; ``DIR?storage=Pa`` says something of all of them.

    Raises
    ------
    OutputError
        If the extra ``workbench`` is not installed.
    OptionError
        If the port is taken, or there is no such folder.
    """

    def __init__(
        self,
        data: str | dict[str, str] | None = None,
        model: str = "",
        port: int = 0,
        watch: str = "",
    ) -> None:
        try:
            import uvicorn

            from .server import Guard, Server
        except ImportError as error:
            raise OutputError(
                f"the workbench needs {error.name}: pip install 'springpot[workbench]'"
            ) from None
        # Loaded here: importing springpot.web must not load a server.
        from .desk import Desk
        from .folders import folder_of

        if watch and not folder_of(watch)[0].is_dir():
            raise OptionError(f"{watch}: there is no such folder to watch")
        # First: a port that is taken is told before anything is started.
        self._socket = _listening(port)
        # Nobody guesses 24 random bytes.
        self._token = secrets.token_urlsafe(24)
        self._desk = Desk()
        self._behind = Server(self._desk, data, model, watch)
        app = Guard(self._behind.app(), self._token)
        config = uvicorn.Config(
            app,
            http=Punctual,
            # Nothing that the page does not use.
            ws="none",
            lifespan="off",
            # The terminal is the command's: uvicorn writes nothing on it.
            log_config=None,
            access_log=False,
            server_header=False,
            date_header=False,
            # No proxy stands before it, and a header that claims one could name any client.
            proxy_headers=False,
            timeout_keep_alive=20,
            # Ctrl-C need not wait for a fit that a browser still listens to.
            timeout_graceful_shutdown=1,
        )
        self._server = uvicorn.Server(config)
        self._doors: list[Path] = []
        self._thread: threading.Thread | None = None

    @property
    def port(self) -> int:
        """Where it listens."""
        port: int = self._socket.getsockname()[1]
        return port

    @property
    def address(self) -> str:
        """What to open: the token stands behind ``#``, which a browser sends to nobody."""
        return f"http://{HOST}:{self.port}/#token={self._token}"

    def open(self) -> None:
        """Open the page in the browser.

        The browser is called with the name of a file that only this user can read and that leads to
        the address: the address itself, with its token, would stand in the list of processes, which
        all users of a machine see.
        """
        import webbrowser

        door = _door(self.address)
        self._doors.append(door)
        # A browser that talks on the terminal, or blocks it, is kept apart from this thread.
        threading.Thread(target=webbrowser.open, args=(door.as_uri(),), daemon=True).start()

    def __repr__(self) -> str:
        return f"<Workbench at {self.address}>"

    def _repr_html_(self) -> str:
        from springpot.writing import tag

        return tag(
            "p",
            "The workbench is open at ",
            tag("a", self.address, href=self.address, target="_blank"),
        )

    def run(self, ready: Callable[[], object] | None = None) -> None:
        """Serve until Ctrl-C.

        Parameters
        ----------
        ready : callable, optional
            Called when the data are there and before anything is served. Without it nothing is
            checked: the page says what is wrong.

        Raises
        ------
        DataError
            If data or model cannot be used.
        """
        asyncio.run(self._serve(ready))

    def start(self) -> Workbench:
        """Serve beside the caller, who goes on at once."""
        self._thread = threading.Thread(target=self.run, name="springpot-workbench", daemon=True)
        self._thread.start()
        return self

    def close(self) -> None:
        """End the server and its workers."""
        self._server.should_exit = True
        if self._thread is not None:
            # Not for ever: a worker that hangs must not hold the caller's program.
            self._thread.join(10.0)

    async def _serve(self, ready: Callable[[], object] | None) -> None:
        asyncio.get_running_loop().set_exception_handler(_told_once)
        # The workers first: they check the data, and import what they need while the browser opens.
        await self._desk.open()
        try:
            if ready is not None:
                await self._behind.require()
                ready()
            await self._server.serve(sockets=[self._socket])
        finally:
            await self._desk.close()
            self._socket.close()
            for door in self._doors:
                shutil.rmtree(door.parent, ignore_errors=True)


def _told_once(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Let a connection that cannot be taken pass without a word.

    Asyncio tries again, and would tell each time.
    """
    if not isinstance(context.get("exception"), OSError):
        loop.default_exception_handler(context)


def _door(address: str) -> Path:
    """A page that leads to an address, in a folder of this user alone."""
    # mkdtemp makes it with mode 0700.
    door = Path(tempfile.mkdtemp(prefix="springpot-")) / "open.html"
    with open(
        os.open(door, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8"
    ) as page:
        page.write(
            '<!doctype html><meta http-equiv="refresh" content="0;'
            f' url={address}"><title>springpot</title>'
        )
    return door


def _listening(port: int) -> socket.socket:
    # Only where the protocol is named does asyncio send small answers at once; else each waits 40
    # ms for an echo.
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    # The port of a workbench that has just ended is free at once, not only minutes later.
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
    except (OSError, OverflowError) as error:
        listening.close()
        reason = getattr(error, "strerror", None) or error
        raise OptionError(
            f"port {port} cannot be used: {reason}; leave --port out, and a free one is taken"
        ) from None
    listening.listen(128)
    return listening


def serve(
    data: str | None,
    model: str | None,
    port: int,
    browser: bool,
    tell: Callable[[Workbench], object],
    watch: str = "",
) -> None:
    """What ``springpot workbench`` does.

    Open the data, tell the address, open the browser, serve until Ctrl-C.

    Raises
    ------
    DataError
        If data or model cannot be used; what a reader merely asks, the page asks.
    """
    bench = Workbench(data, model or "", port, watch)
    asked: list[int] = []

    def end(number: int, _: object) -> None:
        asked.append(number)
        bench.close()

    def ready() -> None:
        tell(bench)
        if browser:
            bench.open()

    # A KeyboardInterrupt that is raised within a callback of the interpreter is swallowed there,
    # and the server would run on: Ctrl-C is noted instead, also by the server, which hands it on
    # here when it has ended.
    usual = signal.signal(signal.SIGINT, end)
    try:
        bench.run(ready)
    finally:
        signal.signal(signal.SIGINT, usual)
    if asked:
        raise KeyboardInterrupt


def workbench(
    measurement: Measurement | str | Path | None = None,
    model: str | None = None,
    *,
    port: int = 0,
    browser: bool | None = None,
    watch: str | Path | None = None,
) -> Workbench | WorkbenchCell:
    """Open the workbench on data, in a cell of a notebook or in the browser; returns at once.

    Parameters
    ----------
    measurement : Measurement, str or Path, optional
        The data, or their name as for `springpot.read`; without them the page asks for a file.
    model : str, optional
        Expression of the model to be judged; without it any linear passive material.
    port : int
        Where to listen on 127.0.0.1; 0 takes a free port.
    browser : bool, optional
        Whether to open the browser; not given, the page stands in the cell of a notebook where one
        runs this and the extra ``notebook`` is installed, else it opens in the browser.
    watch : str or Path, optional
        Folder that is watched: what its files gain joins the data.

    Returns
    -------
    Workbench or WorkbenchCell
        The `address` of the one is what the browser opens; the other shows itself, and its
        `model`, `ladder` and `excluded` are what the page shows. `close` ends either, and it ends
        with the program, too.

    Raises
    ------
    OutputError
        If the extra ``workbench`` is not installed.
    OptionError
        If the port is taken, or there is no such folder.

    Examples
    --------
    >>> import springpot
    >>> bench = springpot.workbench("artificial-hidden", "fractional-maxwell", browser=False)
    >>> bench.address.startswith("http://127.0.0.1:")
    True
    >>> bench.close()
    """
    data: Any = None
    if measurement is not None and isinstance(measurement, str | Path):
        # Opened by a worker, as what the command line names.
        data = str(measurement)
    elif measurement is not None:
        # A measurement that is no file crosses to the workers as the text of one.
        from .sessions import text_of

        content = base64.b64encode(text_of(measurement).encode()).decode()
        data = {"name": f"{measurement.name}.csv", "content": content}
    if browser is None and _in_notebook():
        from .cell import WorkbenchCell

        return WorkbenchCell(data, model or "", str(watch or ""))
    bench = Workbench(data, model or "", port, str(watch or "")).start()
    if browser is not False:
        bench.open()
    return bench


def _in_notebook() -> bool:
    """Whether a cell can show a page: a kernel runs this program, and the extra is installed."""
    if find_spec("anywidget") is None:
        return False
    # Looked for among what is loaded: a kernel has loaded itself long since.
    marimo = sys.modules.get("marimo")
    return "ipykernel" in sys.modules or (marimo is not None and marimo.running_in_notebook())
