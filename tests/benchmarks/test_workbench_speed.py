"""What the workbench adds to the computation.

From a dropped file to its answer, and from a slider to its curve.
"""

from __future__ import annotations

import json
from http.client import HTTPConnection
from time import perf_counter, process_time, sleep
from typing import Any

import numpy as np
import pytest

import springpot

pytest.importorskip("starlette", reason="the extra 'workbench' is not installed")
pytest.importorskip("uvicorn", reason="the extra 'workbench' is not installed")

from springpot.web.sessions import measured_in, text_of
from springpot.web.tasks import curve, first

MODEL = "fractional-maxwell"
POINTS = 50
REPEATS = 5
HANDS = {"k": {"value": 390.0}, "c": {"value": 60.0}, "alpha": {"value": 0.55}}


def table(seed: int, points: int = POINTS) -> bytes:
    """A damper with a moving mass, with another scatter for each seed.

    So that nothing is kept from before.
    """
    rng, frequency = np.random.default_rng(seed), np.geomspace(0.5, 50.0, points)
    s = 2j * np.pi * frequency
    exact = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * s**0.55)) + 6e-4 * s**2
    k = exact * (1 + 0.005 * (rng.normal(size=points) + 1j * rng.normal(size=points)))
    rows = "".join(
        f"{f:.6g},{v.real:.6g},{v.imag:.6g}\n" for f, v in zip(frequency, k, strict=True)
    )
    return f"frequency [Hz],storage [kN/m],loss [kN/m]\n{rows}".encode()


class Asked:
    """Requests to a workbench that has its imports behind it."""

    def __init__(self) -> None:
        self.bench = springpot.workbench(browser=False)
        self.headers = {"X-Springpot-Token": self.bench.address.partition("#token=")[2]}
        while any(worker._process is None for worker in self.workers()):
            sleep(0.01)
        self.answer(0)

    def workers(self) -> list[Any]:
        return [self.bench._desk._lanes[lane][0] for lane in ("short", "long")]

    def ask(self, path: str, body: bytes) -> Any:
        line = HTTPConnection("127.0.0.1", self.bench.port, timeout=300)
        line.request("POST", path, body, self.headers)
        last = line.getresponse().read().splitlines()[-1]
        line.close()
        return json.loads(last)["result"]

    def state(self, seed: int) -> dict[str, str]:
        return {
            "data": self.ask("/api/data?name=damper.csv", table(seed))["digest"],
            "model": MODEL,
        }

    def answer(self, seed: int) -> Any:
        return self.ask("/api/answer", json.dumps({"state": self.state(seed)}).encode())


def middle(times: list[float]) -> float:
    return sorted(times)[len(times) // 2]


def seconds(task: Any, *arguments: Any) -> float:
    begun = perf_counter()
    task(*arguments)
    return perf_counter() - begun


@pytest.mark.soak
def test_the_page_waits_little_longer_than_the_computation_takes():
    """Reading, two processes, JSON of every preview.

    Less than half of what the diagnosis itself takes.
    """
    asked = Asked()
    try:
        springpot.discover(measured_in("damper.csv", table(0))[0], MODEL, accept=[])  # imports
        served, bare = [], []
        for seed in range(1, REPEATS + 1):
            served.append(seconds(asked.answer, seed))
            measurement = measured_in("damper.csv", table(seed))[0]
            bare.append(
                seconds(lambda data: springpot.discover(data, MODEL, accept=[]), measurement)
            )
        print(
            f"from the drop to the answer {middle(served):.3f} s, "
            f"diagnosis alone {middle(bare):.3f} s"
        )
        assert middle(served) < 1.5 * middle(bare)

        state = asked.state(1)
        body = json.dumps({"state": state, "hands": HANDS}).encode()
        text = asked.ask("/api/data?name=damper.csv", table(1))["text"]
        moved = [seconds(asked.ask, "/api/curve", body) for _ in range(5 * REPEATS)]
        drawn = [seconds(curve, print, state, text, HANDS) for _ in range(5 * REPEATS)]
        print(
            f"from a slider to its curve {1e3 * middle(moved):.1f} ms, "
            f"curve alone {1e3 * middle(drawn):.1f} ms"
        )
        # A request and two processes cost a few milliseconds; the answer of a diagnosis is the
        # yardstick.
        assert middle(moved) < middle(bare) / 10
    finally:
        asked.bench.close()


@pytest.mark.soak
def test_an_answer_without_a_model_takes_less_time_than_its_points():
    """A dropped file is judged beside any material before a model is named."""
    longest, state = [], {"data": "", "model": ""}
    for points, seeds in ((POINTS, 15), (6 * POINTS, 9), (200 * POINTS, 3)):
        times = []
        for seed in range(seeds + 1):
            content, begun = table(seed, points), process_time()
            springpot.discover(measured_in("damper.csv", content)[0], accept=[])
            times.append(process_time() - begun)
        times = times[1:]  # the first has the imports
        text = text_of(measured_in("damper.csv", table(0, points))[0])
        first(print, state, text)
        begun = process_time()
        first(print, state, text)
        print(f"{points} points: a first look {process_time() - begun:.2f} s")
        longest.append(max(times))
        print(f"{points} points: {middle(times):.2f} s, the longest of {seeds} {max(times):.2f} s")
    assert longest[1] < 6.0 * longest[0]
    assert longest[2] < 200.0 * longest[0] / 10.0
