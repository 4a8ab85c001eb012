"""Intervals of effects around any material: as narrow as the data allow, and true."""

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.identification import Uncertainty, fit, intervals_beside_material
from springpot.identification.held_material import ends_of_amounts

MASS = 1.8e-3
"""In N s^2/mm, as K is in N/mm: 1.8 kg."""
HEAVY = springpot.parse_model("material + inertia")


def heavy(seed: int, noise: float = 0.014) -> springpot.Measurement:
    """A specimen of 150 to 1050 N/mm with a mass, 20 points from 5 to 100 Hz."""
    omega = 2 * np.pi * np.geomspace(5.0, 100.0, 20)
    stiffness = 1 / (1 / 900 + 1 / (150 + 12 * (1j * omega) ** 0.5)) - MASS * omega**2
    real, imaginary = noise * np.random.default_rng(seed).normal(size=(2, 20))
    return springpot.Measurement(
        omega, stiffness * (1 + real + 1j * imaginary), units=springpot.Units("N/mm", "mm")
    )


@pytest.mark.soak
def test_a_mass_beside_any_material_is_known_to_a_part_of_its_size():
    inside = 0
    for seed in range(12):
        known = Uncertainty.of(fit(HEAVY, heavy(seed)))
        low, high = (float(end[-1]) for end in intervals_beside_material(known))
        inside += low <= MASS <= high
        assert low < known.fit.theta[-1] < high < 1.15 * low
    # 95 % intervals: of twelve three or more miss once in fifty such tests.
    assert inside >= 10


def test_more_noise_makes_the_interval_wider():
    ends = [
        intervals_beside_material(Uncertainty.of(fit(HEAVY, heavy(1, noise))))
        for noise in (0.003, 0.03)
    ]
    quiet, noisy = (float(high[-1] - low[-1]) for low, high in ends)
    assert noisy > 3 * quiet


def test_two_effects_each_have_their_own_interval():
    both = springpot.parse_model("material + inertia + time-delay")
    known = Uncertainty.of(fit(both, heavy(2)))
    low, high = intervals_beside_material(known)
    for name, truth in (("inertia.m", MASS), ("time-delay.tau", 0.0)):
        i = both.names.index(name) - len(both.names)
        assert low[i] <= truth <= high[i]


def test_a_model_with_a_name_keeps_its_own_intervals():
    known = Uncertainty.of(fit(springpot.parse_model("fractional-kelvin + inertia"), heavy(3)))
    for ours, own in zip(intervals_beside_material(known), known.interval(), strict=True):
        np.testing.assert_array_equal(ours, own)


def test_what_is_printed_is_the_profile():
    value = springpot.identify(heavy(4), "material + inertia").parameters["inertia.m"]
    assert value.unit == "kg"
    assert value.high < 1.15 * value.low
    assert value.low == pytest.approx(1e3 * MASS, rel=0.15)


@pytest.mark.parametrize(
    "given", [{"fix": {"K_e": 0.0}}, {"bounds": {"c": (0.0, 1.0)}}, {"start": {"c": 1.0}}]
)
def test_what_the_spectrum_chooses_cannot_be_given(given):
    with pytest.raises(ModelError, match="of a free spectrum goes with its lines"):
        springpot.identify(heavy(1), "material + inertia", **given)


def test_an_effect_beside_any_material_can_be_given_a_start():
    usual = springpot.identify(heavy(1), "material + inertia")
    begun = springpot.identify(heavy(1), "material + inertia", start={"inertia.m": 0.5})
    assert begun.parameters["inertia.m"].value == pytest.approx(
        usual.parameters["inertia.m"].value, rel=1e-3
    )


def test_at_one_frequency_the_lines_may_be_the_spring_and_the_dashpot():
    """One storage and one loss: a spring and a dashpot fit them as lines do."""
    amplitude = np.geomspace(1e-3, 1.0, 12)
    noise = 0.01 * np.random.default_rng(5).normal(size=(2, 12))
    stiffness = 1.0 + 3.0 / (1.0 + amplitude / 0.03) + 0.4j + noise[0] + 1j * noise[1]
    data = springpot.Measurement(
        np.full(12, 6.28),
        stiffness,
        conditions={"amplitude": amplitude},
        units=springpot.Units("N/mm", "mm"),
    )
    found = springpot.identify(data, "material + payne").parameters
    for name in ("K_e", "c"):
        assert (found[name].low, found[name].high) == (0.0, np.inf)


