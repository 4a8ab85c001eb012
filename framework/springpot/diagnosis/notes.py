"""What else the user should know of a diagnosis, one sentence each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from math import hypot
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import chi2_sf
from springpot.identification.kept import note_on_levels, words_in
from springpot.identification.known_factors import refused_in_words
from springpot.identification.value import Value
from springpot.measurement.independence import at_one_frequency, moved_along
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import TIME, said_of_sign
from springpot.measurement.replicates import Averaged
from springpot.measurement.units import PRESSURE_UNITS
from springpot.misfit.drift_search import Course, moves_with_frequency
from springpot.misfit.error import percent, plain, times
from springpot.misfit.floor import is_arithmetic, scatter_about
from springpot.misfit.material import (
    NAME,
    MaterialFloor,
    beyond_any_material,
    notes_on_amplitudes,
    notes_on_levels,
)
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import validation
from springpot.misfit.residual_causes import Column, EqualRows, discrepancy, log_shift_of
from springpot.misfit.residual_tests import Finding
from springpot.rheology.effect import Effect
from springpot.rheology.parameters import INERTANCE
from springpot.rheology.points import Complex, Real
from springpot.thresholds import EVIDENCE, SCATTER, VERDICT
from springpot.writing import FEW, NAMED, listed, suggested

from .grown import Search
from .marginal import explaining_unknown, harmonic_evidence
from .result import Candidate, Diagnosis, Verdict

if TYPE_CHECKING:
    from .evidence import Evidence

MEANINGS = {
    -1.0: "as Coulomb friction would",
    0.0: "as a power-law damper would",
    2.0: "as a cubic spring would",
}
"""Power of the amplitude with which the third harmonic's share grows."""


def notes(
    evidence: Evidence,
    verdict: Verdict,
    outliers: Sequence[Outlier],
    cause: Column | EqualRows | Course | None,
    floor: MaterialFloor,
    measured: int,
    library: Sequence[Effect],
) -> Iterator[str]:
    """Sentences on the data, on what is left, and on how well the grown model predicts the unseen.

    Parameters
    ----------
    evidence : Evidence
        Of every effect, with the search behind it.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    outliers : sequence of Outlier
        Points set aside.
    cause : Column or EqualRows or Course or None
        With which of the columns the misfit goes, that repeats have no number, or how the specimen
        changed with time.
    floor : MaterialFloor
        What any material reaches in the place of the user's.
    measured : int
        Rows of the data before thinning.
    library : sequence of Effect
        Those with a factor for each level tell whether any shift would do.
    """
    search = evidence.search
    yield from _of_one_frequency(search)
    yield from refused_in_words(search.base.fit)
    yield from _of_data(search, outliers, measured)
    words = words_in(search.base.data.raw)
    yield from (note_on_levels(words, name) for name in words if name in search.base.model.needs)
    for finding in unexplained_harmonics(search, verdict):
        yield (
            f"{finding.says}; the model does not make it,"
            " and K of the first harmonic does not tell of it"
        )
    yield from _of_cause(evidence, verdict, cause)
    if isinstance(cause, Column):
        yield from _by_column(search.base.fit.measurement, cause, library)
    if isinstance(cause, Course):
        # What else would explain it, or cannot be told, is told of what stands still.
        if cause.last_round and not cause.begun:
            yield f"{cause.advice}{_by_rounds(library)}"
        return
    if verdict != "adequate" and cause is None:
        yield from beyond_any_material(floor)
        yield from notes_on_amplitudes(floor.refit)
    if verdict == "unexplained":
        yield from notes_on_levels(search.best, library)
    if evidence.narrow > VERDICT.worth_a_word:
        share = f"{100 * evidence.narrow:.0f} %"
        names = " and ".join(sorted(evidence.imitators))
        yield (
            f"other narrow features, such as an interference, look like {names}: "
            f"{share} of the probability is left to them"
        )
    # Beside an adequate model no effect is up for validation, and none is withheld from judgement.
    if verdict == "adequate":
        return
    if evidence.explanations:
        yield from validation(search.base, evidence.likeliest_with()[evidence.leader])
    yield from _confounded(evidence)
    yield from _beyond_physics(search)


