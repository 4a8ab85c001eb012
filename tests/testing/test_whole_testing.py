"""What contracts are tried on, number by number, and what they say of each slip, word for word."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.identification import Objective
from springpot.measurement import DataSet, Measurement, Units
from springpot.measurement.recording import Traced
from springpot.registry import plugins
from springpot.rheology import (
    PURE,
    STIFFNESS,
    Continuum,
    Dimension,
    Model,
    Parameter,
    Response,
)
from springpot.testing import contract, effects, networks, others

PARAMETERS = (
    Parameter("k", "k", STIFFNESS, 0.0),
    Parameter("narrow", "n", STIFFNESS, 0.9, 1.1),
    Parameter("order", "a", PURE, 0.2, 0.8, typical=0.5, scale="linear"),
    Parameter("shift", "b", PURE, -np.inf, typical=-3.0, scale="linear"),
)


def test_numbers_that_are_drawn_for_a_contract(stays):
    rng = np.random.default_rng(1)
    stays(
        {
            "one": networks.sample(PARAMETERS, rng),
            "few": networks.sample(PARAMETERS, rng, (2, 3)),
            "of the sample": networks._thetas(networks.SAMPLE),
            "points": [networks.POINTS.log_omega, networks.POINTS.amplitude],
            "temperature": networks.POINTS.temperature,
            "measured": networks.sample_measurement(),
            "problem": others.sample_problem().evaluate(np.array([1.0, 0.3, 0.2, 0.5])),
            "problem's data": others.sample_problem().measurement,
            "box": [others.sample_problem().lower, others.sample_problem().upper],
        }
    )


def test_files_that_a_reader_is_tried_on(stays, tmp_path):
    files = list(others._files([b"0123456789", b"", b"abc"]))
    versions = dict(others._versions())
    stays(
        {
            "files": [[len(each), hashlib.sha1(each).hexdigest()[:8]] for each in files],
            "versions": versions,
        }
    )
    longest = [len(each) for each in others._files([b"." * 20_000])]
    assert max(longest) == 1 << 14


def test_tests_in_time_that_a_law_is_tried_on(stays):
    stays([[test, effects._theta(effect, test)] for effect, test in of_each_kind()])


def of_each_kind():
    """Each test in time beside a law of the library that it can have."""
    of_test = [effect for effect in plugins().items("effect") if effect.of_test]
    for test in effects.tests_in_time():
        yield next(effect for effect in of_test if effect.applies_to(test)), test


def real(x):
    """What takes no complex numbers."""
    if np.iscomplexobj(x):
        raise TypeError("real numbers only")
    return x


@pytest.mark.parametrize(
    ("function", "exact"),
    [
        (lambda x: np.array([x[0] ** 3, x[0] * x[1]]), [[12.0, 0.0], [-3.0, 2.0]]),
        (lambda x: np.array([np.abs(x[1]) ** 2]), [[0.0, -6.0]]),
        (lambda x: np.array([real(x)[0] ** 2 * x[1]]), [[-12.0, 4.0]]),
    ],
    ids=["analytic", "not analytic", "real alone"],
)
def test_a_derivative_is_exact_whether_or_not_complex_numbers_are_taken(function, exact):
    found = networks.derivative(function, np.array([2.0, -3.0]))
    np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-9)


def test_a_parameter_of_zero_is_moved_by_a_ten_thousandth():
    asked = []
    networks.derivative(lambda x: asked.append(x[0]) or x, np.zeros(1))
    assert np.max(np.abs(asked)) == pytest.approx(1e-4)
    asked.clear()
    networks.derivative(lambda x: asked.append(x[0]) or x, np.array([-5.0]), 0.1)
    assert np.max(np.abs(np.array(asked) + 5.0)) == pytest.approx(0.5)


class Grown:
    """A model of two parameters, k and c, of which tests say what it responds."""

    names = ("k", "c")

    def __init__(self, respond, parameters=PARAMETERS[:2]):
        self.network, self.parameters = self, parameters
        self.respond = respond


def test_derivatives_are_told_from_a_hundred_millionth_on(monkeypatch):
    errors = {"k": [0.0, 0.9e-8], "c": [1e-8, 0.0]}
    rows = iter(np.transpose(list(errors.values())))
    slopes = iter([1e-9, 0.9e-8])
    monkeypatch.setattr(networks, "_thetas", lambda model: np.ones((2, 2)))
    monkeypatch.setattr(networks, "_by_theta", lambda model, row: next(rows))
    monkeypatch.setattr(networks, "_by_log_omega", lambda model, row: next(slopes))
    says = "dK/dc is not the derivative of K: off by 1.0e-08 relative to K/c"
    assert list(networks._derivatives(Grown(None))) == [says]
    rows, slopes = iter(np.zeros((2, 2))), iter([1e-8, 0.0])
    says = "by_log_omega is not dK/d ln omega: off by 1.0e-08 relative to K"
    assert list(networks._derivatives(Grown(None))) == [says]


def test_errors_of_derivatives_are_shares_of_k_over_the_parameter():
    def respond(theta, points, depth=0):
        k, c = theta
        along = np.array([1.0, 2.0])
        slopes = np.array([2.0 * k * along, np.full(2, 1.001)])
        return Response(k**2 * along + c + 0j, slopes + 0j, np.full(2, 0.5 + 0j))

    found = networks._by_theta(Grown(respond), np.array([3.0, 4.0]))
    # K is 13 and 22; dK/dc is 1, not 1.001.
    np.testing.assert_allclose(found, [0.0, 0.001 / (13 / 4 + 1.001)], rtol=1e-6, atol=1e-12)
    # Nothing changes with the frequency: 0.5 is wrong by itself.
    found = networks._by_log_omega(Grown(respond), np.array([3.0, 4.0]))
    assert found == pytest.approx(0.5 / 13.5)


def test_an_error_is_none_at_a_kink_and_endless_where_nothing_is_shown():
    def of(function, exact, natural):
        return networks._error(np.array(exact), function, np.ones(1), np.array(natural)).tolist()

    bent = 1.0 + 2e-3

    def kinked(x):
        return np.array([abs(real(x)[0] - bent), 2.0 * x[0]])

    # By real steps: complex ones would not be taken.
    assert of(kinked, [[1.0], [2.0]], [[1.0], [1.0]])[0] == [0.0]
    assert of(kinked, [[1.0], [3.0]], [[1.0], [4.0]])[1] == [pytest.approx(0.25)]
    assert of(kinked, [[np.nan], [2.0]], [[1.0], [1.0]])[0] == [np.inf]
    assert of(lambda x: kinked(x)[:1], [[1.0]], [[1.0]]) == [[np.inf]]
    # A derivative of next to nothing is held against the largest.
    assert of(lambda x: 0.0 * x, [[0.0], [1e-9]], [[1.0], [1e-30]])[1] == [pytest.approx(1.0)]


def test_names_bounds_and_units_of_parameters_word_for_word(stays):
    cases = {
        "in order": PARAMETERS,
        "twice": (PARAMETERS[0], PARAMETERS[0], PARAMETERS[2], PARAMETERS[2]),
        "names": [replace(PARAMETERS[0], name=name) for name in ("a.b", "1a", "k#1.c", "a b")],
        "typical": [replace(PARAMETERS[2], typical=size) for size in (0.2, 0.8, 0.19, 0.81)],
        "no room": [replace(PARAMETERS[2], lower=0.5, upper=0.5)],
        "logarithms": [
            replace(PARAMETERS[0], lower=lower, typical=typical)
            for lower, typical in ((0.0, 1.0), (-1.0, 1.0), (0.0, 0.0), (0.0, np.inf))
        ],
        "an order": [
            PARAMETERS[2],
            Parameter("c", "c", Dimension(1, "order"), 0.0),
            Parameter("d", "d", Dimension(1, "missing"), 0.0),
        ],
    }
    stays({name: list(networks._parameters(case)) for name, case in cases.items()})


def test_shapes_are_told_of_stacked_parameters(stays):
    exact = networks.SAMPLE.network.respond

    def spoilt(**parts):
        def respond(theta, points, depth=0):
            found = exact(theta, points, depth)
            return found._replace(**{name: of(getattr(found, name)) for name, of in parts.items()})

        return Grown(respond, networks.SAMPLE.parameters)

    def told(**parts):
        return sorted(networks._shapes(spoilt(**parts)))

    stays(
        [
            told(),
            told(value=lambda part: part[..., 1:]),
            told(by_theta=lambda part: part[..., :1, :], by_log_omega=lambda part: part[0]),
            told(value=lambda part: part * (1.0 + 1e-11)),
            told(value=lambda part: part * (part.ndim > 1)),
            told(by_theta=lambda part: part + 1e-9 * np.abs(part) * part.ndim),
        ]
    )


def test_parameters_in_other_units():
    grown = networks.SAMPLE + plugins().effect("inertia")
    theta = np.arange(1.0, 1.0 + len(grown.parameters))
    theta[3] = 0.5
    found = networks.converted(grown, theta, 1e-3, 1 / 60, 1e3)
    factors = dict(zip(grown.names, found / theta, strict=True))
    order = 60.0**-0.5
    known = {"k1": 1e-3, "k2": 1e-3, "c": 1e-3 * order, "alpha": 1.0}
    mass = next(name for name in factors if name not in known)
    known[mass] = 1e-3 / 3600.0
    assert factors == pytest.approx(known)


def test_powers_of_units_that_other_parameters_decide(stays):
    payne = networks.SAMPLE + plugins().effect("payne")
    theta = networks.sample(payne.parameters, np.random.default_rng(3))
    lines = Model("any", Continuum((0.1, 1.0)))
    stays(
        [
            networks.converted(payne, theta, 2.0, 3.0, 5.0),
            [networks._of_rates(lines, 1 / 60).material.rates],
        ]
    )


def test_words_of_names_and_summaries(stays):
    names = ("good", "Good", "a-b2", "a--b", "prony-N", "prony-n-N", "-a", "a_b")
    summaries = ("one", "two words", "x" * 158 + " y", "x" * 159 + " y", "a\nb", "stops here.", "")
    stays(
        {
            "names": [list(networks.name_and_summary(name, "two words")) for name in names],
            "aliases": list(networks.name_and_summary("good", "two words", ("a b", "ab", "C"))),
            "summaries": [list(networks.name_and_summary("good", each)) for each in summaries],
            "citations": [list(networks.cited(each)) for each in ("", " ", "x")],
        }
    )


# Laws of a test in time ---------------------------------------------------------------------------

LONG = 101
"""Samples of a record, of which the first does not count."""


@pytest.fixture
def record(monkeypatch):
    """Sets what the record of a law's parameters is; gives the law and a test of 101 samples."""
    effect, test = next(of_each_kind())
    times = np.geomspace(0.01, 100.0, LONG)
    test = replace(test, time=times, response=np.linspace(2.0, 4.0, LONG))

    def given(function):
        monkeypatch.setattr(effects, "recorded", function)
        return effect, test

    return given


