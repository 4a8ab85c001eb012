"""Comparisons: what fails is told, where, and what is left alone."""

import numpy as np
import pytest

import springpot
from springpot.errors import DataError, ModelError, OptionError
from springpot.measurement import Measurement, Units
from springpot.report.text import jsonable

OMEGA = 2.0 * np.pi * np.geomspace(0.5, 100.0, 40)
MAXWELL = springpot.parse_model("fractional-maxwell")
TRUTH = np.array([400.0, 60.0, 0.5])


def noisy(seed=1, level=0.01, factor=1.0, **given):
    """A fractional Maxwell damper with noise proportional to |K|."""
    exact = MAXWELL.stiffness(TRUTH, OMEGA) * factor
    rng = np.random.default_rng(seed)
    scatter = rng.normal(size=len(OMEGA)) + 1j * rng.normal(size=len(OMEGA))
    sd = level * np.abs(exact) * (1 + 1j) if given.pop("known", False) else None
    return Measurement(
        OMEGA, exact * (1 + level * scatter), sd=sd, units=Units("kN/m", "mm"), **given
    )


def found(judgement):
    return {finding.test for finding in judgement.findings if finding.found}


def test_the_right_model_holds_and_the_wrong_one_fails():
    comparison = springpot.compare(noisy(), ["fractional-kelvin", MAXWELL])
    wrong, right = comparison.judgements
    assert comparison.best is right
    assert right.delta_bic == 0.0
    assert wrong.delta_bic > 50.0
    assert wrong.fails
    assert not right.fails
    assert right.error.relative_rms / right.error.noise_floor == pytest.approx(1.0, abs=0.1)
    assert wrong.error.noise_floor == right.error.noise_floor
    assert "x the noise floor" in wrong.says
    assert "Hz" in wrong.says
    assert right.says.endswith("nothing is left but noise")


@pytest.mark.soak
@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize(("draws", "few"), [(24, 2), pytest.param(60, 3, marks=pytest.mark.soak)])
def test_noise_alone_rarely_alarms(known, draws, few):
    """Wanted are 0.5 %.

    Of 24 more than two, as of 60 more than three, have a chance of 0.03 % then.
    """
    alarms = sum(
        springpot.compare(noisy(seed, known=known), [MAXWELL]).judgements[0].fails
        for seed in range(draws)
    )
    assert alarms <= few


def test_understated_noise_is_too_much_scatter():
    data = noisy()
    bold = Measurement(OMEGA, data.stiffness, sd=0.0065 * data.magnitude * (1 + 1j))
    judgement = springpot.compare(bold, [MAXWELL]).judgements[0]
    assert "scatter" in found(judgement)


def test_storage_and_loss_are_told_apart():
    data = noisy(known=True)
    wrong = data.stiffness.real * (1 + 0.05 * np.sin(4 * np.log(OMEGA))) + 1j * data.stiffness.imag
    judgement = springpot.compare(Measurement(OMEGA, wrong, sd=data.sd), [MAXWELL]).judgements[0]
    assert {"storage alone", "runs"} <= found(judgement)
    ratios = {finding.test: finding.statistic for finding in judgement.findings}
    assert ratios["storage alone"] > 2 * ratios["loss alone"]


def test_a_trend_with_temperature_is_told_with_its_size():
    cold, hot = noisy(1, factor=1.1), noisy(2, factor=0.9)
    data = Measurement(
        np.tile(OMEGA, 2),
        np.concatenate([cold.stiffness, hot.stiffness]),
        conditions={"temperature": np.repeat([0.0, 40.0], len(OMEGA))},
    )
    judgement = springpot.compare(data, [MAXWELL]).judgements[0]
    [trend] = [
        finding for finding in judgement.findings if finding.test == "trend with temperature"
    ]
    assert trend.found
    assert "loses 18 %" in trend.says  # 0.9 / 1.1
    assert not [finding for finding in judgement.findings if finding.test == "trend with amplitude"]


def test_a_single_outlier_at_the_mains_frequency_is_named():
    data = noisy(known=True)
    row = int(np.argmin(np.abs(data.frequency - 50.0)))
    omega, stiffness = OMEGA.copy(), data.stiffness.copy()
    omega[row] = 2 * np.pi * 50.0
    stiffness[row] *= 1.12
    judgement = springpot.compare(Measurement(omega, stiffness, sd=data.sd), [MAXWELL]).judgements[
        0
    ]
    assert {"single points", "mains frequency"} <= found(judgement)
    [outlier] = [finding.says for finding in judgement.findings if finding.test == "single points"]
    assert outlier.endswith("stands out at 50 Hz (a multiple of the mains frequency)")