def _of_cause(
    evidence: Evidence, verdict: Verdict, cause: Column | EqualRows | Course | None
) -> Iterator[str]:
    """With what the misfit goes, else what is left.

    Either as a fault that has a description, or in general.
    """
    search = evidence.search
    if cause is not None:
        yield cause.says
        return
    if verdict != "adequate" and moves_with_frequency(search.base.data.raw):
        yield (
            "the time was not varied by itself but goes with the frequency: what the specimen did"
            " meanwhile, no fit can tell; measure the first frequencies again at the end"
        )
    # Rows that stand by a setting differ "from row to row" too: where a condition that moved may be
    # the cause, nobody is to look for it in the measuring chain.
    kind, what = None, "what is left"
    if verdict in {"unexplained", "effect-missing"} and not search.confounded:
        kind = evidence.rest
    # A fault that follows less of the data than an effect does is no name for them.
    first = evidence.by_itself > VERDICT.likely or search.best is search.base
    if first and verdict == "unexplained" and not search.confounded:
        kind, what = explaining_unknown(search), "what is missing"
    if kind is not None and kind.says:
        yield f"{what} looks like {kind.says}: {kind.whose}"
    # What rounding leaves of computed data is full of patterns, and nothing is missing.
    elif search.left.p_value < VERDICT.structure_alarm and not is_arithmetic(search.base):
        yield from _of_rest(search)


def _by_column(
    measurement: Measurement, column: Column, library: Sequence[Effect]
) -> Iterator[str]:
    """How to join the values of a column.

    Water, cure and salt shift a material's times as a temperature does.
    """
    free = [effect for effect in library if effect.by_levels and effect.plane == "shift"]
    # Of words there is no more or less, and at one frequency no times show.
    if not free or column.name not in measurement.conditions or at_one_frequency(measurement):
        return
    if column.name == TIME:
        return
    yield (
        f"whether a factor of the times at each {column.name} joins them is told by "
        f"'{suggested('mastercurve', 'DATA', '--column', column.name)}'; "
        f"'{NAME} + {free[0].of_column(column.name).name}' fits them together"
    )


def _by_rounds(library: Sequence[Effect]) -> str:
    """How to join rounds of which each is a material of its own.

    By moduli that change, not by times.
    """
    factors = [effect.name for effect in library if effect.by_levels and effect.plane != "shift"]
    if not factors:
        return ""
    return f" and add {factors[0]} by it"


def _beyond_physics(search: Search) -> Iterator[str]:
    """That an effect which fits best would have to be larger than any specimen makes it."""
    units = search.base.fit.measurement.units
    refused: dict[str, str] = {}
    too_large: dict[Effect, None] = {}
    # Each once, in the order of the models.
    for grown in search.grown[:NAMED]:
        refused.update(grown.refused)
        # What is idle explains nothing of its own: there is nothing to tell.
        told = [effect for effect in grown.beyond_physics if not grown.is_idle(effect)]
        too_large.update(dict.fromkeys(told))
    for effect in too_large:
        if effect.name in refused:
            yield f"{effect.name} would explain much, but it {refused[effect.name]}: no law does so"
            continue
        end, reached = "the end of its range", "physics knows nothing of it there"
        if np.isfinite(effect.largest_of_modulus):
            _, unit = units.of(effect.element.parameters[0].unit)
            end = f"more than {plain(effect.largest_of_modulus)} {unit}"
            checked = "modulus"
            if "amplitude" in effect.needs:
                checked = "amplitude"
            reached = f"no specimen reaches that: is the unit of the {checked} right?"
        yield f"{effect.name} would explain much, but only at {end}; {reached}"


def _of_one_frequency(search: Search) -> Iterator[str]:
    """Why nothing is told of springs, dashpots and masses, where the frequency was not varied."""
    measurement = search.base.fit.measurement
    # Told first: it explains why the table below calls so much "cannot-tell".
    if at_one_frequency(measurement):
        where = measurement.units.at(float(measurement.frequency[0]))
        yield (
            f"all points have one frequency, {where}:"
            " what differs by its dependence on it cannot be told apart"
        )


