"""Guard, desk and sessions of the workbench by hand: no server and no worker is started."""

from __future__ import annotations

import asyncio
import json
import os
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import Measurement, Units
from springpot.web import desk, server, sessions, worker
from springpot.web.sessions import State

TOKEN = "right"


def _ran(coroutine: Any) -> Any:
    """In a thread of its own: the tests in a browser leave a loop running in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, coroutine).result()


def asked(
    path: str = "/api/x", largest: int = 100, body: tuple[bytes, ...] = (b"",), **headers: str
) -> tuple[int, dict[bytes, bytes], bytes]:
    """Status, headers and body of what a guarded application answers that echoes its body."""

    async def echo(scope: Any, receive: Any, send: Any) -> None:
        taken, more = b"", True
        while more:
            message = await receive()
            taken, more = taken + message.get("body", b""), message.get("more_body", False)
        await send({"type": "http.response.start", "status": 200, "headers": [(b"a", b"b")]})
        await send({"type": "http.response.body", "body": taken})

    told: list[Any] = []
    parts = list(body)

    async def receive() -> Any:
        part = parts.pop(0)
        return {"type": "http.request", "body": part, "more_body": bool(parts)}

    async def send(message: Any) -> None:
        told.append(message)

    plain = {"host": "127.0.0.1:80", server.TOKEN.decode(): TOKEN}
    sent = [(k.replace("_", "-").encode(), v.encode()) for k, v in (plain | headers).items() if v]
    scope = {"type": "http", "path": path, "headers": sent}
    _ran(server.Guard(echo, TOKEN, largest)(scope, receive, send))
    return told[0]["status"], dict(told[0]["headers"]), told[1]["body"]


@pytest.mark.parametrize(
    ("given", "status"),
    [
        ({}, 200),
        ({"host": "localhost"}, 200),
        ({"host": "localhost:1"}, 200),
        ({"host": "evil.org:80"}, 400),
        ({"host": ""}, 400),
        ({"origin": "http://127.0.0.1:80"}, 200),
        ({"origin": "http://127.0.0.1"}, 403),
        ({"origin": "https://127.0.0.1:80"}, 403),
        ({"sec_fetch_site": "same-origin"}, 200),
        ({"sec_fetch_site": "none"}, 200),
        ({"sec_fetch_site": "cross-site"}, 403),
        ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "navigate"}, 403),
        ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "navigate", "path": "/"}, 200),
        ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "cors", "path": "/"}, 403),
        ({server.TOKEN.decode(): "wrong"}, 401),
        ({server.TOKEN.decode(): ""}, 401),
        ({server.TOKEN.decode(): "", "path": "/app.js"}, 200),
        ({"content_length": "100"}, 200),
        ({"content_length": "101"}, 413),
        ({"content_length": "-1"}, 413),
    ],
)
def test_who_is_let_through(given, status):
    found, headers, _ = asked(**given)
    assert found == status
    # On every answer.
    assert headers[b"x-frame-options"] == b"DENY"


def test_a_body_is_taken_up_to_its_size():
    assert asked(body=(b"a" * 60, b"b" * 40))[::2] == (200, b"a" * 60 + b"b" * 40)
    status, headers, body = asked(body=(b"a" * 60, b"b" * 41))
    assert (status, headers[b"connection"]) == (413, b"close")
    assert body == b"more than 0 MiB at once are not taken: leave out what is not needed\n"


def test_two_clocks_run_while_a_body_comes(monkeypatch):
    waits = []

    class Timeout:
        def __init__(self, seconds):
            waits.append(seconds)

        async def __aenter__(self):
            return self

        async def __aexit__(self, *_):
            return False

    now = [100.0]

    class Loop:
        def time(self):
            return now[0]

    monkeypatch.setattr(server.asyncio, "timeout", Timeout)
    monkeypatch.setattr(server.asyncio, "get_running_loop", Loop)

    async def receive():
        return {"body": b"", "more_body": now[0] < 300.0}

    limited = server._limited(receive, 10, {})

    async def several():
        for at in (100.0, 100.0 + server.SERVER.longest - 1.0, 300.0 + server.SERVER.longest):
            now[0] = at
            await limited()
        # The whole body is there: what follows is waited for as long as a fit takes.
        await limited()

    _ran(several())
    assert waits == [server.SERVER.patience, 1.0, -200.0]


def test_a_header_that_stands_twice_is_refused_where_it_matters():
    scope = {"headers": [(b"accept", b"a"), (b"accept", b"b")]}
    assert server._headers_of(scope) == {b"accept": b"b"}
    for name in (b"host", b"origin", server.TOKEN, b"content-length"):
        with pytest.raises(server.Refusal, match="stands twice"):
            server._headers_of({"headers": [(name, b"1"), (name, b"1")]})


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ({"error": "a.csv: no such file", "fault": False}, "no such file"),
        # Of a fault of ours the page tells more than a line.
        ({"error": "a fault in springpot", "fault": True}, ""),
        ({"result": {}}, ""),
    ],
)
@pytest.mark.parametrize("named", [{"data": "a.csv"}, {"model": "kelvin"}, {}])
def test_what_is_named_wrongly_ends_the_command(line, says, named):
    class Told:
        async def ask(self, task, arguments):
            assert arguments["spec"] == named.get("data", "")
            yield json.dumps(line).encode()

    running = server.Server(Told(), **named)
    if says and named:
        with pytest.raises(DataError, match=says):
            _ran(running.require())
    else:
        _ran(running.require())


# Desk ---------------------------------------------------------------------------------------------


class Ready:
    """A worker that answers with given lines."""

    alive = True

    def __init__(self, *lines: bytes) -> None:
        self.lines, self.started = list(lines), 0

    async def start(self) -> None:
        self.started += 1

    async def perform(self, task: str, arguments: Any, told: Any) -> bytes:
        await asyncio.sleep(0)
        while self.lines[0].startswith(b'{"stage"'):
            told(self.lines.pop(0))
            await asyncio.sleep(0)
        return self.lines.pop(0)

    async def close(self) -> None:
        self.alive = False


def answers(worker: Ready, keys: list[str], together: bool = False) -> list[list[bytes]]:
    """The lines that each of some askers hears."""

    async def all_of_them() -> list[list[bytes]]:
        bench = desk.Desk()
        bench._lanes = {"short": [worker]}
        await bench.open()

        async def heard(key: str) -> list[bytes]:
            return [line async for line in bench.ask("task", {}, key=key)]

        if together:
            found = list(await asyncio.gather(*map(heard, keys)))
        else:
            found = [await heard(key) for key in keys]
        await bench.close()
        assert bench._running == {}
        return found

    return _ran(all_of_them())


STAGE, ONE, TWO = b'{"stage": "fit"}\n', b'{"result": 1}\n', b'{"result": 2}\n'
FAULT = b'{"error": "no"}\n'


def test_an_answer_is_kept_by_its_key_and_an_error_is_not():
    assert answers(Ready(STAGE, ONE, TWO), ["a", "a", "b"]) == [[STAGE, ONE], [ONE], [TWO]]
    assert answers(Ready(FAULT, TWO), ["a", "a"]) == [[FAULT], [TWO]]
    assert answers(Ready(ONE, TWO), ["", ""]) == [[ONE], [TWO]]


def test_who_asks_the_same_at_once_hears_the_same():
    assert answers(Ready(STAGE, ONE), ["a", "a"], together=True) == [[STAGE, ONE]] * 2


def test_who_waits_hears_the_place_in_the_queue():
    results = [b'{"result": %d}\n' % number for number in range(5)]
    heard = answers(Ready(*results), list("abcde"), together=True)
    assert [lines[-1] for lines in heard] == results
    told = [json.loads(line)["stage"] for line in heard[-1][:-1]]
    places = [int(stage.split("place ")[1].split()[0]) for stage in told]
    assert places == sorted(places, reverse=True)
    assert (places[0], places[-1]) == (4, 1)
    assert heard[0] == results[:1]


def test_the_newest_answers_are_kept_up_to_their_size(monkeypatch):
    monkeypatch.setattr(desk, "KEPT", 10)
    bench = desk.Desk()
    for key, size in (("a", 4), ("b", 6), ("c", 1)):
        bench._keep(key, b"x" * size)
    assert list(bench._kept) == ["b", "c"]
    bench._keep("d", b"x" * 50)
    assert list(bench._kept) == ["d"]
    assert json.loads(desk._error("no")) == {"error": "no", "fault": True}


# Sessions and states ------------------------------------------------------------------------------

OMEGA = np.array([1.0, 2.0, 5.0, 9.0])
DATA = Measurement(OMEGA, 3.0 + 1j * OMEGA, units=Units("kN/m", "mm"), name="made")
DIGEST = "0" * 64


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({}, ""),
        ({"model": "x" * 1000}, ""),
        ({"model": "x" * 1001}, "is no name"),
        ({"model": 3}, "is no name"),
        ({"accepted": "ab"}, "a list is wanted"),
        ({"excluded": [3, 1, 3]}, ""),
        ({"excluded": [-1]}, "is no whole number"),
        ({"excluded": [True]}, "is no whole number"),
        ({"excluded": [1.0]}, "is no whole number"),
        ({"seed": -1}, "is no whole number"),
        ({"data": None}, "is no name"),
    ],
)
def test_a_state_is_of_its_kinds(more, says):
    if says:
        with pytest.raises(DataError, match=says):
            State.of({"data": DIGEST} | more)
        return
    state = State.of({"data": DIGEST} | more)
    assert state.excluded == ((1, 3) if "excluded" in more else ())
    assert len(state.key) == 64


def test_a_state_as_it_is_typed():
    assert State(DIGEST).expression == "material"
    grown = State(DIGEST, "kelvin", ("inertia",)).accepting("series: X^n/k + 1")
    assert grown.accepted == ("inertia", "series: X^n/k + 1")
    assert grown.expression == "kelvin + inertia + (series: X^n/k + 1)"
    assert State(DIGEST, "kelvin", ("(a = chain: 1 + b)",)).expression == (
        "kelvin + (a = chain: 1 + b)"
    )


def session(**changed: Any) -> bytes:
    state = {"data": "x", "model": "kelvin"}
    plain = {
        "schema": sessions.SCHEMA,
        "data": {"source": "a.csv", "text": "text"},
        "branches": [{"name": "first", "states": [state, state], "at": 1}],
        "branch": 0,
        "view": {"plane": "storage", "zoom": 2.5},
    }
    return json.dumps(plain | changed).encode()


def test_a_session_holds_what_the_page_expects(stays):
    state = {"data": "x"}
    branch = {"name": "n" * 60, "states": [state] * 3, "at": 999}
    view = {"right": "v", "list": [1]}
    found = sessions.session_of(session(branches=[branch] * 2, branch=77, view=view))
    kept = {"branch": found["branch"], "at": found["branches"][0]["at"], "view": found["view"]}
    before = sessions.session_of(session(branches=[branch | {"at": -4}], branch=-3))
    plain = sessions.session_of(session())
    stays({"kept": kept, "before": [before["branch"], before["branches"][0]["at"]], "plain": plain})


@pytest.mark.parametrize(
    "changed",
    [
        {"schema": "other/1"},
        {"data": {"text": 3}},
        {"branches": []},
        {"branches": [{"states": []}]},
        {"branches": 3},
        {"view": 3},
    ],
)
def test_what_no_page_has_written_is_no_session(changed):
    with pytest.raises(DataError, match="this is no session of the workbench"):
        sessions.session_of(session(**changed))


def test_a_session_is_known_by_its_schema():
    assert sessions.is_session(b"  " + session())
    assert not sessions.is_session(b"x" + session())
    assert not sessions.is_session(b"{}")


def test_rows_are_left_out_that_are_there():
    assert sessions.kept(DATA, ()) is DATA
    assert sessions.kept(DATA, (0, 3)).omega.tolist() == [2.0, 5.0]
    with pytest.raises(DataError, match="has 4 points; there is no point 4 in it"):
        sessions.kept(DATA, (4,))
    with pytest.raises(DataError, match="all points are left out"):
        sessions.kept(DATA, (0, 1, 2, 3))


def test_what_was_measured_twice_alone_is_a_repeat():
    other = Measurement(OMEGA + 0.5, DATA.stiffness, units=DATA.units, name="further")
    assert sessions._one_table(DATA, other).repeat is None
    again = Measurement(OMEGA, 1.01 * DATA.stiffness, units=DATA.units, name="again")
    both = sessions._one_table(DATA, again)
    assert both.repeat is not None
    assert both.provenance["joined with"] == "again"
    with pytest.raises(DataError, match="stand in the open data already"):
        sessions._one_table(DATA, DATA.subset(np.arange(2), "part"))
    known = sessions._one_table(both, other)
    assert known.repeat is not None


def test_what_foreign_code_prints_is_no_answer(monkeypatch, capfd):
    monkeypatch.setattr(worker.sys, "stdin", [])
    monkeypatch.setattr(worker.signal, "signal", lambda *given: None)
    installed = SimpleNamespace(shelf=lambda word: None)
    monkeypatch.setattr("springpot.registry.plugins", lambda: installed)
    kept = os.dup(1)
    try:
        worker.main()
        os.write(1, b"a word of a plugin")
    finally:
        os.dup2(kept, 1)
        os.close(kept)
    told = capfd.readouterr()
    assert json.loads(told.out) == {"ready": True}
    assert "a word of a plugin" in told.err