SLOPES = np.cos(np.outer(np.arange(LONG), np.arange(1, 20))) + 2.0


@pytest.mark.parametrize(
    ("rows", "share", "told"),
    [
        (range(3), 2.5e-3, ""),
        (range(1, 4), 2.5e-3, ""),
        (range(1, 5), 2.5e-3, "4 %"),
        (range(97, 101), -2.5e-3, "4 %"),
        (range(1, 101), 1.5e-3, ""),
        (range(1, 101), 1.0, "100 %"),
    ],
)
def test_a_slope_is_wrong_where_it_differs_at_more_than_a_few_samples(record, rows, share, told):
    asked = []

    def linear(model, theta, test, tolerance):
        assert tolerance == 1e-9
        asked.append(theta)
        slopes = SLOPES[:, : len(theta)].copy()
        value = slopes @ theta
        slopes[list(rows), 2] += share * np.abs(slopes[1:, 2]).max()
        return Traced(value, slopes)

    effect, test = record(linear)
    found = list(effects._derivatives(effect, [test]))
    name = (effects.MODEL + effect).names[2]
    says = f"in a {test.kind} test the derivative by {name} is wrong at {told} of the samples"
    assert found == [says] * bool(told)
    # First where the slopes are told, then a millionth to both sides, one parameter at a time.
    step = 1e-6 * np.abs(asked[0])
    near = [(each - asked[0]) / step for each in asked if each is not asked[0]]
    both = [sign * row for row in np.eye(len(step)) for sign in (1.0, -1.0)]
    np.testing.assert_allclose(near[: 2 * len(step)], both, atol=1e-6)


