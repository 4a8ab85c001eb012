"""What is known of each factor.

Every one is shown and marked, with its interval and the true reason.
"""

import numpy as np
import pytest
from sweeps import TEMPERATURES, material, measured, simple

import springpot
from springpot.identification import Objective
from springpot.identification.known_factors import FURTHEST
from springpot.report.told import told

pytestmark = pytest.mark.usefixtures("asked_once")


def apart(i, omega):
    """Three decades between the second and the third level, half a decade being measured."""
    return material(omega * 10.0 ** (3.0 * (i < 2)))


def flat_and_apart(i, omega):
    """Two plateaus: flat sweeps, those of the colder levels a hundred times as stiff."""
    return 1e6 * 100.0 ** (i < 2) * (1.0 + 0.02j) * np.ones_like(omega)


def glass(seed, step=3.0, points=8):
    """A decade at each of nine temperatures, 1 % of noise of each part by itself.

    The coldest are all but glass.
    """
    random, celsius = np.random.default_rng(seed), np.linspace(0.0, 80.0, 9)
    omega = np.geomspace(10.0**-0.5, 10.0**0.5, points)
    parts = []
    for i in range(9):
        branch = (1j * omega * 10.0 ** (-step * (i - 4))) ** 0.5
        stiffness = 1e6 + 3e9 * branch / (1.0 + branch)
        storage, loss = 1.0 + 0.01 * random.normal(size=(2, points))
        parts.append(stiffness.real * storage + 1j * stiffness.imag * loss)
    conditions = {"temperature": np.repeat(celsius, points)}
    return springpot.Measurement(
        np.tile(omega, 9), np.concatenate(parts), conditions=conditions, name="glass"
    )


@pytest.fixture
def parted(asked_once):
    return springpot.mastercurve(measured(apart, noise=0.003, decades=0.5))


@pytest.mark.soak
def test_the_interval_of_a_sweep_that_does_not_overlap_goes_from_where_it_would(parted):
    for level in parted.levels[:2]:
        assert (level.determined, level.reason) == (False, "no overlap")
        # The truth is at 1000; half a decade on, and it would overlap with those at one.
        assert level.a_low < 10.0**0.6 * 1.5
        assert level.a_low < 1000.0 < level.a_high
        assert np.log(level.a_high) == pytest.approx(FURTHEST)
    assert [level.reason for level in parted.levels[2:]] == ["", "", ""]


@pytest.mark.soak
def test_every_row_of_the_table_of_the_curve_is_marked(parted, tmp_path):
    springpot.write_measurement(parted.reduced, tmp_path / "curve.csv")
    again = springpot.read(tmp_path / "curve.csv")
    by_level = dict(
        zip(
            np.round(parted.reduced.conditions["measured temperature"]),
            again.conditions["determined"],
            strict=True,
        )
    )
    assert by_level == {0.0: 0.0, 15.0: 0.0, 30.0: 1.0, 45.0: 1.0, 60.0: 1.0}
    assert np.all(again.conditions["a_low"] <= again.conditions["a"])
    assert np.all(again.conditions["a"] <= again.conditions["a_high"])
    told = parted.to_dict()
    assert told["curve"]["determined"].tolist() == (again.conditions["determined"] > 0.0).tolist()
    assert [level["reason"] for level in told["levels"]] == ["no overlap", "no overlap", "", "", ""]


@pytest.mark.soak
def test_no_factor_is_left_out_of_the_text(parted):
    lines = told(parted).splitlines()
    assert sum("no: no overlap" in line for line in lines) == 2
    assert not [line for line in lines if line.lstrip().startswith(("0  -", "15  -"))]


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(3))
def test_flat_sweeps_that_do_not_overlap_are_told_not_to(seed):
    """Flat they are too; yet no shift and no vertical factor that is expected would join them."""
    curve = springpot.mastercurve(measured(flat_and_apart, noise=0.01, seed=seed))
    reasons = {
        level.value: level.reason for level in curve.levels if level.value != curve.reference
    }
    assert {reasons[0.0], reasons[15.0]} == {"no overlap"}
    assert {reasons[t] for t in (45.0, 60.0)} == {"flat"}
    (note,) = [note for note in curve.notes if "nothing to shift by" in note]
    assert note.startswith("45 degC, 60 degC")


@pytest.mark.soak
def test_sweeps_of_few_points_are_told_as_such():
    kept = measured(simple, noise=0.05, points=3, decades=0.3)
    curve = springpot.mastercurve(kept)
    assert {level.reason for level in curve.levels if not level.determined} <= {
        "too few points",
        "no overlap",
    }
    assert not [note for note in curve.notes if "too straight" in note]


@pytest.mark.soak_cases("0", "1")
@pytest.mark.parametrize("seed", range(2))
def test_the_line_follows_a_loss_that_is_hardly_a_part_of_the_modulus(seed):
    """Of a glass the loss is a ten thousandth of |K|: 1 % of |K| would leave it anywhere."""
    curve = springpot.mastercurve(glass(seed))
    line = curve.fit.model.stiffness(curve.fit.theta, curve.data.points)
    assert curve.data.loss.min() < 1e-3 * curve.data.magnitude.max()
    assert np.median(np.abs(line.imag / curve.data.loss - 1.0)) < 0.02
    assert np.max(np.abs(line.imag / curve.data.loss - 1.0)) < 0.5
    assert curve.simplicity.verdict == "simple"


@pytest.mark.soak
def test_a_line_that_misses_the_loss_is_not_called_noise():
    """As it does by an objective that knows the storage alone."""
    storage = Objective("storage", "", lambda data: 1.0 / data.magnitude.astype(complex))
    rest = springpot.mastercurve(glass(0), objective=storage).simplicity
    missed = [failure for failure in rest.failures if failure.kind == "part"]
    assert rest.verdict != "simple"
    assert max(failure.size for failure in missed) > 20.0
    assert all("misses the loss" in failure.says for failure in missed)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(2))
def test_a_part_that_scatters_as_much_as_it_is_is_not_missed(seed):
    """Noise in proportion to |K| drowns the loss of a glass.

    The line need not follow what nobody sees.
    """

    def drowned(i, omega):
        return 1e3 * (1.0 + (1e-3j * omega * np.exp(-0.1 * TEMPERATURES[i])) ** 0.5)

    rest = springpot.mastercurve(measured(drowned, noise=0.05, seed=seed)).simplicity
    assert not [failure for failure in rest.failures if failure.kind == "part"]
