"""The desk: answers are shared and kept, what nobody waits for is ended, a lost worker is replaced."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import pytest
from client import ask, head, raw, token_of

from springpot.web import Workbench
from springpot.web.desk import Desk

Action = Callable[[Desk], Awaitable[Any]]
AtDesk = Callable[[Action], Any]


@pytest.fixture(scope="module")
def at_desk() -> Iterator[AtDesk]:
    """Runs an action at a desk with one worker for long tasks, the same one in all tests."""
    loop, desk = asyncio.new_event_loop(), Desk(long=1)
    loop.run_until_complete(desk.open())
    yield lambda action: loop.run_until_complete(action(desk))
    loop.run_until_complete(desk.close())
    loop.close()


async def lines_of(desk: Desk, task: str, arguments: dict[str, Any], key: str = "") -> list[dict[str, Any]]:
    return [json.loads(line) async for line in desk.ask(task, arguments, "long", key)]


def opened(bench: Workbench, damper: bytes) -> dict[str, Any]:
    found: dict[str, Any] = ask(bench, "/api/data?name=damper.csv", damper)["result"]
    return found


def test_cancelled_work_is_ended_and_the_next_is_done(at_desk: AtDesk, bench: Workbench, damper: bytes):
    data = opened(bench, damper)

    async def action(desk: Desk) -> tuple[int, int, list[dict[str, Any]]]:
        stream = desk.ask("ranking", {"state": {"data": data["digest"]}, "text": data["text"]}, "long", "ranking")
        assert "stage" in json.loads(await anext(stream))
        first = desk._lanes["long"][0]._process
        await stream.aclose()
        after = await lines_of(desk, "race", {})
        return first.returncode, first.pid, after

    code, pid, after = at_desk(action)
    assert code == -signal.SIGKILL
    assert "studies" in after[-1]["result"]
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_two_who_ask_the_same_share_one_computation(at_desk: AtDesk, bench: Workbench, damper: bytes):
    data = opened(bench, damper)
    asked = {"state": {"data": data["digest"], "model": "fractional-maxwell"}, "text": data["text"]}

    async def action(desk: Desk) -> tuple[Any, ...]:
        one = desk.ask("answer", asked, "long", "same")
        await anext(one)
        other = asyncio.create_task(lines_of(desk, "answer", asked, "same"))
        await asyncio.sleep(0.05)
        running = len(desk._running)
        await one.aclose()
        lines = await other
        again = await lines_of(desk, "answer", asked, "same")
        return running, lines[-1], again

    running, last, again = at_desk(action)
    assert running == 1
    assert last["result"]["discovery"]["verdict"] == "effect-missing"
    assert again == [last]


def test_a_worker_that_dies_is_told_of_and_replaced(at_desk: AtDesk):
    async def action(desk: Desk) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
        os.kill(desk._lanes["long"][0]._process.pid, signal.SIGKILL)
        return await lines_of(desk, "race", {}), await lines_of(desk, "race", {})

    lost, after = at_desk(action)
    assert "computation" in lost[-1]["error"]
    assert "result" in after[-1]


def test_a_fault_is_told_as_one(at_desk: AtDesk, bench: Workbench):
    found = at_desk(lambda desk: lines_of(desk, "race", {"nothing": 1}))
    assert found[-1]["fault"]
    assert "not in your input" in found[-1]["error"]


def test_a_browser_that_leaves_ends_what_only_it_waited_for(bench: Workbench, damper: bytes):
    data = opened(bench, damper)
    body = json.dumps({"state": {"data": data["digest"], "seed": 77}}).encode()
    start = head(bench, "POST", "/api/ranking", X_Springpot_Token=token_of(bench), Content_Length=str(len(body)))
    with socket.create_connection(("127.0.0.1", bench.port)) as line:
        line.sendall((start.replace("\n", "\r\n") + "\r\n\r\n").encode() + body)
        assert b"stage" in line.recv(4096) + line.recv(4096)
        assert bench._desk._running
    begun = time.monotonic()
    while bench._desk._running and time.monotonic() - begun < 300:
        time.sleep(0.02)
    assert not bench._desk._running
    assert not any("ranking" in key for key in bench._desk._kept)


def test_messages_are_those_of_the_command_line(bench: Workbench, damper: bytes):
    data = opened(bench, damper)
    found = ask(bench, "/api/answer", {"state": {"data": data["digest"], "model": "fractional-maxwel"}})
    assert found == {"error": found["error"], "fault": False}
    assert "did you mean fractional-maxwell" in found["error"]
    needs = ask(bench, "/api/answer", {"state": {"data": data["digest"], "accepted": ["friction"]}})
    assert "amplitude" in needs["error"]
    gone = raw(bench, head(bench, "POST", "/api/answer", X_Springpot_Token=token_of(bench), Content_Length="30"),
               b'{"state": {"data": "unknown"}}')  # fmt: skip
    assert gone[0] == 400
    assert b"drop the file again" in gone[1]
