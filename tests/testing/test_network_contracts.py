"""The contracts of models and effects find what they are there to find: one slip, one sentence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from springpot.rheology import (
    PURE,
    STIFFNESS,
    TIME_FORM,
    VISCOSITY,
    Effect,
    FixedPower,
    Formula,
    Model,
    Parameter,
    SearchForm,
    chain,
    dashpot,
    mass,
    parallel,
    series,
    spring,
    springpot,
    stiffness,
)
from springpot.rheology.model import Family
from springpot.testing import check_effect, check_model

GOOD = Model(
    "good-model",
    series(spring("k"), springpot()),
    "a model in order",
    "nobody (2024)",
    ("other",),
    search=TIME_FORM,
)
K = stiffness("k")


def of(law: Callable[..., Any], *parameters: Parameter, **more: Any) -> Model:
    """A model of one law."""
    return Model(
        "good-model", Formula(parameters or (K,), law, **more), "a model in order", "nobody (2024)"
    )


def constant(at, k):
    return k + 0 * at.omega, (1.0,), 0.0


def finite_difference(at, k):
    slope = k * at.omega
    return slope, (at.omega * (1 + 1e-7),), slope


def explosion(at, k):
    value = np.exp(k) * at.omega
    return value, (value,), value


def rough(at, k):
    return np.round(k, 6) + 0 * at.omega, (1.0,), 0.0


def root(at, k):
    value = np.sqrt(k) * at.omega
    return value, (0.5 * value / k,), value


def share(at, k, b):
    return k * b / at.amplitude, (b / at.amplitude, k / at.amplitude), 0.0


def remember(at, k, calls=[0]):  # noqa: B006  the slip
    calls[0] += 1
    return k * calls[0] + 0 * at.omega, (calls[0],), 0.0


def meddle(at, k):
    k *= 2.0
    return k + 0 * at.omega, (2.0,), 0.0


def toss(at, k):
    np.random.random()  # noqa: NPY002  the slip
    return constant(at, k)


class Doubled(FixedPower):
    """A spring that is twice as stiff in a search."""

    def parts(self, theta, at):
        return 2.0 * theta, np.zeros((1, 1))


def negative(x):
    return -TIME_FORM.to_elements(x)


MODELS = {
    "a name with a space": (
        replace(GOOD, base="Good model"),
        "words: 'Good model' must be lower-case",
    ),
    "an alias with a plus": (replace(GOOD, aliases=("a+b",)), "words: 'a+b' must be"),
    "no summary": (replace(GOOD, summary=""), "words: the summary must be one sentence"),
    "a full stop": (
        replace(GOOD, summary="a good model."),
        "words: the summary ends with a full stop",
    ),
    "no citation": (replace(GOOD, citation=" "), "words: there is no citation"),
    "one name twice": (
        replace(GOOD, material=parallel(spring("k"), dashpot("k")), search=None),
        "parameters: two parameters are called k",
    ),
    "a name that is no word": (
        replace(GOOD, material=spring("k 1"), search=None),
        "parameters: the parameter name 'k 1' is no identifier",
    ),
    "a typical size out of bounds": (
        of(constant, Parameter("k", "k", STIFFNESS, 0.0, 2.0, typical=3.0)),
        "parameters: k: the typical size 3.0 is not within 0.0 to 2.0",
    ),
    "a logarithm below zero": (
        of(constant, Parameter("k", "k", STIFFNESS, -1.0)),
        "parameters: k: a logarithmic scale needs",
    ),
    "a finite difference": (
        of(finite_difference, Parameter("k", "k", VISCOSITY)),
        "derivatives: dK/dk is not the",
    ),
    "a derivative that is no number": (
        of(lambda at, k: (constant(at, k)[0], (np.nan,), 0.0)),
        "derivatives: dK/dk is not the derivative of K: off by inf",
    ),
    "no derivative at all": (
        of(rough),
        "derivatives: dK/dk is not the derivative of K: off by inf",
    ),
    "a wrong slope": (
        of(lambda at, k: (k * at.omega, (at.omega,), 0.0), Parameter("k", "k", VISCOSITY)),
        "derivatives: by_log_omega is not dK/d ln omega",
    ),
    "an infinity in the box": (
        of(explosion),
        "finite: value is not finite in a corner of the search box, such as at k",
    ),
    "a viscosity called stiffness": (
        of(lambda at, k: (k * at.omega, (at.omega,), k * at.omega)),
        "units: K does not follow a change of the unit of time",
    ),
    "a root of a stiffness": (
        of(root, Parameter("k", "k", VISCOSITY)),
        "units: K does not follow a change of the unit of stiffness",
    ),
    "a length without a unit": (
        of(share, K, Parameter("b", "b", PURE), conditions=("amplitude",)),
        "units: K does not follow a change of the unit of amplitude",
    ),
    "a memory": (of(remember), "pure: two calls with the same arguments differ"),
    "a changed argument": (of(meddle), "pure: the arrays that are handed in are changed"),
    "other parts": (
        replace(GOOD, material=Doubled(K, 0.0), search=None),
        "pure: K' and K'' apart are others than those of K",
    ),
    "a toss": (of(toss), "pure: changes the process-wide random state"),
    "an exception": (of(lambda at, k: 1 / 0), "shapes: raises ZeroDivisionError: division by zero"),
    "leading axes mixed up": (
        of(lambda at, k: (np.mean(k) + 0 * k * at.omega, (1.0,), 0.0)),
        "shapes: value of stacked parameters differs",
    ),
    "another model's search form": (
        replace(GOOD, search=replace(TIME_FORM, from_elements=lambda theta: theta)),
        "search: from_elements does not undo to_elements",
    ),
    "a search form's wrong derivative": (
        replace(GOOD, search=replace(TIME_FORM, jacobian=lambda x: 1.01 * TIME_FORM.jacobian(x))),
        "search: jacobian is not the derivative of to_elements",
    ),
    "a search form that leaves the bounds": (
        replace(GOOD, search=replace(TIME_FORM, to_elements=negative)),
        "search: a lawful search point gives k beyond its bounds",
    ),
}


WRONG_UNITS = {
    "stiffness": of(lambda at, k: (np.sqrt(k) + 0 * at.omega, (0.5 / np.sqrt(k),), 0.0)),
    "time": MODELS["a viscosity called stiffness"][0],
    "amplitude": MODELS["a length without a unit"][0],
}


def says(found: list[str], sentence: str) -> bool:
    """Whether one of the complaints begins with that sentence, and all are single lines."""
    assert not any("\n" in complaint for complaint in found)
    return any(complaint.startswith(sentence) for complaint in found)


def test_a_good_model_is_given_no_complaint():
    assert check_model(GOOD, passive=True) == []


def test_a_form_is_undone_from_points_in_its_order():
    """Two springs in parallel are searched as the softer and the stiffer: no others come back."""
    two = parallel(spring("k1"), spring("k2"))

    def same(x):
        return np.array(x) * 1.0

    form = SearchForm(
        (stiffness("soft"), stiffness("stiff")),
        same,
        lambda x: np.broadcast_to(np.eye(2), (*np.shape(x), 2)),
        lambda theta: np.sort(theta, axis=-1),
        ordered=(0, 1),
    )
    found = check_model(replace(GOOD, material=two, search=form))
    assert [each for each in found if each.startswith("search")] == []


@pytest.mark.parametrize("unit", ["stiffness", "time", "amplitude"])
def test_a_wrong_unit_is_told_of_that_unit_alone(unit: str):
    found = [each for each in check_model(WRONG_UNITS[unit]) if "units" in each]
    assert found == [
        f"units: K does not follow a change of the unit of {unit}: a parameter's Dimension is wrong"
    ]


FIRST = {sentence.partition(":")[0]: case for case, (_, sentence) in MODELS.items()}
"""A slip of each aspect."""


@pytest.mark.parametrize("case", MODELS)
def test_a_slip_in_a_model_is_one_sentence(case: str, stays):
    model, sentence = MODELS[case]
    found = check_model(model)
    assert says(found, sentence), found
    stays(found)


@pytest.mark.parametrize("aspect", FIRST)
def test_an_aspect_that_is_left_out_says_nothing(aspect: str):
    model, sentence = MODELS[FIRST[aspect]]
    assert not says(check_model(model, skip=[aspect]), sentence)


def test_passivity_is_demanded_only_on_request():
    model = replace(GOOD, material=mass(), search=None)
    assert check_model(model) == []
    assert check_model(model, passive=True) == [
        "passive: the storage is negative for lawful parameters"
    ]


def test_a_family_is_checked_by_its_members():
    good = Family("row-N", lambda n: replace(GOOD, base=f"row-{n}"), "models in a row")
    assert check_model(good) == []
    assert says(
        check_model(replace(good, build=lambda n: GOOD)),
        "words: member 1 is called good-model, not row-1",
    )
    bad = replace(good, build=lambda n: replace(of(explosion), base=f"row-{n}"))
    assert says(check_model(bad), "row-3: finite: value is not finite")


def test_skipping_everything_or_what_is_not_there_is_a_complaint():
    aspects = ["words", "parameters", "shapes", "derivatives", "finite", "units", "pure", "search"]
    assert check_model(GOOD, skip=aspects) == [
        "skip: every aspect is left out, so nothing was checked"
    ]
    assert check_model(GOOD, skip=["unit"])[0].startswith(
        "skip: there is no aspect 'unit': known are words"
    )


EFFECT = Effect(
    "good-effect", parallel, dashpot("c"), "a good effect of drag", citation="nobody (2024)"
)


def stiffening(at, k):
    return k * at.amplitude, (at.amplitude,), 0.0


def secretly(at, k):
    return k * (at.amplitude if at.amplitude is not None else 1.0), (1.0,), 0.0


def effect_of(law: Callable[..., Any], *parameters: Parameter, **more: Any) -> Effect:
    return replace(EFFECT, element=Formula(parameters or (K,), law, **more))


EFFECTS = {
    "no citation": (replace(EFFECT, citation=""), "words: there is no citation"),
    "a prior beyond one": (
        replace(EFFECT, prior=2.0),
        "words: the prior is 2.0, not above 0 and at most 1",
    ),
    "a prior of nothing": (
        replace(EFFECT, prior=0.0),
        "words: the prior is 0.0, not above 0 and at most 1",
    ),
    "no layer": (
        replace(EFFECT, layer="outside"),
        "words: the layer is 'outside', not one of MATERIAL",
    ),
    "an element that is wrong": (
        effect_of(finite_difference, Parameter("c", "c", VISCOSITY)),
        "derivatives: dK/dgood-",
    ),
    "an effect without an end": (
        replace(EFFECT, composition=chain, element=Formula((Parameter("g", "g", PURE),), constant)),
        (
            "vanishes: it does not vanish when g, its first parameter, goes to 0: "
            "K still changes by 1.0e+00"
        ),
    ),
    "an effect that is none": (
        effect_of(lambda at, k: (0.0 * k * at.omega, (0.0,), 0.0)),
        "vanishes: at its typical size it changes nothing",
    ),
    "a column used in silence": (
        effect_of(stiffening),
        "columns: it uses the amplitude without saying so",
    ),
    "a column used if there": (
        effect_of(secretly),
        "columns: it depends on the amplitude without saying so",
    ),
    "a column named and not used": (
        effect_of(constant, conditions=("temperature",)),
        "columns: it says that it needs the temperature, but works without",
    ),
    "a column that is none": (
        effect_of(constant, conditions=("humidity",)),
        "columns: it needs 'humidity', but",
    ),
    "a harmonic of the wrong shape": (
        effect_of(lambda at, k: (k + 0 * at.omega, (1.0,), 0.0), third=lambda at, k: np.nan),
        "harmonic: the third harmonic must be finite",
    ),
}


def test_a_good_effect_is_given_no_complaint():
    assert check_effect(EFFECT) == []
    assert check_effect(EFFECT, on=GOOD) == []
    assert check_effect(replace(EFFECT, composition=series, element=spring())) == []


@pytest.mark.parametrize("case", EFFECTS)
def test_a_slip_in_an_effect_is_one_sentence(case: str, stays):
    effect, sentence = EFFECTS[case]
    found = check_effect(effect)
    assert says(found, sentence), found
    stays(found)


def test_a_material_is_checked_with_lines_in_its_spectrum(monkeypatch):
    """Its parameters depend on the data.

    Without lines there would be nothing but a spring beside a dashpot.
    """
    from springpot.rheology import Continuum
    from springpot.testing import check_model

    free = Model("any", Continuum(), "any linear passive material at all", "Ferry 1980, ch. 3")
    assert check_model(free) == []
    assert any(says.startswith("words") for says in check_model(Model("any", Continuum(), "", "")))
    basis = Continuum.basis

    def crooked(node, log_omega, with_slopes):
        value, slopes = basis(node, log_omega, with_slopes)
        value[..., 2:, :] *= 1.0 + 0.01 * log_omega[..., None, :]
        return value, slopes

    monkeypatch.setattr(Continuum, "basis", crooked)
    found = check_model(free)
    assert any("dK / d ln omega" in says or "by_log_omega" in says for says in found)
    assert any("change of the unit of time" in says for says in found)
    assert any("is followed to" in says for says in found)
