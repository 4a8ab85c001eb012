"""Measured data whose missing physics is known from publications or from the device itself."""

import os
from pathlib import Path

import numpy as np
import pytest

import springpot
from soaked import soaked
from springpot.errors import SpringpotError
from springpot.registry import plugins

SHARED = Path(
    os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0]
    or Path(__file__).parents[3] / "shared" / "data"
)
SHIFTS = {"arrhenius-shift", "wlf-shift"}
RUBBING = {"friction", "elasto-sliding"}


@pytest.fixture
def shared(monkeypatch):
    """Opens a shared data set, or skips."""

    def read(spec):
        if spec != "nist-srm2491" and not (SHARED / spec.partition("@")[0]).is_dir():
            pytest.skip(f"no {spec} among the shared data (SPRINGPOT_DATA)")
        return springpot.read(spec)

    # Folders of data sets are read when the plugins are loaded, which happens once.
    monkeypatch.setenv("SPRINGPOT_DATA", str(SHARED))
    plugins.cache_clear()
    yield read
    plugins.cache_clear()


BANDED = "friction-damper-brfd-lehigh@band_tension=36"
KNOWN = {}


def rubbing(shared, model):
    """Discovery on the banded damper by hand, made once.

    Its first step is the diagnosis of the model alone.
    """
    if model not in KNOWN:
        KNOWN[model] = springpot.discover(shared(BANDED), model, accept=["elasto-sliding"])
    return KNOWN[model]


def missing(diagnosis):
    return {c.effect for c in diagnosis.candidates if c.verdict == "missing"}


@pytest.mark.soak_cases("three")
@pytest.mark.parametrize(
    "celsius", [(0, 20, 50), soaked((0, 10, 20, 30, 40, 50))], ids=["three", "all"]
)
def test_discovery_finds_both_shifts_of_the_melt(shared, celsius):
    """NIST reduced these data by a horizontal and a vertical (density) shift."""
    data = shared("nist-srm2491")
    ladder = springpot.discover(
        data.subset(np.isin(data.conditions["temperature"], celsius)), "maxwell-5"
    )
    first = ladder.steps[0].case.diagnosis
    assert first.verdict == "effect-missing"
    assert set(first.best.alike) & SHIFTS
    assert "too large" in first.error.doubt
    assert first.best.error_after < first.error.relative_rms / 10.0
    assert ladder.steps[1].accepted in SHIFTS
    assert [step.accepted for step in ladder.steps[2:]] == ["vertical-shift"]
    assert ladder.verdict == "adequate"


@pytest.mark.soak
def test_the_shift_of_the_melt_is_that_of_its_certificate(shared):
    """ln a_T = -C1 (T - 25) / (C2 + T - 25), C1 = 6.64, C2 = 299.4 K, and a vertical shift.

    Both are from SP 260-147.
    """
    data = shared("nist-srm2491")
    before, after = (
        springpot.identify(data, f"maxwell-5{shifts}")
        for shifts in ("", " + wlf-shift + vertical-shift")
    )
    c1, c2 = (after[f"wlf-shift.{name}"].value for name in ("C1", "C2"))
    celsius = np.array([0.0, 10.0, 20.0, 25.0, 30.0, 40.0, 50.0])
    away = celsius + 273.15 - data.reference_temperature
    found = -np.log(10.0) * c1 * away / (c2 + away)
    found -= found[3]
    published = -6.64 * (celsius - 25.0) / (299.4 + celsius - 25.0)
    np.testing.assert_allclose(found, published, atol=0.1)
    assert after.relative_rms < 0.05 * before.relative_rms


@pytest.mark.soak
@pytest.mark.parametrize("model", ["kelvin", "fractional-kelvin"])
def test_a_banded_friction_damper_rubs(shared, model):
    diagnosis = rubbing(shared, model).steps[0].case.diagnosis
    assert diagnosis.verdict == "effect-missing"
    assert diagnosis.best.effect in RUBBING


@pytest.mark.soak_cases("kelvin")
@pytest.mark.xfail(
    strict=True, reason="2.6 tonnes of moving mass, or none at all, are called missing beside it"
)
@pytest.mark.parametrize("model", ["kelvin", soaked("fractional-kelvin")])
def test_a_banded_friction_damper_has_nothing_else_that_ten_points_prove(shared, model):
    assert missing(rubbing(shared, model).steps[0].case.diagnosis) <= RUBBING | {
        "backlash",
        "payne",
    }