def _of_data(search: Search, outliers: Sequence[Outlier], measured: int) -> Iterator[str]:
    """What was set aside, doubted or left out of the data, and how repeats differ."""
    yield from said_of_sign(search.base.data.raw.provenance)
    if outliers:
        places = ", ".join(map(str, outliers))
        kind = "single points stand out and were"
        if len(outliers) == 1:
            kind = "a single point stands out and was"
        hum = ""
        if any(outlier.at_mains for outlier in outliers):
            hum = "; mains hum has such frequencies"
        yield f"{kind} set aside, an outlier or narrow interference: {places}{hum}"
    if search.base.noise.doubt:
        yield search.base.noise.doubt
    yield from _of_floor(search)
    used = len(search.base.data.raw) + len(outliers)
    if measured > used:
        yield f"diagnosed on {used} of the {measured} points"
    if search.base.data.gains is not None:
        yield _of_own_gains(search.base.data)
    if search.repeats.p_value < VERDICT.beyond_doubt:
        yield (
            f"repeats differ by more than chance ({search.repeats.kind}):"
            " drift or a disturbance common to a sweep"
        )


def _of_own_gains(data: Averaged) -> str:
    """What sets replicates apart as a whole, and whether it goes one way, as slow drift would."""
    assert data.gains is not None, "there is something to tell of"
    differ = (
        f"replicates differ as a whole by {percent(data.own_gain)} (rms):"
        " each run was given a gain of its own"
    )
    # In the order in which the runs stand in the file; each row of a run has the gain of all.
    gains = data.gains[data.gains != 0.0].tolist()
    of_runs = np.array(list(dict.fromkeys(gains))).real
    steps = np.diff(of_runs)
    one_way = len(steps) > 1 and bool(np.all(steps > 0.0) or np.all(steps < 0.0))
    if not one_way:
        return differ
    # By chance three specimens stand like that one time in three: a word, and no verdict.
    values = ", ".join(f"{100 * gain:+.2g}" for gain in of_runs[:FEW])
    if len(of_runs) > FEW:
        values = f"{values}, ..."
    return (
        f"{differ}; from run to run it goes one way ({values} %): if they are one specimen,"
        " it drifts"
    )


def _of_floor(search: Search) -> Iterator[str]:
    """Why the floor is not the one that a fit of this model by itself tells.

    That one holds part of its misfit.
    """
    base = search.base
    if base.noise.memory:
        again = "; measured again, noise comes otherwise and a misfit does not"
        if base.noise.source == "repeats":
            again = ""
        yield (
            "the errors of neighbouring points of a sweep go together (correlation"
            f" {base.noise.memory:.2f}): the floor, all chances and all intervals count that{again}"
        )
    if base.noise.source != "estimated":
        return
    alone = base.floor * float(np.sqrt(scatter_about(base.frame()).variance))
    # By the very share at which the noise was estimated anew: else the note would come without a
    # cause.
    if alone > base.floor / SCATTER.sharper:
        yield (
            f"the noise floor is the scatter about the best model found; about {base.model} alone,"
            f" as identify and compare tell it, it looks like {percent(alone)}"
        )


def unexplained_harmonics(search: Search, verdict: Verdict) -> list[Finding]:
    """Loud force harmonics that the model, with what is missing from it, does not make.

    Parameters
    ----------
    search : Search
        Fits and scans.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    """
    # Beside "effect-missing" of the grown model: a friction that was found makes the harmonic
    # itself.
    refit = search.base
    if verdict == "effect-missing":
        refit = search.best
    explained = set()
    if harmonic_evidence(refit) >= EVIDENCE.unpredicted_harmonic:
        explained.add("harmonic 3")
    findings = judged(overtones(search.base.data.mean, search.base.noise.sd))
    # Loud as well as certain: every rig makes a little of them, and many points make a little
    # certain.
    loud = [each for each in findings if each.found and each.statistic > VERDICT.loud]
    return [each for each in loud if each.test not in explained]


