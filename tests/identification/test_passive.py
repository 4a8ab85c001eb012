"""What a sum of relaxations follows is a part of any material.

Masses, constant losses and instruments are not.
"""

import pytest

import springpot
from springpot.identification import is_passive, within_material

PASSIVE = {
    "parallel-spring",
    "parallel-dashpot",
    "parallel-springpot",
    "relaxation-mode",
    "retardation-mode",
    "diffusion",
    "series-spring",
    "series-dashpot",
    "series-springpot",
}
NOT_PASSIVE = {
    "inertia",
    "hysteretic-loss",
    "basset",
    "frame-resonance",
    "specimen-inertia",
    "time-delay",
    "friction",
    "wlf-shift",
}


@pytest.mark.parametrize("name", sorted(PASSIVE))
def test_relaxing_parts(name):
    assert is_passive(springpot.plugins().effect(name))


@pytest.mark.parametrize("name", sorted(NOT_PASSIVE))
def test_what_no_relaxation_does(name):
    assert not is_passive(springpot.plugins().effect(name))


def test_diffusion_is_nothing_new_beside_any_material():
    """Its spectrum is a row of lines without end, and a free spectrum follows it like any other."""
    diffusion = springpot.plugins().effect("diffusion")
    assert within_material(springpot.parse_model("material"), diffusion)
    assert not within_material(springpot.parse_model("fractional-zener"), diffusion)