@pytest.mark.soak
def test_the_friction_force_of_the_banded_damper(shared):
    """|F1| = 4 F / pi is 18.4 to 20.7 kN in nine of ten runs: F near 15 kN."""
    values = rubbing(shared, "kelvin").to_dict()["steps"][-1]["parameters"]
    assert values["elasto-sliding.F"]["unit"] == "N"
    assert values["elasto-sliding.F"]["value"] == pytest.approx(15e3, rel=0.15)


@pytest.mark.soak_cases("1.0")
@pytest.mark.parametrize("current", [1.0, soaked(0.5)])
def test_a_magnetorheological_damper_yields_like_friction(shared, current):
    diagnosis = springpot.diagnose(
        shared(f"mr-damper-utfsm-sinusoid@current={current:g}"), "kelvin"
    )
    assert diagnosis.verdict == "effect-missing"
    assert RUBBING & set(diagnosis.best.alike)
    force = diagnosis.best.parameters["F"].value
    assert force == pytest.approx({0.5: 900.0, 1.0: 1600.0}[current] * np.pi / 4.0, rel=0.35)


@pytest.fixture(scope="module")
def of_elastomer():
    """The diagnosis of all sweeps of strain, made once; `shared` is what reads them."""
    known = []

    def diagnosis(shared):
        if not known:
            data = shared("elastomer-epdm-70-dma-payne")
            sweeps = data.subset(np.char.startswith(data.labels["run"].astype(str), "sd_"))
            known.append(springpot.diagnose(sweeps, "springpot"))
        return known[0]

    return diagnosis


@pytest.mark.soak
def test_a_filled_elastomer_softens_with_amplitude(shared, of_elastomer):
    diagnosis = of_elastomer(shared)
    assert diagnosis.verdict == "effect-missing"
    assert diagnosis.best.effect == "payne"
    assert diagnosis.best.error_after < 0.5 * diagnosis.error.relative_rms


@pytest.mark.soak
def test_a_filled_elastomer_needs_nothing_but_its_softening(shared, of_elastomer):
    assert missing(of_elastomer(shared)) == {"payne"}


@pytest.mark.soak
def test_a_filled_elastomer_at_one_frequency(shared):
    diagnosis = springpot.diagnose(shared("elastomer-epdm-70-dma-payne@run=sd_10hz"), "springpot")
    assert diagnosis.verdict == "effect-missing"
    assert {"payne", "elasto-sliding", "cubic-stiffness"} & set(diagnosis.best.alike)


@pytest.mark.soak
def test_the_bad_highest_frequency_of_a_soft_solid_is_found(shared):
    """Loss is negative at 100 Hz alone: no effect is proven by it, but the point is told."""
    data = shared("hermes-multi-technique@step=frequency")
    assert data.loss[np.argmax(data.omega)] < 0 < np.sort(data.loss)[1]
    diagnosis = springpot.diagnose(data, "fractional-kelvin")
    assert diagnosis.verdict in ("effect-missing", "unexplained")
    # As a single point where the model bends elsewhere only, else as the place at which it fails
    # first of all.
    assert any(w.low > 90.0 for w in diagnosis.where)
    assert not missing(diagnosis) - {"inertia", "specimen-inertia", "time-delay", "filter-mismatch"}
    without = springpot.diagnose(data)
    assert any("single point" in w.says and w.high > 99.0 for w in without.where)


def test_a_set_without_temperatures_refuses_a_shift_in_one_line(shared):
    with pytest.raises(SpringpotError, match="temperature"):
        springpot.discover(
            shared("mr-damper-utfsm-sinusoid@current=1"), "kelvin", accept=["wlf-shift"]
        )


@pytest.mark.soak
def test_bitumen_at_seven_temperatures_comes_down_to_what_its_replicates_scatter_by(shared):
    """No model is named and no option set.

    Replicates that share a disturbance do not end the search.
    """
    ladder = springpot.discover(shared("fhwa-ptf-binder-dsr@lane=1"))
    assert [step.accepted for step in ladder.steps] == [None, "wlf-shift", "vertical-shift"]
    last = ladder.steps[-1]
    assert last.relative_rms < 1.3 * last.noise_floor
    assert any("repeats differ by more than chance" in note for note in ladder.diagnosis.notes)
