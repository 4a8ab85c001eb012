"""What the instrument promises: a misfit may be certain, and small all the same."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.diagnosis.in_practice import Accuracy, Misfit, in_practice
from springpot.errors import OptionError

pytestmark = pytest.mark.usefixtures("asked_once")


def sweep(notch, seed=1):
    """A springpot beside a spring, whose modulus has a hump that no phase goes with."""
    omega = np.geomspace(1.0, 1e3, 30)
    hump = 1.0 + notch * np.exp(-(((np.log10(omega) - 1.5) / 0.3) ** 2))
    model = springpot.parse_model("fractional-kelvin-voigt")
    exact = model.stiffness(np.array([400.0, 60.0, 0.3]), omega)
    noise = np.random.default_rng(seed).normal(size=(2, 30)) * 1e-4
    return springpot.Measurement(omega, exact * hump * (1.0 + noise[0] + 1j * noise[1]))


@pytest.mark.parametrize(
    ("text", "modulus", "phase"),
    [("1%,3mrad", 0.01, 0.003), ("2 %", 0.02, None), ("0.5deg, .5%", 0.005, np.pi / 360.0)],
)
def test_an_accuracy_is_read(text, modulus, phase):
    assert Accuracy.of(text) == Accuracy(modulus, pytest.approx(phase) if phase else None)


@pytest.mark.parametrize("text", ["", "3mrad", "1%,2%", "1", "0%", "-1%", "1%,3mrad,1deg", "nan%"])
def test_what_is_no_accuracy_is_refused_in_one_line(text):
    with pytest.raises(OptionError, match="such as 1%,3mrad") as caught:
        Accuracy.of(text)
    assert "\n" not in str(caught.value)


def test_nineteen_of_twenty_values_must_be_within_it():
    off = np.zeros(100)
    off[:5] = 0.02
    accuracy = Accuracy(0.01)
    assert accuracy.holds([Misfit(off, np.zeros(0))])
    off[5] = 0.02
    assert not accuracy.holds([Misfit(off, np.zeros(0))])
    assert not accuracy.holds([Misfit(np.zeros(100), np.zeros(0)), Misfit(off, np.zeros(0))])


def test_one_of_few_values_may_lie_beyond_it():
    """Of twelve values nineteen of twenty are no count: all of them were asked for."""
    off = np.full(12, 0.002)
    off[-1] = 0.012
    assert Accuracy(0.01).holds([Misfit(off, np.zeros(0))])
    off[-2] = 0.012
    assert not Accuracy(0.01).holds([Misfit(off, np.zeros(0))])


@pytest.mark.soak
def test_the_last_digits_of_computed_data_are_no_misfit():
    found = springpot.diagnose(sweep(0.002), "fractional-kelvin-voigt", only=["inertia"])
    exact = replace(found, error=replace(found.error, relative_rms=1e-9))
    told = in_practice(exact, [], None)
    assert (told.verdict, told.where, told.leading) == ("adequate", (), ())
    assert told.says == "the error is 1e-07 %, as near as numbers tell: nothing is missing"


def test_a_few_values_that_are_far_off_are_not_within_it():
    off = np.zeros(100)
    off[:3] = 0.2
    assert np.mean(off <= 0.01) > 0.95
    assert not Accuracy(0.01).holds([Misfit(off, np.zeros(0))])


def test_modulus_and_phase_are_told_apart():
    measured = np.full(10, 100.0 + 50.0j)
    gain, turn = (Misfit.of_stiffness(measured * by, measured) for by in (1.02, np.exp(0.02j)))
    assert Accuracy(0.03, 0.001).holds([gain])
    assert not Accuracy(0.001, 0.03).holds([gain])
    assert Accuracy(0.001, 0.03).holds([turn])
    assert not Accuracy(0.03, 0.001).holds([turn])


@pytest.mark.soak
def test_a_certain_misfit_within_what_is_promised_is_adequate():
    data, few = sweep(0.002), ["inertia", "series-spring", "time-delay"]
    plain = springpot.diagnose(data, "fractional-kelvin-voigt", only=few)
    assert plain.verdict != "adequate"
    told = springpot.diagnose(data, "fractional-kelvin-voigt", only=few, accuracy="1%,3mrad")
    assert told.verdict == "adequate"
    assert told.says.startswith("within what the instrument promises (1 %, 3 mrad); a structure of")
    assert told.leading == ()
    assert all(each.verdict != "missing" for each in told.candidates)
    tight = springpot.diagnose(data, "fractional-kelvin-voigt", only=few, accuracy="0.05%,3mrad")
    assert (tight.verdict, tight.leading) == (plain.verdict, plain.leading)


@pytest.mark.soak
def test_a_misfit_that_is_small_is_called_so_first():
    told = springpot.diagnose(sweep(0.002), "fractional-kelvin-voigt", only=["inertia"])
    assert told.verdict == "unexplained"
    assert told.says.startswith("small in practice, ")
    assert "--accuracy 1%,3mrad" in told.says
    large = springpot.diagnose(sweep(0.05), "fractional-kelvin-voigt", only=["inertia"])
    assert large.verdict == "unexplained"
    assert "small in practice" not in large.says


@pytest.mark.soak
def test_discovery_ends_where_the_instrument_promises_no_more():
    few = ["inertia", "series-spring", "time-delay"]
    ladder = springpot.discover(
        sweep(0.002), "fractional-kelvin-voigt", only=few, accuracy="1%,3mrad"
    )
    assert ladder.verdict == "adequate"
    assert len(ladder.steps) == 1


@pytest.mark.soak
def test_a_test_in_time_is_judged_by_it_too():
    t = np.geomspace(0.1, 100.0, 60)
    model = springpot.parse_model("zener")
    force = model.relaxation(model.theta(k1=100.0, k2=300.0, c=600.0), t)
    force = force * (1.0 + 0.003 * np.sin(4.0 * np.log(t)))
    force = force + 0.02 * np.random.default_rng(2).normal(size=60)
    test = springpot.TimeTest.of_relaxation(t, force, "kPa")
    few = ["force-drift", "finite-ramp"]
    assert springpot.diagnose(test, "zener", only=few).verdict != "adequate"
    told = springpot.diagnose(test, "zener", only=few, accuracy="2%")
    assert told.verdict == "adequate"
    assert told.says.startswith("within what the instrument promises (2 %)")
    assert springpot.discover(test, "zener", only=few, accuracy="2%").verdict == "adequate"


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_model_without_any_stiffness_is_infinitely_far_without_a_warning():
    """Which the best of all passive models is for data whose force has the wrong sign."""
    measured = np.array([-2.0 - 1.0j, -3.0 - 1.0j])
    misfit = Misfit.of_stiffness(np.zeros(2, complex), measured)
    assert misfit.modulus.tolist() == [np.inf, np.inf]
    assert not Accuracy.of("1%,3mrad").holds([misfit])
