"""Master curves: factors, intervals, laws, what is not determined."""

import numpy as np
import pytest
from sweeps import C1, C2, LOG_A, LOG_B, REFERENCE, TEMPERATURES, material, measured, simple

import springpot
from springpot.errors import SpringpotError
from springpot.superposition import level_of

pytestmark = pytest.mark.usefixtures("asked_once")


@pytest.fixture
def found(asked_once):
    return springpot.mastercurve(measured(simple))


@pytest.mark.soak
def test_exact_data_give_exact_factors():
    curve = springpot.mastercurve(measured(simple, noise=0.0))
    np.testing.assert_allclose(curve.factors.log_a, LOG_A, atol=2e-3)
    np.testing.assert_allclose(curve.factors.log_b, LOG_B, atol=2e-3)
    assert curve.simplicity.error < 1e-3


@pytest.mark.soak
def test_intervals_hold_the_truth_as_often_as_they_say():
    """24 series with four factors each: 95 % of 96, less four standard deviations of that count."""
    inside = []
    for seed in range(24):
        factors = springpot.mastercurve(measured(simple, noise=0.01, seed=seed)).factors
        free = np.arange(len(LOG_A)) != factors.reference
        inside += (np.abs(factors.log_a - LOG_A) <= factors.reach_a)[free].tolist()
    share, sd = np.mean(inside), np.sqrt(0.95 * 0.05 / len(inside))
    assert 0.95 - 4.0 * sd <= share
    reach = factors.reach_a[free]
    assert np.all(reach < 0.5), (
        "intervals that always hold the truth because they are huge would pass"
    )


@pytest.mark.soak
def test_half_the_noise_halves_the_intervals():
    wide, narrow = (springpot.mastercurve(measured(simple, noise=n)).factors for n in (0.01, 0.005))
    ratio = np.median((wide.reach_a / np.maximum(narrow.reach_a, 1e-12))[[0, 1, 3, 4]])
    assert 1.5 < ratio < 2.7


@pytest.mark.soak
def test_another_reference_moves_all_factors_alike(found):
    moved = springpot.mastercurve(measured(simple), reference=60.0)
    assert moved.reference == 60.0
    np.testing.assert_allclose(
        moved.factors.log_a, found.factors.log_a - found.factors.log_a[-1], rtol=1e-9, atol=1e-9
    )
    assert moved.factors.reach_a[-1] == pytest.approx(0.0, abs=1e-6)
    assert moved.factors.reach_a[REFERENCE] == pytest.approx(found.factors.reach_a[-1], rel=1e-6)


def test_the_reduced_data_lie_on_the_curve_of_the_reference(found):
    at_reference = found.data.subset(np.isclose(found.data.conditions["temperature"], 30.0))
    np.testing.assert_allclose(found.curve(at_reference.omega), at_reference.stiffness, rtol=0.05)
    np.testing.assert_allclose(found.reduced.stiffness, material(found.reduced.omega), rtol=0.05)
    assert np.ptp(np.log10(found.reduced.omega)) > 4.0
    assert "temperature" not in found.reduced.conditions


def test_the_right_law_holds_and_gives_its_constants(found):
    by_name = {law.law.name: law for law in found.laws}
    wlf, arrhenius, vertical = by_name["WLF"], by_name["Arrhenius"], by_name["power of temperature"]
    assert found.laws[0].law.name in {"WLF", "VFT"}
    assert (wlf.verdict, arrhenius.verdict) == ("holds", "departs")
    truth = np.array([C1, C2])
    assert np.all((wlf.low <= truth) & (wlf.high >= truth))
    assert vertical.low[0] <= 1.0 <= vertical.high[0]


def test_vogel_is_wlf_by_another_name(found):
    by_name = {law.law.name: law for law in found.laws}
    c1, c2 = by_name["WLF"].values
    b, pole = by_name["VFT"].values
    assert b == pytest.approx(np.log(10.0) * c1 * c2, rel=1e-3)
    assert pole == pytest.approx(303.15 - c2, rel=1e-3)
    # The material is fitted anew around each law, with lines of its own.
    assert by_name["VFT"].departure == pytest.approx(by_name["WLF"].departure, rel=0.03)