def test_a_parameter_without_a_part_in_a_test_has_no_wrong_slope(record):
    def still(model, theta, test, tolerance):
        return Traced(np.ones(LONG), np.ones((LONG, len(theta))))

    effect, test = record(still)
    assert list(effects._derivatives(effect, [test])) == []


@pytest.mark.parametrize(
    ("change", "left", "told"),
    [
        (1.1e-4, 0.0, []),
        (0.9e-4, 0.0, ["it changes nothing at a size that is tried"]),
        (1.0, 0.9e-5, []),
        (1.0, 1.1e-5, ["of the record still changes when"]),
    ],
)
def test_a_law_changes_a_record_at_its_size_and_nothing_where_it_vanishes(
    record, change, left, told
):
    asked = []

    def moved(model, theta, test):
        asked.append(theta.copy())
        value = test.response.copy()
        value[0] = np.inf
        # The largest response is 4.
        value[1] += 4.0 * (change, left)[len(asked) - 1]
        return Traced(value, None)

    effect, test = record(moved)
    found = list(effects._law_vanishes(effect, [test]))
    assert [any(part in says for part in told) for says in found] == [True] * len(told)
    n = len(effects.THETA)
    assert asked[1][n] == pytest.approx(effect.vanishes_at + 1e-9 * abs(asked[0][n]), rel=1e-12)
    np.testing.assert_array_equal(np.delete(asked[0], n), np.delete(asked[1], n))


