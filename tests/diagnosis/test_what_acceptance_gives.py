"""The error printed after an effect is what accepting it gives, whatever way it is accepted."""

from __future__ import annotations

import pytest

import springpot
from springpot.identification import fit
from springpot.registry import parse_model

SOME = ("inertia", "time-delay", "phase-error", "parallel-spring")
CASES = [
    ("artificial-hidden", "fractional-maxwell"),
    pytest.param("artificial-hidden", None, marks=pytest.mark.soak),
]


@pytest.mark.parametrize(("data", "model"), CASES)
def test_the_error_after_an_effect_is_that_of_accepting_it(data, model):
    given = [] if model is None else [model]
    diagnosis = springpot.diagnose(data, *given, effects=SOME)
    tried = [row for row in diagnosis.candidates if row.parameters]
    # Also that of an effect which shows only beside another one.
    assert any(row.says.startswith("beside ") for row in tried)
    for row in tried[:2]:
        accepted = springpot.discover(data, *given, accept=row.effect, effects=SOME).steps[-1]
        assert accepted.relative_rms == pytest.approx(row.error_after, rel=0.01), row.effect
        identified = springpot.identify(data, str(accepted.model))
        assert identified.relative_rms == pytest.approx(row.error_after, rel=0.01), row.effect


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
