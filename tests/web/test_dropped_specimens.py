"""Files that were dropped together are specimens: each with parameters of its own."""

from __future__ import annotations

from functools import cache, reduce

import numpy as np
import pytest

import springpot
from springpot.web.sessions import State, data_of, joined, measured_in, text_of
from springpot.web.tasks import answer, curve, first, ladder_of
from springpot.web.trying import scene_of

STIFF = (100.0, 120.0, 150.0)
OMEGA = np.geomspace(1.0, 30.0, 9)
T = np.geomspace(0.1, 30.0, 16)


@cache
def sweeps(jitter=0.0):
    """A sweep of each specimen in a file, opened one onto the other as the page does."""
    files = []
    for i, stiff in enumerate(STIFF):
        rng, omega = np.random.default_rng(i), OMEGA * (1.0 + jitter * i)
        seen = (stiff + 3j * omega) * (1.0 + 0.005 * rng.standard_normal((9, 2)) @ [1.0, 1.0j])
        rows = zip(omega / 2.0 / np.pi, seen, strict=True)
        lines = [f"{f:.8g},{k.real:.6g},{k.imag:.6g}\n" for f, k in rows]
        files.append("frequency [Hz],storage [kN/m],loss [kN/m]\n" + "".join(lines))
    return opened(files)


@cache
def relaxations():
    """The same of a relaxation of each."""
    files = []
    for i, stiff in enumerate(STIFF):
        seen = stiff * (1.0 + np.exp(-T / 2.0))
        seen *= 1.0 + 0.003 * np.random.default_rng(i).standard_normal(16)
        lines = [f"{t:.6g},{g:.6g}\n" for t, g in zip(T, seen, strict=True)]
        files.append("time [s],relaxation [kPa]\n" + "".join(lines))
    return opened(files)


def opened(files):
    whole = [measured_in(f"S{i}.csv", text.encode())[0] for i, text in enumerate(files, 1)]
    return data_of(text_of(reduce(joined, whole)))


def ends(told):
    """The first and the last of storage on each curve."""
    curves = [np.array(each["storage"]) for each in told["model"]["curves"]]
    return np.array([curve[[0, -1]] for curve in curves])


@pytest.mark.soak
def test_each_sweep_has_a_stiffness_of_its_own_and_is_drawn_with_it():
    """At frequencies that nearly agree, as instruments have them: no repeats are told."""
    data, state = sweeps(jitter=0.001), State("x", "kelvin", options="--own k")
    told = answer(state, ladder_of(state, data), data)
    assert [one["name"] for one in told["parameters"]] == ["k_1", "k_2", "k_3", "c"]
    assert told["discovery"]["verdict"] == "adequate"
    assert ends(told) == pytest.approx(np.column_stack([STIFF, STIFF]), rel=0.01)
    known = springpot.identify(data, "kelvin", own={"k": "file"})
    assert told["discovery"]["steps"][0]["relative_rms"] == pytest.approx(known.relative_rms)
    assert (
        first(print, state.to_dict(), text_of(data))["discovery"]["diagnosis"]["error"][
            "over_floor"
        ]
        < 1.5
    )
    # As the page has drawn them before anything was said of specimens.
    for together in (data, sweeps()):
        page = scene_of(State("x", "kelvin"), together).to_dict()
        assert [each["label"] for each in page["sweeps"]] == ["file S1", "file S2", "file S3"]
        stiff = np.array(page["storage"]).reshape(3, 9).mean(axis=1)
        assert stiff == pytest.approx(STIFF, rel=0.01)


@pytest.mark.soak
def test_a_specimen_that_is_left_out_takes_no_other_ones_parameters():
    data, state = sweeps(), State("x", "kelvin", excluded=tuple(range(9)), options="--own k")
    told = answer(state, ladder_of(state, data), data)
    assert [one["name"] for one in told["parameters"]] == ["k_1", "k_2", "c"]
    assert ends(told)[1:, 0] == pytest.approx(STIFF[1:], rel=0.01)


@pytest.mark.soak
def test_each_test_in_time_has_its_own_and_is_drawn_with_it():
    data, state = relaxations(), State("x", "zener", options="--own k1,k2,c")
    told = answer(state, ladder_of(state, data), data)
    assert len(told["parameters"]) == 9
    assert ends(told)[:, 1] == pytest.approx(STIFF, rel=0.02)
    error = first(print, state.to_dict(), text_of(data))["discovery"]["steps"][0]["relative_rms"]
    assert error == pytest.approx(told["discovery"]["steps"][0]["relative_rms"], rel=0.01)
    hands = {one["name"]: {"value": one["value"]} for one in told["parameters"]}
    moved = curve(print, state.to_dict(), text_of(data), hands)
    assert moved["curves"] == told["model"]["curves"]
    # The first file is left out wholly: the others are numbered as a fit of them numbers them.
    rest = State("x", "zener", excluded=tuple(range(16)), options="--own k1,k2,c")
    assert [test.marks["file"] for test in scene_of(rest, data).tests] == [3.0, 1.0, 2.0]