def test_a_record_has_its_shape_and_holds_numbers_after_the_first_sample(record, stays):
    effect, test = next(of_each_kind())
    wide = len(effects.THETA) + len(effect.element.parameters)

    def told(length, columns, hole=None, what="value"):
        def made(model, theta, test):
            found = Traced(np.ones(length), np.ones((length, columns)))
            if hole is not None:
                getattr(found, what)[hole] = np.nan
            return found

        law, test = record(made)
        return list(effects._shapes(law, [test]))

    stays(
        [
            told(LONG, wide),
            told(LONG - 1, wide),
            told(LONG, wide - 1),
            told(LONG, wide, 0),
            told(LONG, wide, 0, "by_theta"),
            told(LONG, wide, 1),
            told(LONG, wide, 1, "by_theta"),
            list(effects._suits([])),
            list(effects._suits([test])),
        ]
    )


def test_a_law_leaves_its_arguments_alone_and_gives_the_same_again(record):
    def told(change):
        count = iter(range(9))

        def made(model, theta, test):
            value = np.full(LONG, np.nan)
            change(next(count), theta, test, value)
            return Traced(value, None)

        law, test = record(made)
        return list(effects._pure(law, [test, test]))

    def scaled(part):
        part *= 2.0

    def later(count, theta, test, value):
        value[3] = count

    assert told(lambda *all_of_them: None) == []
    assert told(later) == ["the same parameters do not give the same record"]
    assert told(lambda count, theta, test, value: scaled(theta)) == ["it changes its arguments"]
    assert told(lambda count, theta, test, value: scaled(test.response)) == [
        "it changes its arguments"
    ]


# What is read and what is installed ---------------------------------------------------------------


def measured(n=2, unit="kN/m", **more):
    return Measurement(
        np.arange(1.0, n + 1), np.full(n, 1 + 1j), units=Units(unit), name="good-data", **more
    )


DATA = DataSet("good-data", "points of nothing", measured, licence="CC0", citation="nobody", size=2)


def test_words_of_data_sets(stays):
    summaries = ("two words", "three words here", "x" * 236 + " y z", "x" * 237 + " y z", "a\nb c")
    cases = {
        "names": [replace(DATA, name=name) for name in ("a", "a.b+c-d_e", ".a", "a#b", "a b")],
        "summaries": [replace(DATA, summary=each) for each in summaries],
        "kinds": [
            replace(DATA, kind=kind, citation="")
            for kind in ("measured", "artificial", "reconstruction", "guess")
        ],
        "licences": [replace(DATA, licence=each) for each in ("", " ", "x")],
        "unavailable": [replace(DATA, licence="", citation="", kind="guess", unavailable="no")],
    }
    stays({name: [list(contract._words(each)) for each in case] for name, case in cases.items()})


class Told:
    """A data set that gives what it is told, one after the other."""

    name, unavailable, remote, size = "good-data", "", "", 2

    def __init__(self, *given, **more):
        self.given = list(given)
        vars(self).update(more)

    def open(self):
        if self.unavailable:
            raise DataError(self.given.pop(0))
        return self.given.pop(0)


