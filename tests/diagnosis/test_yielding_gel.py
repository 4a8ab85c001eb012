"""An amplitude sweep of a weak gel at one frequency.

Its network breaks up, and no gel heats itself so much.
"""

import numpy as np
import pytest

import springpot

STRAIN = np.geomspace(0.001, 0.3, 10)


def softened(rng, force, length):
    """Kraus' law of a network of 25, down to its half, beside 5 + 2i.

    Kraus 1972, Rubber Chemistry and Technology 45.
    """
    u = STRAIN / 0.3
    stiffness = 5.0 + 2.0j + 25.0 * (1.0 + 0.2j * u) / (1.0 + u**2)
    real, imaginary = 0.02 * rng.normal(size=(2, len(STRAIN)))
    return springpot.Measurement(
        np.full(len(STRAIN), 2.0 * np.pi),
        stiffness * (1.0 + real + 1j * imaginary),
        conditions={"amplitude": STRAIN},
        units=springpot.Units(force, length),
    )


@pytest.fixture(scope="module")
def gel():
    return springpot.diagnose(softened(np.random.default_rng(2), "Pa", "-"))


@pytest.fixture(scope="module")
def mount():
    return springpot.diagnose(softened(np.random.default_rng(2), "kN/m", "mm"))


def row(found, effect):
    return next(row for row in found.candidates if row.effect == effect)


@pytest.mark.soak
def test_of_a_gel_the_network_leads(gel):
    assert gel.verdict == "effect-missing"
    assert gel.leading[0] == gel.best.effect == "payne"
    assert row(gel, "self-heating").probability < row(gel, "payne").probability


@pytest.mark.soak
def test_it_is_told_that_no_specimen_heats_so_much(gel):
    (note,) = [note for note in gel.notes if "no specimen reaches" in note]
    assert note.startswith("self-heating")


@pytest.mark.soak
def test_of_a_stiffness_the_size_would_decide_so_that_nothing_is_held_back(gel, mount):
    assert not any("no specimen reaches" in note for note in mount.notes)
    assert mount.leading[0] == "self-heating"
    assert row(mount, "self-heating").probability > 2.0 * row(gel, "self-heating").probability