def _of_rest(search: Search) -> Iterator[str]:
    """What the best model leaves, without a name for it."""
    best = search.best
    if best is not search.base:
        ratio = best.error / best.floor
        yield (
            f"the best model found, {best.model},"
            f" still leaves structure ({times(ratio)} the noise floor)"
        )
    yield from discrepancy(best.frame(), log_shift_of(best))


def _confounded(evidence: Evidence) -> Iterator[str]:
    """A sentence for each condition that varied, but not by itself."""
    everything = [*(one.grown for one in evidence.explanations), *evidence.search.confounded]
    explained = {effect.name: effect for grown in everything for effect in grown.effects}
    for name in sorted(moved_along(evidence.search.base.fit.measurement)):
        beside = "frequency or temperature"
        if name == "temperature":
            beside = "frequency"
        moves = f"the {name} was not varied by itself but moves with {beside}"
        says = f"{moves}; its effects are not judged"
        names = sorted(effect.name for effect in explained.values() if name in effect.needs)
        if evidence.moved:
            says = f"{moves}, of which no effect explains the data"
        elif names:
            says = f"{says}: {', '.join(names)} would explain the data as well, and no fit can tell"
        yield says


def header_notes(candidates: Sequence[Candidate], measurement: Measurement) -> Iterator[str]:
    """One sentence for each constant in the file's header whose effect was found, or may have been.

    Parameters
    ----------
    candidates : sequence of Candidate
        What the diagnosis says of each effect.
    measurement : Measurement
        The data, with what its file said of the instrument; nothing is told where they are no
        modulus.
    """
    if measurement.units.stiffness not in PRESSURE_UNITS:
        return
    for candidate in candidates:
        constant = candidate.physics.constant
        if (
            constant is None
            or candidate.verdict == "absent"
            or constant.parameter not in candidate.parameters
        ):
            continue
        stated = measurement.provenance.get(constant.fact)
        if stated is None:
            continue
        factor = _to_si(candidate.physics, constant.parameter, measurement)
        value = candidate.parameters[constant.parameter]
        # An interval without an end holds every number: that it holds this one is no agreement.
        if not np.isfinite(value.high):
            continue
        compared = _compared(float(stated.split()[0]), value, factor, candidate)
        yield f"the file's header gives {constant.says.format(stated=stated)}; {compared}"


def _to_si(effect: Effect, parameter: str, measurement: Measurement) -> float:
    """Factor from the printed unit of a parameter.

    A mass is printed in SI, whatever unit the data came in.
    """
    unit = next(each.unit for each in effect.element.parameters if each.name == parameter)
    if unit == INERTANCE:
        return 1.0
    return PRESSURE_UNITS[measurement.units.stiffness]


def _compared(stated: float, value: Value, factor: float, candidate: Candidate) -> str:
    """How a fitted value stands to the one in the header.

    Agreement says that no correction was made.
    """
    best, low, high = factor * value.value, factor * value.low, factor * value.high
    shown = f"{best:.3g} [{low:.3g}, {high:.3g}]"
    ratio = float("inf")
    if stated > 0:
        ratio = best / stated
    if low <= stated <= high or 1 / VERDICT.agrees <= ratio <= VERDICT.agrees:
        return (
            f"{candidate.effect} of {shown} agrees with it,"
            " as if the instrument had not corrected for it"
        )
    if ratio < 1:
        return (
            f"{candidate.effect} is found as {shown}, {ratio:.2g} of it: what a correction left,"
            " or another cause"
        )
    return (
        f"{candidate.effect} is found as {shown}, {ratio:.2g} times as much:"
        " the header does not explain it"
    )


def judged(findings: list[Finding]) -> list[Finding]:
    """Findings held against the number of tests made (Bonferroni), the surest first."""
    # No simulation as in the battery: harmonics are no part of K, and their noise is known in
    # closed form.
    tests = len(findings)
    findings = [
        replace(one, found=one.p_value * tests < VERDICT.harmonic_alarm) for one in findings
    ]
    return sorted(findings, key=lambda one: (not one.found, one.p_value))