def test_a_data_set_gives_the_same_twice_or_says_why_it_cannot(stays):
    one = measured()
    other = replace(one, omega=2.0 * one.omega)
    noisy = replace(one, sd=0.1 * one.stiffness)
    stays(
        [
            list(contract._loads(each))
            for each in (
                Told(one, one),
                Told(one, one, size=3),
                Told(one, one, size=0),
                Told(one, one, name="other"),
                Told(one, other),
                Told(one, noisy),
                Told(noisy, one),
                Told(noisy, noisy),
                Told(noisy, replace(one, sd=0.2 * one.stiffness)),
                Told("no luck today", unavailable="no luck"),
                Told("no such file", unavailable="no luck"),
                Told(remote="somewhere"),
            )
        ]
    )


def test_the_truth_of_a_data_set_is_that_of_its_model(stays):
    own = {"mine": networks.SAMPLE}
    stays(
        [
            list(contract._truth(replace(DATA, model=model, truth=truth), own))
            for model, truth in (
                ("", {}),
                ("", {"k": 1.0}),
                ("kelvin-voigt", {}),
                ("kelvin-voigt", {"k": 1.0, "c": 1.0}),
                ("kelvin-voigt", {"k": 1.0}),
                ("mine", {"c": 1.0, "k1": 1.0, "k2": 1.0, "alpha": 0.5}),
                ("mine", {"k": 1.0}),
            )
        ]
    )


def test_weights_of_an_objective_are_told_one_by_one(stays):
    plain = networks.sample_measurement()
    n = len(plain)
    given = (
        np.full(n, 1 + 1j),
        np.full(n, 1 + 0j),
        np.full(n, 0 + 1j),
        np.full(n, 0j),
        np.full(n, 1.0),
        np.full(n - 1, 1 + 1j),
        np.r_[np.full(n - 1, 1 + 1j), -1 + 1j],
        np.r_[np.full(n - 1, 1 + 1j), 1 - 1j],
        np.r_[np.full(n - 1, 1 + 1j), np.inf],
        np.r_[np.full(n - 1, 1 + 1j), np.nan],
    )

    def told(weights):
        return list(contract._weights(Objective("o", "two words", weights)))

    changing = iter(np.arange(1.0, 9.0))

    def refusing(data):
        if data.sd is None:
            raise DataError("it needs them")
        return (1 + 1j) / data.sd.real

    stays(
        {
            "given": [told(lambda data, each=each: each) for each in given],
            "changing": told(lambda data: np.full(n, (1 + 1j) * next(changing))),
            "refusing": told(refusing),
            "data": contract._data(Objective("o", "two words", lambda data: given[0])),
            "data with deviations": contract._data(Objective("o", "two words", refusing)),
        }
    )


class Sounding:
    """A reader of which a test says what it makes of each file."""

    signals = text = None

    def __init__(self, read=None, sure=1.0, **more):
        self.made, self.sure = read, sure
        vars(self).update(more)

    def recognises(self, head):
        return self.sure(head) if callable(self.sure) else self.sure

    def read(self, path, choice):
        return self.made(path.read_bytes(), choice) if callable(self.made) else self.made


def refused(*given):
    raise DataError("no")


def test_what_a_reader_does_with_samples_and_garbage(stays, tmp_path):
    path, data = tmp_path / "sample.dat", measured()

    def wordless(*given):
        raise DataError("")

    def in_two_lines(*given):
        raise DataError("a\nb")

    def faulty(*given):
        raise KeyError("x")

    def by_choice(content, choice):
        return refused() if choice.part else data

    all_of_them = {
        "good": Sounding(data),
        "deaf": Sounding(data, 0.0),
        "sure": Sounding(data, 1.0 + 1e-9),
        "less than nothing": Sounding(data, -1e-9),
        "none": Sounding(),
        "refused": Sounding(refused),
        "signals": Sounding(refused, signals=lambda path, choice: data),
        "both refused": Sounding(refused, signals=refused),
        "wordless": Sounding(wordless),
        "two lines": Sounding(in_two_lines),
        "faulty": Sounding(faulty, faulty),
        "by choice": Sounding(by_choice),
    }
    answer = {}
    for name, reader in all_of_them.items():
        asked = [list(others._complaints_about(reader, b"x", path.write_bytes(b"x") and path))]
        if name != "faulty":
            asked.append(list(others._choice(reader, [b"1", b"2"], path)))
        if name not in ("faulty", "two lines", "wordless"):
            asked.append(list(others._samples(reader, [b"1", b"2"], path)))
        answer[name] = asked
    answer["without"] = list(others._samples(Sounding(data), [], path))
    answer["writing"] = list(others._samples(Sounding(data, text=str), [], path))
    stays(answer)


