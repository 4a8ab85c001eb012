"""A suggested command reads the data as the one did that suggests it."""

import shlex

import click
import numpy as np
import pytest

from springpot.cli.discover import again_with, command
from springpot.cli.group import springpot as group

GEOMETRY = "shear-pads area=200cm^2 gap=10mm"


@pytest.fixture
def bent(tmp_path):
    """A sweep in N/mm that no Kelvin-Voigt model follows."""
    omega = np.geomspace(1.0, 100.0, 12)
    stiffness = 50.0 + 20.0 * (1j * omega) ** 0.5
    rows = zip(omega.tolist(), stiffness.real.tolist(), stiffness.imag.tolist(), strict=True)
    text = "omega [rad/s],storage [N/mm],loss [N/mm]\n"
    path = tmp_path / "bent.csv"
    path.write_text(text + "".join(f"{w},{a},{b}\n" for w, a, b in rows), encoding="utf-8")
    return str(path)


def following(answer):
    (line,) = (line for line in answer.out.splitlines() if line.startswith("next: "))
    return shlex.split(line)


@pytest.mark.parametrize("verb", ["identify", "compare"])
def test_the_geometry_goes_along(springpot, bent, verb):
    answer = springpot(verb, bent, "--model", "kelvin", "--geometry", GEOMETRY)
    words = following(answer)
    assert words[words.index("--geometry") + 1] == GEOMETRY


def test_so_do_held_parameters_and_effects_left_out(springpot, bent):
    given = ("--fix", "k=50000", "--exclude", "frequency=12..20")
    words = following(springpot("identify", bent, "--model", "kelvin", *given))
    assert words[1:3] == ["springpot", "diagnose"]
    for option, value in (("--fix", "k=50000"), ("--exclude", "frequency=12..20")):
        assert words[words.index(option) + 1] == value


@pytest.mark.soak
def test_outputs_stay_behind(springpot, bent, tmp_path):
    figure = str(tmp_path / "fit.svg")
    words = following(springpot("identify", bent, "--model", "kelvin", "--figure", figure))
    assert "--figure" not in words


def test_a_report_is_made_again_with_all_that_was_given():
    given = ["--own", "c", "--fix", "k=5", "--geometry", GEOMETRY]
    root = click.Context(group, info_name="springpot")
    with command.make_context("discover", ["a.csv", "-m", "kelvin", "--auto", *given], root):
        again = again_with(["a.csv"], "kelvin", (), auto=True, seed=None)
    assert again[:6] == ["springpot", "discover", "a.csv", "--model", "kelvin", "--auto"]
    assert sorted(again[6:]) == sorted([*given, "--seed", "0"])
