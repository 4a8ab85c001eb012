"""What ``springpot discover`` says to go on with, where it accepted nothing."""

import shlex

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("asked_once")


def table(write, name, head, columns):
    rows = "".join(
        ",".join(f"{value:.8g}" for value in row) + "\n" for row in zip(*columns, strict=True)
    )
    return write(f"{head}\n{rows}", name)


@pytest.fixture
def ages(write, rng):
    """A gel at four waiting times, a sweep at each."""
    omega, minutes = np.tile(np.geomspace(0.5, 10.0, 8), 4), np.repeat([5.0, 20.0, 40.0, 50.0], 8)
    stiffness = 0.006 * np.exp(minutes / 15.0) * (1j * omega) ** (1.0 - minutes / 120.0)
    stiffness = stiffness * (1.0 + 0.01 * (rng.normal(size=32) + 1j * rng.normal(size=32)))
    head = "waiting time [min],omega [rad/s],storage [Pa],loss [Pa]"
    return table(write, "ages.csv", head, (minutes, omega, stiffness.real, stiffness.imag))


@pytest.fixture
def hardening(write, rng):
    """Sweeps at six temperatures that no law joins: it relaxes more slowly when hot."""
    omega, celsius = (
        np.tile(np.geomspace(0.1, 10.0, 16), 6),
        np.repeat([20.0, 25.0, 30.0, 35.0, 40.0, 45.0], 16),
    )
    slower = np.repeat([1.0, 0.3, 0.2, 0.01, 0.008, 0.001], 16)
    stiffness = 2000.0 / (1.0 + (2j * omega / slower) ** -0.3)
    stiffness = stiffness * (1.0 + 0.003 * (rng.normal(size=96) + 1j * rng.normal(size=96)))
    head = "temperature [degC],omega [rad/s],storage [Pa],loss [Pa]"
    return table(write, "hardening.csv", head, (celsius, omega, stiffness.real, stiffness.imag))


def following(answer):
    return answer.out.splitlines()[-1]


@pytest.mark.soak
def test_one_test_of_several_is_chosen_before_their_parameters(springpot, ages):
    assert (
        following(springpot("discover", ages, "--auto"))
        == f"next: springpot diagnose {ages}@waiting_time=5"
    )


@pytest.mark.soak
def test_what_diagnose_would_accept_is_offered_where_nothing_was(springpot, hardening):
    said = f"springpot discover {hardening} --accept free-shift"
    assert following(springpot("diagnose", hardening)) == f"helps, but is no proof: {said}"
    assert following(springpot("discover", hardening, "--auto")) == f"next: {said}"


@pytest.fixture
def late(write, rng):
    """A solid in a sweep whose force comes late, and in a relaxation."""
    omega, time = np.geomspace(1.0, 100.0, 12), np.geomspace(0.01, 10.0, 20)
    stiffness = (100.0 + 50.0j * omega / (1j * omega + 10.0)) * np.exp(-3e-3j * omega)
    stiffness = stiffness * (1.0 + 0.003 * (rng.normal(size=12) + 1j * rng.normal(size=12)))
    relaxed = (100.0 + 50.0 * np.exp(-10.0 * time)) * (1.0 + 0.003 * rng.normal(size=20))
    head = "omega [rad/s],storage [Pa],loss [Pa]"
    sweep = table(write, "late.csv", head, (omega, stiffness.real, stiffness.imag))
    return f"{sweep}", f"{table(write, 'steady.csv', 'time [s],relaxation [Pa]', (time, relaxed))}"


def test_what_diagnose_offers_for_several_tests_discover_takes(springpot, late):
    few = ("--effects", "time-delay,gain-error")
    offered = following(springpot("diagnose", *late, "--model", "zener", *few))
    said = f"next: springpot discover {' '.join(late)} --model zener"
    assert offered.startswith(f"{said} --accept time-delay")
    answer = springpot(*shlex.split(offered)[2:])
    assert following(answer) == f"next: springpot identify {' '.join(late)} --model " + (
        "'zener + time-delay'"
    )


def test_several_sweeps_are_no_joint_ladder(springpot, ages):
    springpot("discover", ages, ages, "--auto").is_one_line("judged one by one")
