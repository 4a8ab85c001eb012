"""The desk: answers are shared and kept, unawaited work is ended, lost workers are replaced."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import threading
import time
from typing import Any

import pytest
from client import ask, head, raw, token_of

from springpot.web import Workbench
from springpot.web.desk import DeskWorker
from springpot.web.sessions import State
from springpot.web.tasks import TASKS, perform

PATIENCE = 300.0


@pytest.fixture(scope="module")
def data(bench: Workbench, damper: bytes) -> dict[str, Any]:
    found: dict[str, Any] = ask(bench, "/api/data?name=damper.csv", damper)["result"]
    return found


def asking(bench: Workbench, task: str, body: dict[str, Any]) -> socket.socket:
    """A connection on which a task was asked for and told its first stage."""
    content = json.dumps(body).encode()
    start = head(
        bench,
        "POST",
        f"/api/{task}",
        X_Springpot_Token=token_of(bench),
        Content_Length=str(len(content)),
    )
    line = socket.create_connection(("127.0.0.1", bench.port), timeout=PATIENCE)
    line.sendall((start.replace("\n", "\r\n") + "\r\n\r\n").encode() + content)
    heard = b""
    while b"stage" not in heard:
        part = line.recv(4096)
        assert part, heard
        heard += part
    return line


def working(bench: Workbench) -> Any:
    """The process that computes; of the free ones there is none among those that were taken."""
    desk = bench._desk
    free = list(desk._free["long"]._queue)
    [busy] = [worker for worker in desk._lanes["long"] if worker not in free]
    return busy._process


@pytest.mark.soak
def test_two_who_ask_the_same_share_one_computation(bench: Workbench, data: dict[str, Any]):
    state = {"data": data["digest"], "model": "fractional-maxwell"}
    key = f"answer {State.of(state).key}"
    with asking(bench, "answer", {"state": state}):
        answers: list[dict[str, Any]] = []
        other = threading.Thread(
            target=lambda: answers.append(ask(bench, "/api/answer", {"state": state}))
        )
        other.start()
        begun = time.monotonic()
        while len(bench._desk._running[key].listeners) < 2 and time.monotonic() - begun < PATIENCE:
            time.sleep(0.005)
        assert len(bench._desk._running) == 1
    other.join()  # the first has left; the second still gets its answer
    assert answers[0]["result"]["discovery"]["verdict"] == "effect-missing"
    assert key in bench._desk._kept
    assert ask(bench, "/api/answer", {"state": state}) == answers[0]


def test_a_worker_that_dies_is_told_of_and_replaced(bench: Workbench, data: dict[str, Any]):
    with asking(bench, "ranking", {"state": {"data": data["digest"]}}) as line:
        os.kill(working(bench).pid, signal.SIGKILL)
        heard = b""
        while part := line.recv(4096):
            heard += part
    assert b"computation ended" in heard
    assert b"fault" in heard


def test_of_a_worker_that_was_ended_nothing_is_left_open():
    """Its pipes were closed as rubbish, after the loop, which could do so no more."""

    async def serve() -> list[bool]:
        worker, pipes = DeskWorker(), []
        for _ in "ab":
            await worker.start()
            assert worker._process is not None
            pipes.append(worker._process._transport)
            worker.end()
        await worker.close()
        return [each.is_closing() for each in pipes]

    assert asyncio.run(serve()) == [True, True]


@pytest.mark.soak
def test_a_browser_that_leaves_ends_what_only_it_waited_for(bench: Workbench, data: dict[str, Any]):
    with asking(bench, "ranking", {"state": {"data": data["digest"], "seed": 77}}):
        process = working(bench)
    begun = time.monotonic()
    while bench._desk._running and time.monotonic() - begun < PATIENCE:
        time.sleep(0.02)
    assert not bench._desk._running
    assert not any("ranking" in key for key in bench._desk._kept)
    while process.returncode is None and time.monotonic() - begun < PATIENCE:
        time.sleep(0.02)
    assert process.returncode == -signal.SIGKILL


def test_a_fault_is_told_as_one():
    found = perform("race", {"nothing": 1}, print)
    assert found["fault"]
    assert "not in your input" in found["error"]


def test_a_fault_of_many_words_is_told_in_four_hundred_signs(monkeypatch: pytest.MonkeyPatch):
    def failing(told: object) -> None:
        raise ValueError("no end " * 1000)

    monkeypatch.setitem(TASKS, "race", failing)
    assert len(perform("race", {}, print)["error"]) == 400


@pytest.mark.soak
def test_messages_are_those_of_the_command_line(bench: Workbench, data: dict[str, Any]):
    found = ask(
        bench, "/api/answer", {"state": {"data": data["digest"], "model": "fractional-maxwel"}}
    )
    assert found == {"error": found["error"], "fault": False}
    assert "did you mean fractional-maxwell" in found["error"]
    needs = ask(bench, "/api/answer", {"state": {"data": data["digest"], "accepted": ["friction"]}})
    assert "amplitude" in needs["error"]
    gone = raw(
        bench,
        head(bench, "POST", "/api/answer", X_Springpot_Token=token_of(bench), Content_Length="30"),
        b'{"state": {"data": "unknown"}}',
    )
    assert gone[0] == 400
    assert b"drop the file again" in gone[1]