def test_the_same_fault_of_a_reader_is_told_once(tmp_path):
    [found] = others._garbage(Sounding(), [b"sample"], tmp_path / "sample.dat")
    assert found == "read gives no Measurement (a file that begins b'')"


def test_what_differs_after_a_round_trip(stays):
    one = measured(sd=np.full(2, 1 + 1j), conditions={"temperature": np.array([1.0, 2.0])})
    changed = (
        one,
        replace(one, units=Units("Pa")),
        replace(one, omega=one.omega * (1 + 1e-15)),
        replace(one, stiffness=one.stiffness * 2),
        replace(one, sd=None),
        replace(one, sd=2 * one.sd),
        replace(one, conditions={}),
        replace(one, conditions={"temperature": np.array([1.0, 3.0])}),
        replace(one, labels={"specimen": np.array(["a", "b"])}),
        replace(one, repeat=np.array([0, 1])),
    )
    stays([[list(others._differences(a, b)) for a, b in ((one, o), (o, one))] for o in changed])


def test_a_reader_may_refuse_what_its_format_cannot_hold(stays, tmp_path):
    path = tmp_path / "sample.dat"
    held = {}

    def text(data, refuse):
        if refuse(data):
            raise DataError("not that")
        held[len(held)] = data
        return str(len(held) - 1)

    def read(content, choice):
        return held[int(content)]

    def told(refuse, sure=1.0, read=read):
        reader = Sounding(read, sure, text=lambda data: text(data, refuse))
        return list(others._round_trip(reader, path))

    stays(
        [
            told(lambda data: False),
            told(lambda data: True),
            told(lambda data: data.sd is not None or bool(data.labels) or bool(data.conditions)),
            told(lambda data: False, 0.0),
            told(
                lambda data: False, read=lambda content, choice: replace(read(content, 0), sd=None)
            ),
            list(others._round_trip(Sounding(), path)),
        ]
    )


def same(**changed):
    """A run as `_same` sees it."""
    plain = {"theta": np.array([1.0, 0.0]), "status": "converged", "trace": [1]}
    return SimpleNamespace(**plain | changed)


@pytest.mark.parametrize(
    ("changed", "alike"),
    [
        ({}, True),
        ({"theta": np.array([1.0, -0.0])}, False),
        ({"status": "budget"}, False),
        ({"trace": [2]}, False),
    ],
)
def test_runs_are_the_same_to_the_bit(changed, alike):
    assert others._same(same(), same(**changed)) == alike
    assert others._same(same(**changed), same()) == alike


def test_each_kind_is_checked_with_what_its_contract_asks_for(monkeypatch):
    asked = {}

    def contract_of(word):
        return lambda thing, **more: asked.setdefault(word, (thing, more)) and []

    for word in contract.CONTRACTS:
        monkeypatch.setitem(contract.CONTRACTS, word, contract_of(word))
    whole = contract.Plugin("mine", {"good": [b"x"]}, {"good": ["words"]}, True)
    own = {"model": [networks.SAMPLE, "a family"]}
    vars(whole)["registry"] = SimpleNamespace(
        find=lambda word, name: f"{word} {name}", items=lambda word: own[word]
    )
    for word in contract.CONTRACTS:
        assert whole.check(word, "good") == []
    more = {
        "model": {"passive": True},
        "data set": {"models": {"sample": networks.SAMPLE}},
        "reader": {"samples": [b"x"]},
        "writer": {"read": None},
    }
    assert asked == {
        word: (f"{word} good", {"skip": ["words"], **more.get(word, {})})
        for word in contract.CONTRACTS
    }


def test_garbage_is_made_of_samples_else_of_what_a_reader_writes_else_of_a_table(monkeypatch):
    taken = []
    monkeypatch.setattr(others, "_files", lambda samples: taken.append(samples) or [])
    writing, reading = Sounding(measured(), text=lambda data: "text"), Sounding(measured())
    for reader, samples in ((writing, [b"1"]), (writing, []), (reading, [])):
        assert list(others._garbage(reader, samples, None)) == []
    assert taken == [[b"1"], [b"text"], [others.TABLE]]