def test_a_correlation_is_never_beyond_one():
    """A misfit that is nothing at the ends of the sweeps.

    The pairs are larger than the points on the whole.
    """
    exact, bump = MAXWELL.stiffness(TRUTH, OMEGA), 0.3 * np.hanning(len(OMEGA))
    data = Measurement(
        np.tile(OMEGA, 2),
        np.concatenate([exact * (1 + bump), exact * (1 - bump)]),
        conditions={"temperature": np.repeat([0.0, 40.0], len(OMEGA))},
    )
    tests = springpot.compare(data, [MAXWELL]).judgements[0].findings
    [correlation] = [one.statistic for one in tests if one.test == "runs"]
    assert 0.8 < correlation <= 1.0


@pytest.mark.parametrize(
    ("power", "word"),
    [(-1.0, "Coulomb friction"), (0.0, "power-law damper"), (2.0, "cubic spring")],
)
def test_harmonics_name_the_nonlinearity(power, word):
    amplitude = np.tile(np.geomspace(0.5, 4.0, 8), 5)
    harmonics = np.zeros((40, 2), dtype=complex)
    harmonics[:, 1] = 0.1 * amplitude**power
    data = noisy(conditions={"amplitude": amplitude}, harmonics=harmonics, known=True)
    third, second = sorted(
        springpot.compare(data, [MAXWELL]).harmonics, key=lambda finding: finding.p_value
    )
    assert third.found
    assert third.test == "harmonic 3"
    assert word in third.says
    assert not second.found


def test_harmonics_as_small_as_noise_are_nothing():
    rng = np.random.default_rng(4)
    harmonics = 0.01 * (rng.normal(size=(40, 2)) + 1j * rng.normal(size=(40, 2)))
    comparison = springpot.compare(noisy(harmonics=harmonics, known=True), [MAXWELL])
    assert not any(finding.found for finding in comparison.harmonics)


def test_a_gain_of_ten_changes_nothing_but_the_moduli():
    data = noisy()
    tenfold = Measurement(OMEGA, 10 * data.stiffness)
    one, ten = (
        springpot.compare(each, ["fractional-kelvin"]).judgements[0] for each in (data, tenfold)
    )
    assert found(one) == found(ten)
    assert one.error.relative_rms == pytest.approx(ten.error.relative_rms, rel=1e-6)


def test_the_dictionary_is_plain_data():
    result = jsonable(springpot.compare(noisy(known=True), ["fractional-kelvin"]))
    assert result["schema"] == "springpot.comparison/2"
    [model] = result["models"]
    floors = {
        "noise_floor",
        "over_floor",
        "noise_source",
        "doubt",
        "material_floor",
        "material_chance",
    }
    assert set(model["error"]) == {"relative_rms", *floors}
    assert model["parameters"]["k"]["unit"] == "kN/m"
    assert all(
        set(test) == {"test", "statistic", "p_value", "found", "says"} for test in model["tests"]
    )


def test_what_cannot_be_compared_is_said():
    few = noisy().subset(np.arange(2))
    with pytest.raises(DataError, match="measure at more frequencies"):
        springpot.compare(few, ["fractional-zener"])
    with pytest.raises(OptionError, match="at least one model"):
        springpot.compare(noisy(), [])
    with pytest.raises(ModelError, match="amplitude"):
        springpot.compare(noisy(), ["fractional-maxwell + friction"])


def test_a_notebook_shows_the_comparison():
    comparison = springpot.compare(noisy(name="<b>damper</b>"), ["fractional-kelvin", MAXWELL])
    page = comparison._repr_html_()
    assert page.count("<tr>") == 3
    assert "fractional-maxwell is best" in page
    assert "nothing is left but noise" in page
    assert "fails" in page
    assert "holds" in page
    assert "<b>damper" not in page
    assert "&lt;b&gt;damper" in page
    assert ">material floor</th>" in page
    assert repr(comparison).startswith("<Comparison of <b>damper</b>: fractional-kelvin ")
