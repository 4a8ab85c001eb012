"""Nonlinear elements in series: limits, and the balance itself."""

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.rheology import Points

AT = Points(np.log(np.geomspace(0.1, 10.0, 7)), amplitude=np.geomspace(0.2, 5.0, 7))


def test_a_mount_that_hardly_hardens_is_a_spring_in_series():
    model = parse_model("kelvin + series-spring")
    linear = model.stiffness(model.vector({"k": 2.0, "c": 1.0, "series-spring.k": 5.0}), AT)
    model = parse_model("kelvin + hardening-mount")
    theta = model.vector({"k": 2.0, "c": 1.0, "hardening-mount.k": 5.0, "hardening-mount.Xh": 1e6})
    np.testing.assert_allclose(model.stiffness(theta, AT), linear, rtol=1e-10)


def test_a_film_of_newtonian_fluid_is_a_dashpot_in_series():
    model = parse_model("kelvin + series-dashpot")
    linear = model.stiffness(model.vector({"k": 2.0, "c": 1.0, "series-dashpot.c": 0.7}), AT)
    model = parse_model("kelvin + power-law-slip")
    theta = model.vector({"k": 2.0, "c": 1.0, "power-law-slip.F": 0.7, "power-law-slip.a": 1.0})
    np.testing.assert_allclose(model.stiffness(theta, AT), linear, rtol=1e-12)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("name", ["hardening-mount", "power-law-slip"])
def test_the_parts_share_the_displacement_whatever_their_sizes(name, size):
    """K / K_e of the displacement is across the element; its law at that amplitude gives K_e."""
    model = parse_model(f"kelvin + {name}")
    second = {"hardening-mount": 1.0 / size, "power-law-slip": 0.2}[name]
    theta = model.vector(dict(zip(model.names, [2.0, 1.0, size, second], strict=True)))
    whole = model.stiffness(theta, AT)
    element = 1.0 / (1.0 / whole - 1.0 / (2.0 + 1j * AT.omega))
    across = AT.amplitude * np.abs(whole / element)
    if name == "hardening-mount":
        expected = size * (1.0 + (across / second) ** 2) + 0j
    else:
        angle = (np.arange(2**14) + 0.5) / 2**14 * 2.0 * np.pi
        first = 2.0 * np.mean(np.abs(np.cos(angle)) ** (second + 1.0))
        expected = 1j * size * first * (AT.omega * across) ** second / across
    np.testing.assert_allclose(
        whole, 1.0 / (1.0 / expected + 1.0 / (2.0 + 1j * AT.omega)), rtol=1e-6
    )


def test_an_element_between_two_amplitudes_stiffens_or_gives_way():
    twice = Points(AT.log_omega, amplitude=2.0 * AT.amplitude)
    for name, second, grows in (("hardening-mount", 1.0, True), ("power-law-slip", 0.3, False)):
        model = parse_model(f"kelvin + {name}")
        theta = np.array([2.0, 1.0, 1.0, second])
        change = np.abs(model.stiffness(theta, twice)) - np.abs(model.stiffness(theta, AT))
        assert np.all((change > 0.0) == grows)


def test_the_balance_is_found_however_far_the_element_is_from_the_model():
    model = parse_model("kelvin + power-law-slip")
    force, exponent = (
        each.ravel() for each in np.meshgrid(np.geomspace(1e-6, 1e3, 10), [0.1, 0.3, 0.7])
    )
    theta = np.column_stack([np.full(30, 2.0), np.full(30, 1.0), force, exponent])
    whole, solid = model.stiffness(theta, AT), 2.0 + 1j * AT.omega
    alone = parse_model("kelvin + power-law-damper")
    across = np.maximum(AT.amplitude * np.abs(1.0 - whole / solid), 1e-300)
    for i in range(30):
        there = Points(AT.log_omega, amplitude=across[i])
        film = alone.stiffness(np.array([2.0, 1.0, force[i], exponent[i]]), there) - solid
        seen = (
            across[i] / AT.amplitude > 1e-6
        )  # a film that hardly moves is the rounding of a difference here
        np.testing.assert_allclose(
            whole[i][seen], (1.0 / (1.0 / film + 1.0 / solid))[seen], rtol=1e-6
        )
