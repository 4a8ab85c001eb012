"""Of a spectrum the places of the lines follow the noise as well as their weights."""

import numpy as np
import pytest

import springpot
from springpot.identification.native import Fit
from springpot.identification.problem import relative_objective
from springpot.rheology import Continuum, Model, Points

SD = 0.005


def fitted(omega, noise):
    """The fit of any material to a springpot beside a spring, both of known noise (n,)."""
    exact = 1e3 + 2e3 * (1j * omega) ** 0.4
    found = springpot.identify(springpot.Measurement(omega, exact * (1.0 + noise)), "material")
    values = found.fit.model.stiffness(found.theta, found.fit.measurement.points) / exact - 1.0
    return found.fit, np.concatenate([values.real, values.imag])


def test_a_spectrum_leaves_as_much_of_known_noise_as_its_degrees_of_freedom_say():
    omega, left, free = np.geomspace(0.03, 30.0, 20), [], []
    for seed in range(24):
        drawn = np.random.default_rng(seed).normal(size=(2, 20))
        fit, _ = fitted(omega, SD * (drawn[0] + 1j * drawn[1]))
        # Less what the draws have by chance more than their number.
        left.append(fit.cost / SD**2 - np.sum(drawn**2) + 40.0)
        free.append(fit.dof)
    assert np.mean(left) == pytest.approx(np.mean(free), abs=0.6)


def test_degrees_of_freedom_are_those_of_how_the_curve_follows_the_data():
    """Numbers measured less tr(2 S - S S'), S the map from noise to curve, here by differences."""
    omega = np.geomspace(10.0**-0.75, 10.0**0.75, 8)
    drawn = np.random.default_rng([2, 8]).normal(size=(2, 8))
    noise, step = SD * (drawn[0] + 1j * drawn[1]), 0.3 * SD
    rows = []
    for part in (1.0, 1j):
        for row in np.eye(8):
            ends = (fitted(omega, noise + sign * step * part * row)[1] for sign in (1.0, -1.0))
            rows.append(np.subtract(*ends) / (2.0 * step))
    follows = np.array(rows)
    fit, _ = fitted(omega, noise)
    spent = np.trace(2.0 * follows - follows.T @ follows)
    assert 16.0 - fit.dof == pytest.approx(spent, abs=0.3)


def test_of_exact_data_something_is_left():
    fit, _ = fitted(np.geomspace(0.03, 30.0, 20), np.zeros(20))
    assert fit.dof >= 1.0


@pytest.mark.parametrize(("weights", "alone"), [([2.0, 1.0, 1.0], 1), ([2.0, 0.0, 1.0], 2)])
def test_lines_side_by_side_are_moved_by_their_weights(weights, alone):
    """Of a line that stands alone on exact data the place is a parameter like any other."""
    model, theta = Model("material", Continuum((0.1, 1.0, 1.02))), np.array([3.0, 0.0, *weights])
    points = Points.at(np.geomspace(0.01, 10.0, 12))
    exact = springpot.Measurement(points.omega, model.stiffness(theta, points))
    fit = Fit(model, exact, relative_objective(), theta, 0.0)
    carrying = int(np.sum(theta > 0.0))
    assert 24.0 - carrying - fit.dof == pytest.approx(alone, abs=1e-3)
