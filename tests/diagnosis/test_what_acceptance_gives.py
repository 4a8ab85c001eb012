"""Error and parameters of an effect are what accepting it gives, whatever way it is accepted."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot
from springpot.identification import fit
from springpot.registry import parse_model
from springpot.report.text import to_json

pytestmark = pytest.mark.usefixtures("asked_once")

CASES = [
    ("artificial-hidden", "fractional-maxwell"),
    # A quick fit of one more mode stops in another minimum.
    ("nist-srm2491@temperature=20", "fractional-maxwell"),
    pytest.param("artificial-hidden", None, marks=pytest.mark.soak),
]


@pytest.mark.soak_cases(
    "artificial-hidden-fractional-maxwell", "nist-srm2491@temperature=20-fractional-maxwell"
)
@pytest.mark.parametrize(("data", "model"), CASES)
def test_the_error_after_an_effect_is_that_of_accepting_it(data, model):
    given = [] if model is None else [model]
    diagnosis = springpot.diagnose(data, *given)
    tried = [row for row in diagnosis.candidates if row.parameters]
    # Also that of an effect which shows only beside another one.
    assert any(row.says.startswith("beside ") for row in tried)
    for row in tried[:2]:
        accepted = springpot.discover(data, *given, accept=row.effect).steps[-1]
        assert accepted.relative_rms == pytest.approx(row.error_after, rel=0.01), row.effect
        identified = springpot.identify(data, str(accepted.model))
        assert identified.relative_rms == pytest.approx(row.error_after, rel=0.01), row.effect


@pytest.mark.soak
def test_an_error_is_searched_for_where_it_is_asked_for():
    # Under another seed: no other test has asked for its errors.
    found = springpot.diagnose("artificial-hidden", "fractional-maxwell", seed=20)
    fits = [row.alone.refit for row in found.candidates if hasattr(row.alone, "refit")]
    unasked = [each for each in fits if "identified" not in vars(each)]
    assert len(unasked) > len(fits) / 2
    assert unasked[0].error > 0.0
    assert "identified" in vars(unasked[0])


def test_what_weighs_the_points_changes_no_answer(rng):
    """Noise of another shape than |K| moves a fit.

    The error and the parameters that are told of it are those of `identify`.
    """
    omega = np.tile(np.geomspace(0.1, 100.0, 16), 4)
    exact = parse_model("zener").stiffness(np.array([50.0, 200.0, 6.0]), omega)
    scatter = rng.normal(size=(2, 64)) * np.where(omega < 1.0, 0.05, 0.002)
    measured = exact * (1.0 + scatter[0] + 1j * scatter[1])
    data = springpot.Measurement(omega, measured, repeat=np.repeat(np.arange(4), 16))
    diagnosis = springpot.diagnose(data, "springpot", only=["inertia"])
    identified = springpot.identify(data, "springpot")
    assert diagnosis.error.relative_rms == pytest.approx(identified.relative_rms, rel=1e-4)
    for name, told in identified.parameters.items():
        found = diagnosis.parameters[name]
        assert [found.value, found.low, found.high] == pytest.approx(
            [told.value, told.low, told.high], rel=1e-4
        ), name


@pytest.mark.soak
def test_an_effect_that_was_never_fitted_alone_has_no_error():
    diagnosis = springpot.diagnose("nist-srm2491@temperature=20", "fractional-maxwell")
    unfitted = [row for row in diagnosis.candidates if not row.parameters]
    assert unfitted
    assert all(np.isnan(row.error_after) for row in unfitted)
    kept = json.loads(to_json(diagnosis))["candidates"]
    assert [row["effect"] for row in kept if row["error_after"] is None] == [
        row.effect for row in unfitted
    ]


def test_a_seed_in_a_shallow_valley_does_not_keep_a_fit_beside_any_material_there():
    data = springpot.read("rheodata-linear-polymer-amplitude-sweep")
    model = parse_model("material + payne")
    best = fit(model, data)
    astray = best.theta.copy()
    place = best.model.names.index("payne.Xc")
    astray[place] *= 1e3
    astray[place - 2 : place] *= 1e-3
    assert fit(model, data, seeds_theta=[astray], starts=2).cost == pytest.approx(
        best.cost, rel=1e-6
    )
