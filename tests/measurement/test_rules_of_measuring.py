"""Small rules of what a test is and of what is told of it: by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import bartlett, f

from springpot.errors import DataError
from springpot.measurement import (
    Loading,
    Measurement,
    OtherTest,
    TimeTest,
    Units,
    measurement as measurement_module,
    mixed_up,
    noise_of,
    reader,
    replicates,
    rows,
    steady,
    timenoise,
)
from springpot.measurement.reader import Choice, Part
from springpot.measurement.replicates import average_repeats
from springpot.measurement.scatter import Noise

TIME = np.linspace(0.0, 10.0, 400)


def other(**given):
    """A test of a kind that springpot does not know."""
    told = {"at": np.array([0.0, 2.0, 5.0]), "control": "frequency"}
    told |= {"temperature": None, "marks": {}}
    made = SimpleNamespace(name="own", units=Units("Pa", "-"), **(told | given))
    return type("Own", (), {"__len__": lambda self: 3, **vars(made)})()


def of(name, test):
    return vars(OtherTest)[name].fget(test)


def test_a_test_of_another_kind_tells_what_it_saw_and_where():
    assert of("seen", other()) == pytest.approx((4.0 * np.pi, 10.0 * np.pi))
    assert of("seen", other(control="force")) == pytest.approx((0.2, 0.5))
    assert of("reach", other()) == 0.0
    assert of("reference_temperature", other(temperature=20.0)) == pytest.approx(293.15)
    assert of("reference_temperature", other()) == pytest.approx(298.15, abs=5.0)
    assert of("conditions", other()) == {}
    assert of("conditions", other(temperature=20.0))["temperature"].tolist() == [20.0] * 3
    assert of("columns", other(conditions={}))["row"].tolist() == [1.0, 2.0, 3.0]
    same = other()
    assert OtherTest.in_units(same, Units("Pa", "%")) is same
    with pytest.raises(DataError, match="tells of Pa and the other test of kPa"):
        OtherTest.in_units(same, Units("kPa", "-"))


@pytest.mark.parametrize(
    ("unit", "value", "control", "units"),
    [
        ("%", 0.5, "displacement", ("-", "Pa")),
        ("mm", 50.0, "displacement", ("mm", "N")),
        ("kN", 50.0, "force", ("m", "kN")),
        ("MPa", 50.0, "force", ("-", "MPa")),
        ("deg", 50.0, "displacement", ("deg", "N m")),
    ],
)
def test_a_planned_test_has_a_load_and_no_answer(unit, value, control, units):
    test = TimeTest.planned([0.0, 1.0, 2.0], [0.0, 50.0, 50.0], unit)
    assert (test.control, test.displacement_unit, test.force_unit) == (control, *units)
    assert test.loading.value.max() == pytest.approx(value)
    assert test.response.tolist() == [0.0, 0.0, 0.0]
    assert not test.measured
    with pytest.raises(DataError, match="is no unit of a displacement"):
        TimeTest.planned([0.0, 1.0], [0.0, 1.0], "K")


def test_a_few_samples_have_a_noise_that_is_assumed():
    test = TimeTest.of_relaxation([1.0, 2.0, 3.0], [4.0, 4.0, 4.0])
    noise = noise_of(test)
    assert not noise.estimated
    assert noise.absolute == pytest.approx(0.4 * noise.relative)
    np.testing.assert_allclose(noise.sd, noise.relative * np.hypot(4.0, 0.4), rtol=1e-6)


def test_a_loading_runs_backwards_where_its_time_first_falls():
    with pytest.raises(DataError, match="backwards after 2 s"):
        Loading(np.array([0.0, 1.0, 1.0, 2.0, 0.5, 2.0, 1.5, 3.0]), np.arange(8.0))


def test_a_scale_that_repeats_told_is_a_students():
    told = {"repeats": -0.5 * 14.0 * np.log(2.0), "estimated": -5.0 * np.log(4.0)}
    for source, expected in told.items():
        noise = Noise(np.ones(5) * (1 + 1j), 4.0, source)
        assert noise.log_likelihood(4.0, 10) == pytest.approx(expected)
        assert not noise.overruled
    assert Noise(np.ones(5) * (1 + 1j), np.inf, "given").log_likelihood(4.0, 10) == -2.0
    assert Noise(np.ones(5) * (1 + 1j), 4.0, "estimated", "doubt").overruled
    assert not Noise(np.ones(5) * (1 + 1j), 4.0, "given", "doubt").overruled


def history(pulled, time=TIME):
    return SimpleNamespace(
        time=time,
        loading=SimpleNamespace(time=time, value=np.sin(time)),
        response=pulled,
        control="displacement",
        kind="history",
    )


def test_a_sign_is_doubted_where_neither_part_is_left():
    for phase, wrong in ((0.4, False), (np.pi + 0.4, True), (np.pi - 0.4, False)):
        found = mixed_up.sign_note(history(np.sin(TIME + phase)), "force=-N")
        assert bool(found) is wrong
        assert mixed_up.said_of_sign({**found, "note other": "no"}) == list(found.values())
        assert (mixed_up.turned(found) == "FILE?force=-N") is wrong
    # Where time stands still, nothing moves or moving is all one, nothing is sure.
    still = np.repeat(TIME[::2], 2)
    assert not mixed_up._gives_work(still, np.sin(still), -np.sin(still + 0.4))
    assert not mixed_up._gives_work(TIME, 0.0 * TIME, -TIME)
    assert not mixed_up._gives_work(TIME, np.exp(TIME), -np.exp(TIME))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_fluid_that_has_relaxed_or_been_released_is_not_opposed_to_its_load(sign):
    """What it answers then is noise of either sign, or that of a load that is nothing."""
    t = np.arange(200.0)
    strain, stress = np.where(t < 60.0, 1.0 + t, 61.0), np.where(t < 60.0, 1.0, -1e-9)
    tests = [TimeTest.of_history(t, sign * strain, stress, "-", "Pa", control="force")]
    relaxed = np.exp(-t / 5.0) - 1e-3
    tests.append(TimeTest.of_history(t, 0.0 * t + 1.0, sign * relaxed, "-", "Pa"))
    assert [test.kind for test in tests] == ["recovery", "relaxation"]
    assert [bool(mixed_up.sign_note(test, "force=-N")) for test in tests] == [sign < 0.0] * 2


def test_parts_that_ask_are_usable_where_what_they_ask_was_said():
    asks, plain = Part("a", 3, False, "which unit?", asks=True), Part("b", 0, False, "empty")
    opened = SimpleNamespace(provenance={"note parts": "a"})
    assert reader.parts_as_opened([asks, plain], opened) == [Part("a", 3, asks=True), plain]
    silent = SimpleNamespace(provenance={"note parts": "a", "note a": "left out"})
    assert reader.parts_as_opened([asks, plain], silent) == [asks, plain]
    assert reader.parts_as_opened([asks], SimpleNamespace(provenance={})) == [asks]


def test_a_reader_that_stumbles_is_told_by_its_first_line(tmp_path):
    def fails(message):
        def read():
            raise ValueError(message)

        known = SimpleNamespace(name="mine", recognises=lambda head: 1 / 0)
        assert reader._confidence(known, b"x") == 0.0
        with pytest.raises(DataError) as caught:
            reader.guarded(known, tmp_path, read, Choice())
        return str(caught.value)

    assert fails("one\ntwo").endswith("one")
    assert "failed" in fails("")
    assert not reader.is_file("a\0b")
    assert not reader.is_file("x" * 100_000)
    assert not reader.names_file("a?=b")


def test_a_long_list_of_values_is_cut_before_its_last():
    values = [str(i) for i in range(rows.LISTED + 1)]
    shown = rows._listed(values).split(", ")
    assert len(shown) == rows.LISTED
    assert shown[-3:] == [str(rows.LISTED - 3), "...", str(rows.LISTED)]
    assert "..." not in rows._listed(values[1:])


@pytest.mark.parametrize(
    ("ages", "frequencies", "age"),
    [
        ([1, 1, 2, 2], [1, 2, 1, 2], True),
        ([1, 1, 2, 2], [1, 2, 3, 4], False),
        ([1] * 4, [1, 2] * 2, False),
    ],
)
def test_a_time_stands_for_sweeps_where_frequencies_come_again(ages, frequencies, age, monkeypatch):
    monkeypatch.setattr(mixed_up, "frequency_numbers", lambda data: np.array(frequencies))
    data = SimpleNamespace(conditions={mixed_up.TIME: np.array(ages, float)})
    assert mixed_up._stands_for_sweeps(data, mixed_up.TIME) is age


@pytest.mark.parametrize(("moved", "told"), [(0.0, 0.0), (1e-3, 1.0)])
def test_rows_that_were_written_again_tell_nothing_of_the_noise(moved, told):
    omega, stiffness = np.array([1.0, 2.0, 1.0, 2.0]), np.array([10.0, 20.0, 10.0, 20.0]) + 1j
    stiffness[2:] *= 1.0 + moved
    data = Measurement(omega, stiffness, repeat=np.array([0, 0, 1, 1]))
    found = average_repeats(data)
    assert found.scatter.dof.tolist() == [told, told]
    assert found.mean.repeat is None
    np.testing.assert_allclose(found.mean.stiffness, stiffness[:2] * (1.0 + moved / 2.0), rtol=1e-6)


@pytest.mark.parametrize(
    ("values", "left"),
    [
        ([1.0 + 1.0j, 0.0 + 0.0j], []),
        ([-1.0 + 1.0j, 2.0], ["note storage"]),
        ([1.0 - 1.0j, 2.0], ["note loss"]),
        ([-1.0 - 1.0j, 2.0], ["note storage", "note loss"]),
        ([-1.0 - 1.0j, -1.0 - 1.0j, 2.0], ["note storage", "note loss", "note sign"]),
    ],
)
def test_of_some_rows_a_note_on_a_sign_stays_where_one_of_them_has_it(values, left):
    notes = {"note storage": "a", "note loss": "b", "note sign": "c", "rig": "d"}
    kept = measurement_module._of_rows(notes, np.array(values, dtype=complex))
    assert list(kept) == [*left, "rig"]


@pytest.mark.parametrize("counts", [(5, 9), (8, 8, 8), (4, 30, 12)])
def test_scatters_are_alike_by_the_test_of_bartlett(monkeypatch, counts):
    rng = np.random.default_rng(7)
    samples = [size * rng.normal(size=n) for n, size in zip(counts, (1.0, 2.2, 1.4), strict=False)]
    sizes, worth = np.array([np.std(each, ddof=1) for each in samples]), np.array(counts) - 1.0
    chance = bartlett(*samples).pvalue
    monkeypatch.setattr(timenoise, "DOUBTED", 1.0001 * chance)
    assert timenoise._unlike(sizes, worth) is not None
    monkeypatch.setattr(timenoise, "DOUBTED", 0.9999 * chance)
    assert timenoise._unlike(sizes, worth) is None


def test_scatter_of_nothing_is_like_no_other():
    assert timenoise._unlike(np.array([1.0, 0.0, 2.0]), np.full(3, 9.0)) == 1


@pytest.mark.parametrize(
    ("samples", "span", "omega", "seconds"),
    [
        (1000, 40.0, 2.0 * np.pi, 40.0),
        (1000, 4.0, 2.0 * np.pi, 16.0),
        (1 << 19, 400.0, 2.0 * np.pi, 100.0),
    ],
)
def test_a_frequency_is_known_over_an_excerpt_or_some_cycles(samples, span, omega, seconds):
    """The excerpt is of 2^17 samples, the cycles are sixteen."""
    record = SimpleNamespace(span=span, time=np.empty(samples))
    assert steady.excerpt_span(record, omega) == pytest.approx(seconds)


def test_runs_differ_by_an_analysis_of_variance(monkeypatch):
    """Gains of each run against what gains and slopes of each leave, by Fisher's test."""
    rng, runs, omega = np.random.default_rng(3), 3, np.geomspace(1.0, 50.0, 8)
    exact = 5.0 + 1j * omega**0.5
    scatter = 0.01 * (rng.normal(size=(runs, 8)) + 1j * rng.normal(size=(runs, 8)))
    gains = np.array([0.0, 0.012, -0.008])[:, None]
    stiffness = exact * (1.0 + gains) * (1.0 + scatter)
    data = Measurement(
        np.tile(omega, runs), stiffness.ravel(), repeat=np.repeat(np.arange(runs), 8)
    )
    off = (stiffness / stiffness.mean(axis=0) - 1.0).ravel()
    of_run = np.kron(np.eye(runs), np.ones((8, 1)))
    centred = np.kron(np.eye(runs), (np.log(omega) - np.log(omega).mean())[:, None])

    def left(design):
        return np.sum(np.abs(off - design @ np.linalg.lstsq(design, off, rcond=None)[0]) ** 2)

    both, spent = left(np.hstack([of_run, centred])), 2.0 * (runs - 1)
    free = 2.0 * (runs - 1) * (8 - 2)
    variance = both / free
    by_gain = (np.sum(np.abs(off) ** 2) - left(of_run)) / spent / variance
    by_slope = (left(of_run) - both) / spent / variance
    chance = float(f.sf(by_gain, spent, free))
    assert float(f.sf(by_slope, spent, free)) > 0.1 > chance
    for share, differ in ((1.001, True), (0.999, False)):
        levels = replicates.OUTLIERS._replace(rare=share * chance)
        monkeypatch.setattr(replicates, "OUTLIERS", levels)
        found = average_repeats(data)
        assert (found.gains is not None) is differ
    # Each row pays its share of what the gains have taken.
    monkeypatch.setattr(replicates, "OUTLIERS", levels._replace(rare=1.001 * chance))
    found = average_repeats(data)
    np.testing.assert_allclose(found.scatter.dof, 2.0 * (1.0 - (runs - 1) / 16.0))
    np.testing.assert_allclose(found.mean.stiffness, exact, rtol=0.02)
    assert replicates.average_repeats(data).floor(
        Noise(0.01 * found.mean.magnitude * (1.0 + 1.0j), np.inf, "given")
    ) == pytest.approx(np.hypot(0.01 * np.sqrt(2.0 * runs), found.own_gain))


@pytest.mark.parametrize(
    ("made", "power", "says"),
    [
        (TimeTest.of_compliance, 0.2, ""),
        (TimeTest.of_compliance, -0.2, "the strain falls by 72 %"),
        (TimeTest.of_relaxation, -0.2, ""),
        (TimeTest.of_relaxation, 0.2, "the stress grows by 262 %"),
    ],
)
def test_what_goes_back_under_a_load_that_is_held_is_noted(made, power, says):
    """A recovery of which only the end is in the file looks like a creep."""
    clock = np.geomspace(0.1, 100.0, 30)
    note = mixed_up.history_note(made(clock, 2.0 * clock**power)).get("note history", "")
    assert says in note
    assert bool(says) is bool(note)


def test_of_a_record_that_swings_nothing_is_held():
    clock = np.linspace(0.0, 6.0, 60)
    test = TimeTest.of_history(clock, np.sin(clock), np.exp(-clock), "mm", "N")
    assert mixed_up.history_note(test) == {}
