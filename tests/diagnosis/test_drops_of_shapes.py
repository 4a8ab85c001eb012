"""What a shape without a name takes of the misfit: by refits with and without it."""

import numpy as np
import pytest

from springpot.diagnosis.marginal import (
    DRIFT_DEGREE,
    LEAST_SEEN,
    SETTLING_TIMES,
    _creep,
    _each_alone,
    _settling,
    _step,
)
from springpot.diagnosis.scan import PARALLEL, _joint_gain
from springpot.measurement import Measurement
from springpot.misfit.frame import NoiseFrame


def frame(rng, omega, slopes=2):
    """Noise around a model with some parameters, all points of their own weight."""
    n = len(omega)
    complex_ = rng.normal(size=(slopes + 2, n)) + 1j * rng.normal(size=(slopes + 2, n))
    modelled = 10.0 + complex_[0]
    weights = rng.uniform(0.5, 2.0, n) + 1j * rng.uniform(0.5, 2.0, n)
    return NoiseFrame(Measurement(omega, modelled + complex_[1]), modelled, weights, complex_[2:])


def left_by(of, *changes):
    """Sum of squares left by the parameters and relative changes of K, by least squares."""
    columns = of.whiten(np.array([*of.jacobian, *(of.model_stiffness * c for c in changes)])).T
    size = np.linalg.lstsq(columns, of.residual)[0]
    return float(np.sum((of.residual - columns @ size) ** 2))


def test_each_alone_is_the_drop_of_a_refit(rng):
    of = frame(rng, np.geomspace(1.0, 100.0, 12))
    curves = rng.normal(size=(5, 12)) + 1j * rng.normal(size=(5, 12))
    wanted = [left_by(of) - left_by(of, curve) for curve in curves]
    np.testing.assert_allclose(_each_alone(of, curves), wanted)


def test_what_the_parameters_follow_drops_nothing(rng):
    of = frame(rng, np.geomspace(1.0, 100.0, 12))
    followed = of.jacobian[:1] / of.model_stiffness
    beside = rng.normal(size=(1, 12)) + 1j * rng.normal(size=(1, 12))
    assert _each_alone(of, followed) == 0.0
    assert _each_alone(of, followed + 0.01 * LEAST_SEEN * beside) == 0.0
    assert _each_alone(of, followed + 100.0 * LEAST_SEEN * beside) > 0.0


@pytest.mark.parametrize("levels", [2, 3, 4, 5, 9])
def test_a_step_has_two_frequencies_on_each_side(rng, levels):
    each = np.geomspace(1.0, 100.0, levels)
    of = frame(rng, np.repeat(each, 3))
    found = list(_step(of))
    assert len(found) == (levels >= 4)
    for unknown in found:
        above = [np.repeat(np.arange(levels) >= place, 3) for place in range(2, levels - 1)]
        drops = [left_by(of) - left_by(of, side.astype(float)) for side in above]
        np.testing.assert_allclose(unknown.drops, drops)
        best = int(np.argmax(drops)) + 2
        hertz = np.sqrt(each[best - 1] * each[best]) / (2.0 * np.pi)
        assert f"steps at {of.measurement.units.at(hertz)}" in unknown.says
        assert unknown.shapes == 1


def test_what_settles_is_a_gain_or_a_phase_that_falls_off_from_row_to_row(rng):
    of = frame(rng, np.geomspace(1.0, 100.0, 12))
    order = rng.permutation(12).astype(float)
    gain, phase = _settling(of, order)
    for unknown, factor in ((gain, 1.0), (phase, 1j)):
        shapes = [factor * np.exp(-order / (12 * share)) for share in SETTLING_TIMES]
        np.testing.assert_allclose(
            unknown.drops, [left_by(of) - left_by(of, shape) for shape in shapes]
        )
    assert "a gain that settles" in gain.says
    assert "a phase that settles" in phase.says


def test_creep_is_any_polynomial_but_a_constant(rng):
    along = np.sort(rng.uniform(3.0, 8.0, 20))
    curves = _creep(along)
    assert curves.shape == (DRIFT_DEGREE, 20)
    assert np.linalg.matrix_rank(np.vstack([np.ones(20), curves])) == DRIFT_DEGREE + 1
    np.testing.assert_allclose(np.abs(curves[:, [0, -1]]), 1.0)
    polynomials = np.vander(along, DRIFT_DEGREE + 1).T
    off = polynomials - polynomials @ np.linalg.pinv(np.vstack([np.ones(20), curves])) @ np.vstack(
        [np.ones(20), curves]
    )
    assert np.abs(off).max() < 1e-9 * np.abs(polynomials).max()


def test_the_joint_gain_of_two_directions_is_that_of_least_squares(rng):
    unit = rng.normal(size=(20, 9))
    unit[:, 8] = unit[:, 0] + 1e-9 * unit[:, 1]
    unit /= np.linalg.norm(unit, axis=0)
    rest = rng.normal(size=20)
    gain, first = _joint_gain(unit, rest)
    for i in range(9):
        for j in range(9):
            both = unit[:, [i, j]]
            step = np.linalg.lstsq(both, rest)[0]
            forward = abs(both[:, 0] @ both[:, 1]) < PARALLEL and np.all(step > 0.0)
            wanted = -np.inf
            if forward:
                wanted = float(np.sum((both @ step) ** 2))
                assert (first[i, j], first[j, i]) == pytest.approx(tuple(step))
            assert gain[i, j] == pytest.approx(wanted)
    assert np.any(np.isfinite(gain))
