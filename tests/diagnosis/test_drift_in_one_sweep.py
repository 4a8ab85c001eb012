"""A gain that drifts while one sweep is measured looks like a phase that is wrong.

The answer says so.

K (i omega)^e is a material again, and omega^e = (i omega)^e exp(-i e pi/2): beside any material the
two are one.
"""

import numpy as np
import pytest

import springpot

HERTZ = np.geomspace(0.1, 100.0, 30)
OPPOSITE = "opposite order"


def sweep(rng, *, hertz=HERTZ, drift=0.0, phase=0.0):
    """A material with a gain that grows by `drift` from first row to last, or a phase error."""
    s = 2j * np.pi * hertz
    stiffness = 60.0 + 1.0 / (1.0 / 400.0 + 1.0 / (40.0 * s**0.5))
    gain = (1.0 + drift) ** np.linspace(0.0, 1.0, len(hertz))
    real, imaginary = 0.001 * rng.normal(size=(2, len(hertz)))
    stiffness = stiffness * gain * np.exp(1j * phase) * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(s.imag, stiffness, units=springpot.Units("kN/m", "mm"))


def diagnosed(**given):
    return springpot.diagnose(sweep(np.random.default_rng(2), **given))


@pytest.fixture(scope="module", params=[0.05, -0.03, 0.02], ids="{:+.0%}".format)
def drifted(request):
    return request.param, diagnosed(drift=request.param)


@pytest.mark.soak_cases("+2%", "+5%", "-3%")
def test_the_headline_names_the_drift_beside_the_phase(drifted):
    drift, found = drifted
    assert found.verdict == "effect-missing"
    assert "phase-error" in found.leading
    _, _, told = found.says.partition("in place of phase-error a gain that drifts by ")
    assert float(told.partition(" %")[0]) / 100.0 == pytest.approx(drift, rel=0.25)


@pytest.mark.parametrize(
    ("given", "drifts"),
    [({"drift": 0.05}, True), pytest.param({"phase": 0.01}, False, marks=pytest.mark.soak)],
    ids=["drift", "phase"],
)
def test_the_users_own_model_is_told_of_a_drift_that_does_as_well(given, drifts):
    found = springpot.diagnose(sweep(np.random.default_rng(2), **given), "fractional-zener")
    assert found.leading == ("phase-error",)
    assert (" in place of phase-error a gain that drifts by 5 %" in found.says) == drifts


@pytest.mark.soak_cases("-3%", "+5%")
def test_the_next_experiment_is_the_opposite_order(drifted):
    _, found = drifted
    assert OPPOSITE in found.next_experiment.says


@pytest.mark.soak_cases("+2%", "+5%", "-3%")
def test_no_machine_accepts_the_phase_unasked(drifted):
    drift, _ = drifted
    measured = sweep(np.random.default_rng(2), drift=drift)
    assert len(springpot.discover(measured).steps) == 1
    assert len(springpot.discover(measured, accept="phase-error").steps) == 2


@pytest.mark.soak
def test_a_phase_that_is_wrong_by_as_much_comes_first():
    """That of a drift of 5 % over three decades: these data cannot tell which of the two it is."""
    found = diagnosed(phase=-0.5 * np.pi * np.log(1.05) / np.log(1000.0))
    assert found.leading[0] == "phase-error"
    assert found.says.index("missing is phase-error") < found.says.index("a gain that drifts by")


@pytest.mark.soak
def test_a_sweep_up_and_down_again_tells_them_apart():
    there_and_back = np.r_[HERTZ[::2], HERTZ[::-2]]
    found = diagnosed(hertz=there_and_back, phase=0.02)
    assert found.leading[0] == "phase-error"
    assert "drifts" not in found.says
    assert found.next_experiment is None or OPPOSITE not in found.next_experiment.says
