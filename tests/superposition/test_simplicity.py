"""Whether one curve is enough: silent where it is, and where it is not it says where."""

import numpy as np
import pytest
from sweeps import mass, measured, phase_error, simple, two_branches

import springpot
from springpot.identification.levels_alone import each_alone
from springpot.identification.problem import relative_objective

pytestmark = pytest.mark.usefixtures("asked_once")


@pytest.mark.soak
def test_a_simple_material_is_called_simple():
    """The level is 0.5 %, so that none of twelve is called otherwise but by a chance of 6 %."""
    verdicts = [springpot.mastercurve(measured(simple, seed=seed)).simplicity for seed in range(12)]
    assert sum(each.verdict == "simple" for each in verdicts) >= 11
    assert all(not each.failures for each in verdicts if each.verdict == "simple")
    # Of a chance that is right the median of twelve is this low once in two hundred times.
    assert np.median([each.chance for each in verdicts]) > 0.18


@pytest.mark.soak
def test_many_short_sweeps_of_a_simple_material_are_simple():
    """Of each the scatter is known from few points: their ratios of variances have long tails."""
    omega, celsius = np.geomspace(0.1, 10.0, 12), np.linspace(-10.0, 80.0, 19)
    log_a = -8.86 * np.log(10.0) * (celsius - 20.0) / (81.6 + celsius)
    root = np.sqrt(1j * omega * np.exp(log_a)[:, None])
    stiffness = (100.0 + 900.0 * root / (1.0 + root)).ravel()
    chances = []
    for seed in (0, 4, 12):
        noise = np.random.default_rng(seed).normal(size=(2, stiffness.size)) * 0.005
        data = springpot.Measurement(
            np.tile(omega, len(celsius)),
            stiffness * (1.0 + noise[0] + 1j * noise[1]),
            conditions={"temperature": np.repeat(celsius, len(omega))},
        )
        chances.append(springpot.mastercurve(data).simplicity.chance)
    assert min(chances) > 0.1


@pytest.fixture(scope="module", params=range(3))
def seed(request):
    return request.param


@pytest.mark.soak_cases("0", "1", "2")
def test_a_branch_with_its_own_temperature_is_seen(seed):
    rest = springpot.mastercurve(measured(two_branches, seed=seed)).simplicity
    assert rest.verdict == "not-simple"
    assert rest.error > 1.5 * rest.alone
    assert {failure.kind for failure in rest.failures} & {"branch", "level"}


@pytest.mark.soak
def test_a_phase_error_at_one_temperature_shows_there(seed):
    """Loss and storage cannot follow one another at the temperature of the misread phase."""
    rest = springpot.mastercurve(measured(phase_error, seed=seed)).simplicity
    assert rest.verdict != "simple"
    apart = [failure for failure in rest.failures if failure.kind in {"storage-and-loss", "level"}]
    assert apart
    assert 45.0 in {failure.place for failure in apart}


@pytest.mark.soak_cases("0", "1", "2")
def test_what_no_material_does_is_not_laid_to_superposition(seed):
    rest = springpot.mastercurve(measured(mass, seed=seed)).simplicity
    first = rest.failures[0]
    assert (first.kind, first.place) == ("no-material", 60.0)
    assert "no linear material" in first.says


@pytest.mark.soak
def test_repeats_that_differ_are_no_strange_material():
    data = measured(simple)
    hot = data.conditions["temperature"] == 60.0
    twice = springpot.Measurement(
        np.concatenate([data.omega, data.omega[hot]]),
        np.concatenate([data.stiffness, 1.05 * data.stiffness[hot]]),
        conditions={
            "temperature": np.concatenate(
                [data.conditions["temperature"], np.full(hot.sum(), 60.0)]
            )
        },
    )
    curve = springpot.mastercurve(twice)
    assert not [failure for failure in curve.simplicity.failures if failure.kind == "no-material"]
    assert any("repeated sweeps differ" in note for note in curve.notes)


@pytest.mark.soak
def test_too_few_points_are_not_judged():
    rest = springpot.mastercurve(measured(simple, points=3)).simplicity
    assert rest.verdict == "not-judged"


@pytest.mark.soak
@pytest.mark.parametrize(("points", "decades"), [(13, 2.0), (8, 1.0)])
def test_a_material_of_each_level_leaves_as_much_as_its_degrees_of_freedom_say(points, decades):
    """A line that stands alone has followed the noise by its place, too."""
    number, left, free = np.repeat(np.arange(5), points), 0.0, 0.0
    for seed in range(40):
        data = measured(simple, seed=seed, points=points, decades=decades)
        alone = each_alone(data, number, relative_objective())
        left, free = left + alone.cost.sum() / 0.005**2, free + alone.dof.sum()
    # So many squares of noise scatter by the root of twice their number.
    assert abs(left - free) < 2.6 * np.sqrt(2.0 * free)


@pytest.mark.soak
def test_a_step_that_is_too_long_is_no_size_of_a_shift():
    """Two materials under one name, which share no decade: nothing shifts by 600 % less."""
    omega = np.geomspace(0.6, 17.0, 11), np.geomspace(0.6, 600.0, 31)
    laws = [11e3 * (1j * omega[0]) ** 0.24, 17e3 * (1j * omega[1]) ** 0.03 + 300.0j]
    laws[1] -= 0.012 * omega[1] ** 2
    scatter = np.exp(0.003 * np.random.default_rng(3).normal(size=42))
    data = springpot.Measurement(
        np.concatenate(omega),
        np.concatenate(laws) * scatter,
        conditions={"temperature": np.repeat([150.0, 37.0], [11, 31])},
    )
    failures = springpot.mastercurve(data).simplicity.failures
    branches = [each for each in failures if each.kind == "branch"]
    assert branches
    for each in branches:
        assert ("shifts otherwise than the others" in each.says) is (abs(each.size) >= 1.0)