def overtones(measurement: Measurement, noise: Complex) -> list[Finding]:
    """Tests on even and odd force harmonics; none where they were not measured.

    Parameters
    ----------
    measurement : Measurement
        The data with their harmonics, relative to the first.
    noise : ndarray of complex, shape (n,)
        Standard deviations of K' and K''; a sinusoid's fit leaves the same deviation in every
        harmonic.
    """
    relative = np.sqrt(0.5 * (noise.real**2 + noise.imag**2)) / measurement.magnitude
    # Odd before even: symmetric nonlinearities, friction and rubber among them, make odd ones only.
    return [
        *_harmonic(measurement, relative, 3, "odd"),
        *_harmonic(measurement, relative, 2, "even"),
    ]


def _harmonic(measurement: Measurement, relative: Real, order: int, word: str) -> Iterator[Finding]:
    """The test of one harmonic.

    The sum of its squares over the noise is chi-square where there is none.
    """
    harmonic = measurement.harmonic(order)
    if harmonic is None:
        return
    share = np.abs(harmonic)
    rows = np.flatnonzero(np.isfinite(share))
    if len(rows) == 0:
        return
    value = float(np.sum((share[rows] / relative[rows]) ** 2))
    chance = float(chi2_sf(value, 2 * len(rows)))
    # The median, as the largest shares of a small force are mostly noise.
    typical = float(np.median(share[rows]))
    growth = _growth(measurement, share, rows)
    words = f"{word} nonlinearity: harmonic {order} is {100 * typical:.2g} % of the first{growth}"
    yield Finding(f"harmonic {order}", typical, chance, False, words)


def _growth(measurement: Measurement, share: Real, rows: NDArray[np.int64]) -> str:
    """The power of the amplitude with which the share grows, where amplitudes differ."""
    amplitude = measurement.conditions.get("amplitude")
    if amplitude is None:
        return ""
    x, y = amplitude[rows], share[rows]
    usable = (x > 0) & (y > 0)
    x, y = np.log(x[usable]), np.log(y[usable])
    if len(x) < 3 or np.ptp(x) < np.log(VERDICT.spread):
        return ""
    design = np.column_stack([x - x.mean(), np.ones(len(x))])
    (slope, level), *_ = np.linalg.lstsq(design, y, rcond=None)
    rest = y - design @ np.array([slope, level])
    variance = np.sum(rest**2) / (len(x) - 2)
    error = float(np.sqrt(variance / np.sum(design[:, 0] ** 2)))
    named = min(MEANINGS, key=lambda power: abs(power - slope))
    meaning = ""
    # The powers are one or two apart: a slope known worse than that has no name.
    if error < 0.7 and abs(named - slope) < max(VERDICT.close_power, 2 * error):
        meaning = f", {MEANINGS[named]}"
    return f", growing as amplitude^{slope:.2g} ± {2 * error:.1g}{meaning}"


def unlike(judged: Iterable[Diagnosis]) -> str:
    """That sweeps judged one by one are not alike; nothing where their parameters are.

    Parameters
    ----------
    judged : iterable of Diagnosis
        The answers, of which those count that the model follows.
    """
    # What is missing elsewhere bends the parameters, as far as the sweep happens to show it.
    followed = [one for one in judged if one.verdict == "adequate"]
    apart: dict[str, None] = {}
    for one, other in combinations(followed, 2):
        for name, a in one.parameters.items():
            b = other.parameters.get(name)
            if b is None or a.unit != b.unit:
                continue
            # Twice the interval of their difference: of many pairs some are that far by chance.
            if abs(a.value - b.value) > hypot(a.high - a.low, b.high - b.low):
                apart[name] = None
    if not apart:
        return ""
    return (
        f"each was judged by itself, and {listed(list(apart))} of"
        f" {listed([one.data for one in followed], NAMED)} differ by more than their intervals: of"
        " one specimen under the same conditions that is a calibration, an area or gap, a"
        " temperature or an age"
    )