@pytest.mark.soak
def test_an_activated_material_is_told_as_such():
    celsius = TEMPERATURES + 273.15
    log_a = 60.0 / 8.31446261815324e-3 * (1.0 / celsius - 1.0 / 303.15)
    curve = springpot.mastercurve(measured(lambda i, omega: material(omega * np.exp(log_a[i]))))
    first = curve.laws[0]
    assert (first.law.name, first.verdict) == ("Arrhenius", "holds")
    # How often the interval holds the truth is counted in studies/master_curve_coverage.py.
    assert first.values[0] == pytest.approx(60.0, rel=0.02)
    assert first.high[0] - first.low[0] < 6.0


def test_sweeps_that_do_not_overlap_are_named():
    """Half a decade each, three decades apart.

    Nothing says how far the cold ones are to be shifted.
    """

    def apart(i, omega):
        return material(omega * 10.0 ** (3.0 * (i < 2)))

    curve = springpot.mastercurve(measured(apart, noise=0.003, decades=0.5))
    assert curve.determined.tolist() == [False, False, True, True, True]
    (note,) = [note for note in curve.notes if "overlap" in note]
    assert note.startswith("0 degC, 15 degC: ")


@pytest.mark.soak
def test_without_vertical_factors_these_are_one():
    curve = springpot.mastercurve(measured(simple), vertical=False)
    np.testing.assert_array_equal(curve.factors.log_b, 0.0)
    np.testing.assert_array_equal(curve.factors.reach_b, 0.0)
    assert curve.simplicity.error == curve.error_without_vertical


def test_vertical_factors_lower_the_error(found):
    assert found.simplicity.error < found.error_without_vertical


def test_any_column_can_be_shifted_by():
    curve = springpot.mastercurve(measured(simple, column="water"), column="water")
    np.testing.assert_allclose(curve.factors.log_a, LOG_A, atol=0.3)
    assert curve.laws == ()
    assert curve.unit == ""


@pytest.mark.soak
def test_standard_deviations_that_all_sweeps_share_are_not_those_of_the_factors():
    data = measured(simple)
    given = data.magnitude * 0.05 * (1 + 1j)
    shared = springpot.mastercurve(
        springpot.Measurement(data.omega, data.stiffness, given, data.conditions)
    )
    plain = springpot.mastercurve(data)
    assert any("standard deviations" in note for note in shared.notes)
    np.testing.assert_allclose(shared.factors.log_a, plain.factors.log_a, atol=1e-6)
    np.testing.assert_allclose(shared.factors.reach_a, plain.factors.reach_a, rtol=1e-3)


@pytest.mark.parametrize(
    ("text", "level"),
    [
        ("25degC", 25.0),
        ("25", 25.0),
        ("-40 °C", -40.0),
        ("298.15K", 25.0),
        ("77degF", 25.0),
        ("1e1", 10.0),
    ],
)
def test_a_reference_is_written_with_or_without_its_unit(text, level):
    assert level_of(text) == pytest.approx(level)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            {"column": "salt"},
            "no column 'salt' .* the data have temperature: name one with --column",
        ),
        ({"reference": "warm"}, "no number"),
        ({"reference": "25 kN"}, "unknown unit"),
        ({"objective": "least-quares"}, "unknown objective"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(options, words):
    with pytest.raises(SpringpotError, match=words) as error:
        springpot.mastercurve(measured(simple), **options)
    assert "\n" not in str(error.value)


def test_one_frequency_is_no_sweep():
    data = measured(simple)
    single = data.subset(np.isclose(data.omega, data.omega[0]), "one frequency")
    with pytest.raises(SpringpotError, match="one frequency"):
        springpot.mastercurve(single)


def test_json_has_what_the_schema_says(found):
    told = found.to_dict()
    assert told["schema"] == "springpot.mastercurve/1"
    assert [level["value"] for level in told["levels"]] == TEMPERATURES.tolist()
    assert {"simplicity", "laws", "curve", "error", "notes", "reference", "column"} <= set(told)
    assert len(told["curve"]["omega"]) == len(found.data)


@pytest.mark.soak
def test_a_picture_is_drawn(found, tmp_path):
    assert found.plot(tmp_path / "curve.svg").stat().st_size > 10_000
    told = (tmp_path / "curve.svg").read_text(encoding="utf-8")
    # One title over both planes: a second one would be written over it.
    assert f"off, {found.simplicity.verdict.replace('-', ' ')}" in told
    assert "made at 30 degC" in told


@pytest.mark.soak
def test_the_same_data_give_the_same_bits(found, monkeypatch):
    monkeypatch.undo()  # both are worked out
    again = springpot.mastercurve(measured(simple))
    np.testing.assert_array_equal(again.factors.log_a, found.factors.log_a)
