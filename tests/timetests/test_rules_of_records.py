"""Small rules of tests in time, by hand: what stands out where, what starts, what is a law."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.identification import convex
from springpot.measurement import Loading
from springpot.misfit import (
    coloured_noise as colour,
    residual_scatter as scatter,
    where_in_time as where,
)
from springpot.misfit.residual_scatter import ResidualScatter
from springpot.rheology.elements import Continuum
from springpot.thresholds import EVIDENCE
from springpot.timetests import (
    hypotheses,
    screening,
    temperatures,
    verdict,
)
from springpot.timetests.hypotheses import FitResiduals, explains_as_well, no_worse
from springpot.timetests.material import spectrum_of

TIME = np.linspace(0.0, 4.0, 401)
RUN = np.sin(2.0 * np.pi * TIME)
BY_TURNS = np.repeat(np.tile([1.0, -1.0], 20), 5)


def record(value=RUN, kind="history"):
    """A record of so much imposed, as the searched rules see it."""
    return SimpleNamespace(
        kind=kind, time=TIME, loading=SimpleNamespace(time=TIME, value=value), words=("x", "y")
    )


def slow_of(value):
    """Where a motion is slower than 0.3 of what it usually reaches."""
    rate = np.abs(np.gradient(value, TIME))
    return rate < where.SLOW * np.percentile(rate, where.USUAL_TOP)


@pytest.mark.parametrize(
    ("slow", "fast", "says"),
    [
        (1.52, 1.0, "; all along, where the motion turns"),
        (1.48, 1.0, ""),
        (1.0, 1.48, ""),
        (1.0, 1.52, "; all along, where the motion is fast"),
    ],
)
def test_a_record_is_missed_where_it_turns_or_is_fast_by_half_as_much_again(slow, fast, says):
    residual = np.where(slow_of(RUN), slow, fast) * np.cos(np.pi * np.arange(401))
    assert where._manner(record(), residual) == says
    assert where._manner(record(kind="creep"), residual) == ""
    assert where._manner(record(value=0.5 * TIME), residual) == ""


def test_what_only_rises_turns_nowhere_and_closes_no_loop():
    """An indentation that slows down, and a ramp that is held."""
    for value in (np.sqrt(TIME), np.minimum(TIME, 1.0)):
        pressed = record(value=value)
        pressed.name, pressed.response = "pressed", value
        residual = np.where(slow_of(value), 9.0, 3.0)
        [place] = where.places(pressed, residual)
        assert place.says.endswith("; all along, where the motion is slow")


def test_a_single_sample_is_missed_at_a_time_and_not_from_it_to_itself():
    few = SimpleNamespace(
        kind="creep", time=np.arange(1.0, 8.0), response=np.ones(7), name="few", words=("x", "y")
    )
    [place] = where.places(few, np.array([1.0, 1.0, 1.0, 9.0, 1.0, 1.0, 1.0]))
    assert (
        place.says == "few is missed most at 4 s, by 9 x the noise: the model's y is larger there"
    )


@pytest.mark.parametrize(("after", "told"), [(1.52, True), (1.48, False)])
def test_a_loop_is_missed_after_its_turns_in_the_first_quarter_of_each_way(after, told):
    """Sixteen samples up, sixteen down: four of each way are fresh."""
    imposed = np.tile(np.r_[0.0:16.0, 16.0:0.0:-1.0], 3)
    fresh = np.zeros(96, dtype=bool)
    for first in range(16, 96, 16):
        fresh[first : first + 4] = True
    residual = np.where(fresh, after, 1.0)
    assert (where._after_turn(imposed, residual) == "; just after each turn") is told
    # Two turns are too few to tell.
    assert where._after_turn(imposed[:48], 9.0 * fresh[:48] + 1.0) == ""
    assert where._after_turn(imposed[:64], 9.0 * fresh[:64] + 1.0) != ""


def test_the_answer_to_a_step_is_that_of_its_elements():
    t, when = np.array([0.0, 1.0, 3.0]), 0.5
    loading = SimpleNamespace(jumps=(np.array([when]), np.array([2.0])), smooth=None)
    after, since = np.array([0.0, 1.0, 1.0]), np.array([0.0, 0.5, 2.5])
    fading = np.exp(-since / 4.0)
    found = convex.answers_of(loading, "displacement", np.array([4.0]), t)
    nothing = np.zeros(3)
    np.testing.assert_allclose(
        found, np.array([2.0 * after, nothing, nothing, 2.0 * after * fading]).T
    )
    found = convex.answers_of(loading, "force", np.array([4.0]), t)
    np.testing.assert_allclose(
        found,
        np.array([2.0 * after, 2.0 * since, nothing, 2.0 * after * (1.0 - fading)]).T,
    )
    mixed = convex.answers_of(loading, "force", np.array([4.0]), t, np.array([[1.0, 2, 3, 4]]).T)
    np.testing.assert_allclose(mixed, found @ np.array([[1.0, 2, 3, 4]]).T)


def test_the_answer_to_a_ramp_of_force_is_its_integral():
    grid = np.linspace(0.0, 2.0, 5)
    loading = Loading(grid, 3.0 * grid)
    t = np.array([0.5, 1.7])
    found = convex.answers_of(loading, "force", np.array([4.0]), t)
    np.testing.assert_allclose(found[:, 0], 3.0 * t)
    np.testing.assert_allclose(found[:, 1], 1.5 * t**2)
    np.testing.assert_allclose(found[:, 3], 3.0 * (t - 4.0 * (1.0 - np.exp(-t / 4.0))))
    found = convex.answers_of(loading, "displacement", np.array([4.0]), t)
    np.testing.assert_allclose(found[:, 1], 3.0)
    np.testing.assert_allclose(found[:, 3], 12.0 * (1.0 - np.exp(-t / 4.0)))


@pytest.mark.parametrize(
    ("plane", "needs", "law"),
    [
        ("shift", {"temperature"}, True),
        ("shift", {"temperature", "water"}, False),
        ("shift", {"water"}, False),
        ("stiffness", {"temperature"}, False),
    ],
)
def test_a_law_of_temperature_shifts_by_it_alone(plane, needs, law):
    assert temperatures.is_law(SimpleNamespace(plane=plane, needs=needs)) is law


@pytest.mark.parametrize(("left", "taken"), [(0.9, True), (1.0, False), (1.2, False)])
def test_an_effect_that_lowers_nothing_leaves_what_was_left(monkeypatch, left, taken):
    monkeypatch.setattr(hypotheses, "sum_of_squares", lambda left: left.power)
    monkeypatch.setattr(hypotheses, "replace", lambda each, **new: SimpleNamespace(**new))
    tried = SimpleNamespace(left=SimpleNamespace(power=left, count=7), fit="fit")
    found = no_worse(tried, SimpleNamespace(power=1.0, count=3))
    assert (found is tried) is taken
    if not taken:
        assert (found.left.count, found.fit) == (7, None)


def test_cosines_are_read_from_the_logarithm_of_a_spectrum():
    """Of a memory of 0.6 the k-th is 2 0.6^k / k; what rises beside it is taken out before."""
    omega = np.pi * (np.arange(4000) + 0.5) / 4000
    level = 4.0 * (1.0 - 0.36) / (1.36 - 1.2 * np.cos(omega))
    basis, triangle = np.linalg.qr(colour._cosines(omega))
    white, *more = colour._exponentials(basis.T @ np.log(level), triangle, 0.1)
    assert white.variance == pytest.approx(4.0 * (1.0 - 0.36))
    assert (white.cosines, white.corner) == ((), 0.1)
    assert len(more) == colour.ORDERS
    for order, one in enumerate(more, 1):
        k = np.arange(1, order + 1)
        assert one.variance == pytest.approx(2.56)
        assert one.cosines == pytest.approx(2.0 * 0.6**k / k, abs=1e-9)


@pytest.mark.parametrize(
    ("helps", "delta", "squares", "alike"),
    [
        (False, 1.0, 99.0, True),
        (False, EVIDENCE.rivals + 1.0, 0.0, False),
        (True, EVIDENCE.rivals + 1.0, EVIDENCE.rivals, True),
        (True, EVIDENCE.rivals + 1.0, EVIDENCE.rivals + 0.1, False),
    ],
)
def test_an_effect_explains_as_well_by_its_criterion_or_by_its_squares(
    helps, delta, squares, alike
):
    def of(squares, delta, helps):
        judged = SimpleNamespace(misfit=True)
        left = SimpleNamespace(
            squares=lambda noise: squares, beside=lambda noise: judged, over=lambda noise: 1.0
        )
        return SimpleNamespace(left=left, delta=delta, helps=helps)

    best = of(50.0, 100.0, True)
    assert explains_as_well(of(50.0 + squares, 100.0 - delta, helps), best, None) is alike


@pytest.mark.parametrize(
    ("lead", "helps", "size", "alike"),
    [
        # Now far behind, now ahead, or a little behind all along: by 24 in sum, either way.
        (BY_TURNS, True, 1.0, True),
        (0.0 * BY_TURNS, True, 1.0, False),
        # One that does not help, or leaves more than noise, stays out however its lead scatters.
        (BY_TURNS, False, 1.0, False),
        (BY_TURNS, True, 0.3, False),
    ],
)
def test_a_rival_at_the_noise_is_excluded_only_beyond_the_scatter_of_the_lead(
    lead, helps, size, alike
):
    best, each, noise = with_lead(lead, size, helps)
    assert explains_as_well(each, best, [noise]) is alike


def with_lead(lead, size=1.0, helps=True):
    """Two explanations of which one leaves so much more of each square (n,), and the noise."""
    noise, n = ResidualScatter(size, 0.0, 0.0, 1.0), len(lead)
    # Up and down, as what repeats the sample before is no noise.
    one = np.tile([1.0, -1.0], n // 2)
    best, each = (
        SimpleNamespace(
            left=FitResiduals(1, (value,), (noise,), (np.zeros((0, n)),), (np.zeros(n),)),
            delta=delta,
            helps=helps,
        )
        for value, delta in ((one, 100.0), (np.sqrt(1.12 + lead) * one, 60.0))
    )
    return best, each, noise


@pytest.mark.parametrize(("squares", "alike"), [(6.0, True), (12.0, False)])
def test_no_effect_explains_as_well_that_leaves_more_than_the_noise_of_the_best(squares, alike):
    """So few samples hardly tell how large the noise is, but it is the same for both."""
    best, each, noise = with_lead(np.where(np.arange(40) < 3, squares, 0.0))
    assert not each.left.beside([noise]).misfit
    assert explains_as_well(each, best, [noise]) is alike


@pytest.mark.parametrize(
    ("alone", "agrees", "columns", "says"),
    [
        (1.1, False, {"temperature"}, "they are not of one specimen in one state"),
        (1.1, False, {}, "no column tells"),
        (1.1, False, {}, "or the specimen is not linear"),
        (1.1, True, {}, ""),
        (verdict.VERDICT.agrees, False, {}, ""),
    ],
)
def test_tests_that_agree_with_a_material_each_alone_are_of_several(alone, agrees, columns, says):
    parts = [SimpleNamespace(conditions={}), SimpleNamespace(conditions=columns)]
    tests = [
        SimpleNamespace(points=9, over_floor=1.0, over_floor_alone=1.0, agrees=True),
        SimpleNamespace(points=9, over_floor=1.2 * alone, over_floor_alone=alone, agrees=agrees),
    ]
    found = verdict.said_apart(parts, tests, tests)
    assert bool(found) is bool(says)
    assert says in found
    if says:
        assert found.startswith("each test by itself is followed to 1.1 x its noise")


def test_a_promise_is_its_drop_less_the_price_of_its_parameters(monkeypatch):
    """Noise of two, memory 0.6: sixteen squares are one; e^3 numbers price a parameter at 3."""
    monkeypatch.setattr(screening, "independent_samples", lambda residuals, scatters: np.exp(3.0))
    monkeypatch.setattr(screening, "_by_rig", lambda entries: list(entries.values()))
    monkeypatch.setattr(screening, "is_law", lambda effect: False)
    noise = SimpleNamespace(size=2.0, memory=0.6)
    before = SimpleNamespace(scatters=[noise], residuals=[None, None])
    two = screening.TWO_DEVIATIONS

    def of(units, values):
        return [
            SimpleNamespace(drop=16.0 * units, values=[0] * values, effect=None, as_its_size=True)
        ]

    # Of ten and two parameters, of eight and one: 4 against 5.
    entries = {"a": of(two + 6.0, 2), "b": of(two + 4.0, 1), "c": of(0.9 * two, 0)}
    entries |= {name: of(1.1 * two, 5) for name in "defg"}
    found = screening.leading_of_scan(entries, before)
    assert found[:2] == [entries["b"], entries["a"]]
    assert entries["c"] not in found
    assert len(found) == 6


def test_a_material_has_its_lines_after_spring_and_dashpot():
    model = SimpleNamespace(material=Continuum((1.0, 10.0)))
    found = spectrum_of(model, np.array([5.0, 0.2, 3.0, 4.0, 99.0]))
    assert (found.equilibrium, found.viscosity) == (5.0, 0.2)
    assert (found.rates.tolist(), found.weights.tolist()) == ([1.0, 10.0], [3.0, 4.0])


@pytest.mark.parametrize(
    ("missed", "mirror", "says"),
    [
        ((4, True), 1.0, "at the upper end, x rising, by 4 x the noise; on that side alone, 1 x"),
        ((1, False), 1.0, "on the lower flank, x falling, by 4 x the noise; on that side alone"),
        ((3, True), 1.4, "on the upper flank, x rising, by 4 x the noise"),
        ((2, True), 1.0, "through the middle, x rising, by 4 x the noise; on that side alone"),
    ],
)
def test_a_loop_fails_where_its_part_is_missed_most(monkeypatch, missed, mirror, says):
    """Five parts each way, the noise elsewhere; the mirror image is the other end, back."""
    monkeypatch.setattr(where, "_flat", lambda test: "")
    monkeypatch.setattr(where, "_after_turn", lambda imposed, residual: "")
    share = np.array([-0.9, -0.5, 0.0, 0.5, 0.9])
    sector = np.digitize(RUN / np.abs(RUN).max(), where.EDGES) - 1
    rising = np.gradient(RUN, TIME) >= 0.0
    size = np.ones(401)
    part, way = missed
    size[(sector == 4 - part) & (rising != way)] = mirror
    size[(sector == part) & (rising == way)] = 4.0
    test = record()
    test.name = "made"
    found = where._in_loop(test, size * (-1.0) ** np.arange(401))
    assert found.says.startswith(f"in the loop of made the model fails most {says}")
    assert ("alone" in found.says) is (mirror < 4.0 / where.ONE_SIDED)
    assert found.low < share[part] < found.high
    assert (found.low, found.high) == (
        max(where.EDGES[part], -1.0),
        min(where.EDGES[part + 1], 1.0),
    )
    assert found.size == pytest.approx(4.0)
    # Two samples in all are too few for any part.
    short = SimpleNamespace(
        name="s", words=("x", "y"), time=TIME[:2], loading=SimpleNamespace(time=TIME, value=RUN)
    )
    assert where._in_loop(short, np.ones(2)) is None


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_the_worst_part_of_a_residual_is_judged_by_its_size_and_by_how_it_bends(
    monkeypatch, memory
):
    """Parts that bend as noise of that memory does are judged by size alone."""
    asked = []
    monkeypatch.setattr(
        scatter, "chance_of_squares", lambda *given: asked.append(given) or 0.01 / len(asked)
    )
    count = 12 * scatter.PARTS
    values = np.ones(count)
    values[:12] = np.linspace(3.0, 4.0, 12)
    values[12:24] = 5.0 * (-1.0) ** np.arange(12)
    # One is the median: of normal noise the size is more.
    usual = scatter.NORMAL
    assert scatter._worst_part(values, memory, 0.5) == pytest.approx(
        scatter.PARTS * 0.01 / len(asked)
    )
    assert len(asked) == scatter.PARTS
    part, whole = 6.0, 0.5 * count
    smooth, bent, *_ = asked
    assert smooth == pytest.approx(
        (part * np.mean(values[:12] ** 2) / usual**2, part, scatter.MEDIAN_WORTH * whole)
    )
    # Second differences of 20, over those of such noise: 6 - 8 r + 2 r^2.
    bends = (20.0 / usual) ** 2 / (6.0 - 8.0 * memory + 2.0 * memory**2)
    wanted = part * 25.0 / usual**2 / bends, part, scatter.EFFICIENT * part
    assert bent == pytest.approx(wanted)
    assert scatter._worst_part(np.zeros(count), memory, 0.5) == 1.0


def test_squares_of_noise_with_a_memory_are_fewer_independent_ones():
    """Of memory 0.5: by 3 of 5; and the same of the colour that is nearly this."""
    alone = scatter.ResidualScatter.independent_squares
    assert alone(SimpleNamespace(colour=None, memory=0.5), 100) == pytest.approx(60.0)
    k = np.arange(1, 9)
    own = colour.Colour(1.0, tuple(2.0 * 0.5**k / k), 0.0)
    assert alone(SimpleNamespace(colour=own, memory=9.0), 4000) == pytest.approx(2400.0, rel=2e-3)
