"""A law that is missing is found as a formula, with its class; where none is, none is invented."""

from __future__ import annotations

import json

import numpy as np
import pytest
from lawful_data import AMPLITUDE, OMEGA, lossy, material, swept

import springpot
from springpot import Invention, Measurement, Units
from springpot.errors import ModelError, OptionError
from springpot.invention import inventing, result


@pytest.mark.soak
def test_the_class_holds_the_law_its_exponent_and_what_would_tell_it_apart(found: Invention):
    assert found.verdict == "class"
    best = found.best
    assert best is not None
    assert best.text == "parallel: i*k*X^(-n)"
    n, k = best.parameters["n"], best.parameters["k"]
    assert n.low < 0.6 < n.high
    assert n.high - n.low < 0.1
    assert k.unit == "kN/m mm^n"
    assert best.error_after < 1.2 * found.error.noise_floor < 0.1 * found.error.relative_rms
    assert (best.causal, best.passive) == (True, True)
    assert "parallel: k*(1 + i*h)*X^(-n)" in best.alike
    assert found.next_experiment is not None
    assert found.next_experiment.separates[0] == "i*k*X^(-n)"


@pytest.mark.soak
def test_the_named_effect_of_which_it_is_a_special_case_is_told(found: Invention):
    assert found.best is not None
    assert "payne" in found.best.like
    assert "payne has the same curve here, with" in found.best.says


@pytest.mark.soak
def test_all_that_is_told_of_it(found: Invention, stays):
    stays(found.to_dict())


@pytest.mark.soak
def test_the_text_tells_class_floors_and_parameters(found: Invention):
    text = str(found)
    for word in ("verdict     class", "material floor", "i*k*X^(-n)", "next experiment", "payne"):
        assert word in text


@pytest.mark.soak
def test_its_picture_is_drawn(found: Invention, tmp_path):
    assert found.plot(tmp_path / "law.svg").stat().st_size > 10_000


@pytest.mark.soak
@pytest.mark.parametrize(
    ("units", "stiffness", "length"),
    [(("kN/m", "mm"), 1.0, 1.0), (("N/m", "m"), 1e3, 1e-3)],
    ids=["kN/m", "N/m"],
)
def test_nearly_exact_data_give_the_exponent_in_any_unit(units, stiffness, length):
    rng = np.random.default_rng(3)
    noise = 1e-4 * rng.normal(size=(2, len(OMEGA)))
    exact = lossy(material(OMEGA), AMPLITUDE) * (1.0 + noise[0] + 1j * noise[1])
    data = Measurement(
        OMEGA,
        stiffness * exact,
        conditions={"amplitude": length * AMPLITUDE},
        units=Units(*units),
    )
    best = springpot.invent(data).best
    assert best is not None
    answer = (best.text, round(best.parameters["n"].value, 3))
    assert answer == ("parallel: i*k*X^(-n)", 0.6)


@pytest.mark.soak
def test_exact_data_give_the_exponent_exactly():
    best = springpot.invent(swept(lossy, 0.0)).best
    assert best is not None
    assert best.text == "parallel: i*k*X^(-n)"
    assert best.parameters["n"].value == pytest.approx(0.6, abs=1e-4)


@pytest.mark.soak_cases("0", "1", "2")
@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_invented_from_noise(seed: int):
    found = springpot.invent(swept(lambda k, x: k, 0.01, seed))
    assert (found.verdict, found.best) == ("none", None)
    assert "noise alone goes as far" in found.says
    with pytest.raises(ModelError, match="no law was found of made"):
        found.effect()


@pytest.mark.soak
def test_what_no_formula_is_is_called_so(stays):
    found = springpot.invent(swept(lambda k, x: k * (1.0 + 0.1 * np.sin(9.0 * np.log(OMEGA) + x))))
    assert found.verdict == "none"
    assert "no law of the grammar follows it" in found.says
    # A law is tried under a name that nobody should read, in a unit neither.
    assert "try-" not in json.dumps(found.to_dict())
    stays(found.to_dict())


@pytest.mark.soak
def test_a_law_of_the_frequency_alone_is_one_beside_a_named_model():
    data = swept(lambda k, x: k - 400.0 - 0.004 * OMEGA**2, conditions={})
    sweep = data.subset(np.arange(8))
    assert "only where it does what no linear passive material does" in grammar_notes(sweep)[0]


def grammar_notes(data: Measurement) -> list[str]:
    return list(springpot.invent(data).notes)


def test_parameters_are_not_called_as_columns_are():
    column = {"k": AMPLITUDE, "too-long a name": AMPLITUDE}
    data = swept(lambda k, x: k, conditions=column)
    assert inventing.conditions_of(data) == ["k"]
    texts = [result.text_of(law) for law in result.candidates(data, ["k"])]
    assert "parallel: k2*k^n" in texts
    assert "parallel: i*k2/(1 + (k/Xc)^n)" in texts


def test_a_column_that_was_not_varied_is_refused_in_one_line():
    with pytest.raises(OptionError, match="no law can go with 'current' of made"):
        springpot.invent(swept(lossy), along="current")


@pytest.mark.soak
def test_a_condition_that_moved_with_the_rest_is_taken_where_it_is_asked_for():
    data = swept(lossy, conditions={"amplitude": 30.0 / OMEGA}).subset(np.arange(8))
    (note, *_) = springpot.invent(data, "spring", along="amplitude").notes
    assert "the amplitude moved with the rest" in note


@pytest.mark.soak
def test_two_terms_are_found_and_each_is_as_short_as_it_may_be():
    found = springpot.invent(swept(lambda k, x: k + 40j * x**-0.8 + 30.0 * x**0.5))
    assert found.best is not None
    assert "parallel: i*k*X^(-n) + k*r*X^n2" in found.best.alike


@pytest.mark.soak
def test_a_law_of_two_conditions_is_found():
    turn = np.tile(np.arange(8), 6) + np.repeat(np.arange(6), 8)
    current = np.array([0.0, 0.25, 0.5, 1.0])[turn % 4]
    force = (1.0 + (current / 0.3) ** 1.2) / AMPLITUDE
    columns = {"amplitude": AMPLITUDE, "current": current}
    found = springpot.invent(swept(lambda k, x: k + 20j * force, conditions=columns))
    assert found.best is not None
    assert found.best.text == "parallel: i*k*X^(-n)*(1 + (current/Xc)^n2)"
    assert found.best.parameters["n"].value == pytest.approx(1.0, abs=0.05)
    assert found.best.parameters["n2"].value == pytest.approx(1.2, abs=0.1)
