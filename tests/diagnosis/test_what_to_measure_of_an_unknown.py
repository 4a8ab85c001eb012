"""What is asked of a misfit that nothing explains: the cheapest question that is still open."""

import numpy as np
import pytest

from springpot.diagnosis.experiment import ACTION, experiment_on_unknown
from springpot.measurement import Measurement

OMEGA = np.array([1.0, 8.0, 2.0, 4.0])


def test_first_the_same_points_the_other_way_round():
    asked = experiment_on_unknown(Measurement(OMEGA, [1j] * 4))
    assert "again in the opposite order" in asked.says
    assert asked.action == {"omega": [4.0, 2.0, 8.0, 1.0]}


def test_of_very_many_points_the_first():
    omega = np.linspace(1.0, 2.0, ACTION.most + 5)
    asked = experiment_on_unknown(Measurement(omega, np.full(len(omega), 1j)))
    assert asked.action["omega"] == omega[: ACTION.most][::-1].tolist()


def repeated(**conditions):
    both = {name: np.tile(values, 2) for name, values in conditions.items()}
    return Measurement(np.tile(OMEGA, 2), [1j] * 8, repeat=np.repeat([1, 2], 4), conditions=both)


def test_of_repeats_at_one_amplitude_half_of_it():
    asked = experiment_on_unknown(repeated(amplitude=[0.4, 0.4, 0.4, 0.4]))
    assert "at half the amplitude" in asked.says
    assert asked.action["amplitude"] == pytest.approx([0.2])


@pytest.mark.parametrize("conditions", [{}, {"amplitude": [0.1, 0.4, 0.1, 0.4]}])
def test_else_something_known_in_place_of_the_specimen(conditions):
    asked = experiment_on_unknown(repeated(**conditions))
    assert "something known in place of the specimen" in asked.says
    assert not asked.action
