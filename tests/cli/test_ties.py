"""``--tie``: parameters that follow from others."""

import shlex

import numpy as np
import pytest


@pytest.fixture
def sweep(write):
    """A Zener solid, k1 = 1, k2 = 2, c = 3, with a mass of 0.01; 1 % noise."""
    omega = np.geomspace(0.1, 15.0, 15)
    s = 1j * omega
    noise = 1.0 + 0.01 * np.random.default_rng(1).normal(size=15)
    stiffness = (1.0 + 2.0 * 3.0 * s / (2.0 + 3.0 * s) + 0.01 * s**2) * noise
    rows = zip(omega, stiffness.real, stiffness.imag, strict=True)
    lines = [f"{a:.6g},{b:.9g},{c:.9g}" for a, b, c in rows]
    return write("\n".join(["omega [rad/s],storage [N/mm],loss [N/mm]", *lines]), "zener.csv")


def test_a_tie_is_told_and_goes_along(springpot, sweep):
    out = springpot("identify", sweep, "-m", "zener", "--tie", "k2 = 2*k1").out
    assert "tied        k2 = 2*k1" in out
    (line,) = (line for line in out.splitlines() if line.startswith("next: "))
    words = shlex.split(line)
    assert words[words.index("--tie") + 1] == "k2 = 2*k1"


@pytest.mark.parametrize("verb", ["identify", "diagnose", "invent"])
def test_what_is_no_tie_is_one_line(springpot, sweep, verb):
    springpot(verb, sweep, "-m", "zener", "--tie", "k2 = 2*q").is_one_line("'q'", "k1, k2, c")
    held = ("--fix", "k2=2", "--tie", "k2 = 2*k1")
    springpot(verb, sweep, "-m", "zener", *held).is_one_line("k2 is held already")
