"""An amplitude sweep at one frequency is two curves.

Two effects that follow them are told with a doubt.
"""

import numpy as np
import pytest

import springpot

STRAIN = np.geomspace(1e-3, 10.0, 25)


def softened(of_storage, of_loss, seed=1):
    """A polymer solution of which storage and loss fall from an onset, with a power."""
    storage, loss = (
        size / (1.0 + (STRAIN / onset) ** power)
        for size, (onset, power) in zip((0.34, 1.85), (of_storage, of_loss), strict=True)
    )
    real, imaginary = 0.003 * np.random.default_rng(seed).normal(size=(2, len(STRAIN)))
    return springpot.Measurement(
        np.full(len(STRAIN), 2.0 * np.pi),
        (storage + 1j * loss) * (1.0 + real + 1j * imaginary),
        conditions={"amplitude": STRAIN},
        units=springpot.Units("Pa", "-"),
    )


@pytest.fixture(scope="module")
def found():
    """Storage falls earlier, as it does in large shear: by none of the laws alone."""
    return springpot.diagnose(softened((3.0, 1.6), (13.0, 1.3)))


@pytest.mark.soak
def test_two_effects_leave_room_for_another_shape(found):
    """Several pairs do as well: none of them is certain."""
    assert found.verdict != "adequate"
    assert max(row.probability for row in found.candidates) < 0.71
    assert found.evidence["unknown"] > 0.29


@pytest.mark.soak
def test_one_effect_that_is_enough_leaves_none():
    """Storage and loss fall by one factor: a single law does it all."""
    told = springpot.diagnose(softened((6.0, 1.4), (6.0, 1.4)))
    assert told.verdict == "effect-missing"
    assert "another shape" not in told.says


@pytest.mark.soak
def test_no_second_effect_of_the_amplitude_is_accepted_unasked():
    ladder = springpot.discover(softened((3.0, 1.6), (13.0, 1.3)))
    accepted = [step.accepted for step in ladder.steps if step.accepted]
    assert len(accepted) <= 1