@pytest.mark.parametrize("seed", [2, 4, 7])
def test_a_spring_and_a_dashpot_are_at_most_what_was_measured_of_all(seed):
    """Lines slower and faster than the data stand in for both, and storage and loss add up."""
    omega, rng = np.geomspace(0.1, 100.0, 12), np.random.default_rng(seed)
    scatter = 1.0 + 0.03 * (rng.normal(size=12) + 1j * rng.normal(size=12))
    data = springpot.Measurement(omega, 9.0 * (1j * omega) ** 0.1 * scatter)
    known = Uncertainty.of(fit(springpot.parse_model("material"), data))
    _, high = intervals_beside_material(known)
    assert known.fit.theta[0] < high[0] < 1.15 * np.min(data.storage)
    assert known.fit.theta[1] <= high[1] < np.min(data.loss / omega) + 0.1 * 9.0 / omega[-1]


@pytest.mark.parametrize(
    ("expression", "values", "told"),
    [
        ("springpot", {"c": 40.0, "alpha": 0.2}, True),
        ("zener", {"k1": 10.0, "k2": 90.0, "c": 30.0}, False),
    ],
)
def test_what_still_falls_at_the_slowest_point_is_counted_as_its_spring(expression, values, told):
    model, omega = springpot.parse_model(expression), np.geomspace(0.3, 15.0, 14)
    real, imaginary = 0.002 * np.random.default_rng(5).normal(size=(2, 14))
    stiffness = model.stiffness(model.vector(values), omega) * (1.0 + real + 1j * imaginary)
    found = springpot.identify(springpot.Measurement(omega, stiffness), "material")
    says = "K_e counts all that relaxes more slowly than 0.0477 Hz: storage still falls there"
    assert any(note.startswith(says) for note in found.notes) is told


def test_a_held_weight_may_rise_as_far_as_others_make_up_for_it():
    """Of two columns 30 degrees apart, the other one stays above zero."""
    columns = np.array([[1.0, np.sqrt(0.75)], [0.0, 0.5]])
    [found] = ends_of_amounts(columns, columns @ [1.0, 2.0], [0.01])
    # While the second weight is above zero, the first alone costs the square of its part beside it.
    assert found == pytest.approx((0.8, 1.2), abs=0.003)
    [found] = ends_of_amounts(columns, columns @ [0.0, 2.0], [0.01])
    assert found == pytest.approx((0.0, 0.2), abs=0.003)


@pytest.mark.parametrize("slow", [0.0, 50.0])
def test_a_slow_line_leaves_the_spring_of_a_sweep_open(slow):
    omega = 2 * np.pi * np.geomspace(0.1, 30.0, 20)
    s = 1j * omega
    stiffness = 100.0 + 100.0 * 0.1 * s / (1.0 + 0.1 * s) + slow * 5.0 * s / (1.0 + 5.0 * s)
    for seed in range(4):
        noise = np.random.default_rng(seed).normal(size=(2, 20))
        data = springpot.Measurement(omega, stiffness * (1.0 + 0.01 * (noise[0] + 1j * noise[1])))
        found = springpot.identify(data, "material").parameters
        assert found["K_e"].low <= 100.0 <= found["K_e"].high < 101.5 + slow / 2.0
        assert found["c"].low == 0.0, "there is no dashpot"


@pytest.mark.parametrize(
    ("tau", "alpha", "count"),
    [
        (1.0, 0.5, 8),
        (3.0, 0.5, 12),
        pytest.param(30.0, 0.6, 12, marks=pytest.mark.soak),
        pytest.param(8.0, 0.7, 14, marks=pytest.mark.soak),
    ],
)
def test_an_interval_of_numbers_without_noise_holds_its_value(tau, alpha, count):
    """Whose digits are all the scatter that there is."""
    omega = np.linspace(0.1, 4.0, count)
    relaxing = (1j * omega * tau) ** alpha
    stiffness = 0.7 + 0.5 * relaxing / (1.0 + relaxing)
    known = Uncertainty.of(
        fit(springpot.parse_model("material"), springpot.Measurement(omega, stiffness))
    )
    low, high = intervals_beside_material(known)
    assert np.all(low[:2] <= known.fit.theta[:2])
    assert np.all(known.fit.theta[:2] <= high[:2])
