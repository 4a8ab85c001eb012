"""Fits of small sweeps, whole: values, intervals, notes, and what they foretell."""

import numpy as np
import pytest

import springpot
from springpot.errors import SpringpotError
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model

MODEL = parse_model("fractional-zener")
THETA = MODEL.theta(k1=40.0, k2=300.0, c=60.0, alpha=0.6)
OMEGA = np.geomspace(0.5, 90.0, 14)
EXACT = MODEL.stiffness(THETA, OMEGA)


def made(*parts, level=0.005, **more):
    k = np.concatenate(parts or [EXACT])
    scatter = np.random.default_rng(len(k)).normal(size=(2, len(k)))
    values = k * (1.0 + level * (scatter[0] + 1j * scatter[1]))
    omega = np.tile(OMEGA, len(k) // 14)
    return Measurement(omega, values, units=Units("kN/m", "mm"), name="made", **more)


def heated():
    celsius = np.repeat([10.0, 30.0], 14)
    return made(MODEL.stiffness(THETA, 3.0 * OMEGA), EXACT, conditions={"temperature": celsius})


DATA = {
    "one": made(),
    "exact": made(level=0.0),
    "given": made(sd=0.004 * np.abs(EXACT) * (1 + 1j)),
    "repeats": made(EXACT, 1.03 * EXACT, 0.98 * EXACT, repeat=np.repeat([1, 2, 3], 14)),
    "heated": heated(),
    "few": made().subset(np.arange(14) % 4 == 0, "few"),
}
FITS = {
    "zener": ("one", {}),
    "exact": ("exact", {}),
    "given": ("given", {}),
    "repeats": ("repeats", {}),
    "few": ("few", {}),
    "held": ("one", {"fix": {"alpha": 0.6}}),
    "at a bound": ("one", {"bounds": {"k2": (0.0, 250.0)}}),
    "too simple": ("one", {"model": "kelvin"}),
    "not determined": ("one", {"model": "fractional-zener + series-spring"}),
    "material": ("one", {"model": "material"}),
    "shifted": ("heated", {"model": "fractional-zener + arrhenius-shift"}),
    "free shift": ("heated", {"model": "material + free-shift"}),
    "leastsquares": ("one", {"optimiser": "least-squares", "seed": 3}),
    "simplex": ("one", {"optimiser": "nlopt-nelder-mead", "budget": 300, "seed": 3}),
    "swarm": ("one", {"optimiser": "pso-paper", "budget": 400, "seed": 3}),
    "all excluded": ("one", {"exclude": "omega=0..1e9"}),
    "held beyond": ("one", {"fix": {"alpha": 2.0}}),
}


def without_time(answer):
    return {name: part for name, part in answer.to_dict().items() if name != "seconds"}


@pytest.mark.soak_cases(
    "leastsquares",
    "free shift",
    "given",
    "held",
    "at a bound",
    "simplex",
    "not determined",
    "shifted",
)
@pytest.mark.parametrize("case", list(FITS))
def test_fit_of_a_sweep(case, stays):
    name, options = FITS[case]
    try:
        fit = springpot.identify(DATA[name], **({"model": MODEL} | options))
        kept = without_time(fit)
    except SpringpotError as error:
        stays(str(error))
        return
    if (spectrum := kept.get("spectrum")) is not None:
        # Where a spectrum ends is chance: its ends are told beside its peak.
        for end in ("low", "high"):
            spectrum[end] = [max(spectrum["weights"]) + each for each in spectrum[end]]
    asked = {"temperature": 20.0} if name == "heated" else {}
    foretold = fit.predict(frequency=[0.0, 0.1, 1.0, 30.0], **asked)
    stays(
        {
            "kept": kept,
            "foretold": [foretold.storage, foretold.loss, foretold.low, foretold.high],
            "notes": [foretold.outside, foretold.notes],
        },
        within=1e-3,
    )


def test_a_band_of_what_is_not_determined_is_endless_and_never_no_number():
    fit = springpot.identify(DATA["one"], "fractional-zener + series-spring")
    found = fit.predict(frequency=[0.0, 0.1, 1.0])
    assert np.all(found.low.real == -np.inf)
    assert np.all(found.high.real == np.inf)
    assert not np.any(np.isnan([found.low.imag, found.high.imag]))
    assert found.low[0].imag == found.high[0].imag == 0.0
