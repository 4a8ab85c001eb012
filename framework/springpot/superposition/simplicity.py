"""Whether factors of frequency and of stiffness bring all sweeps onto one curve, or where not.

A material is thermorheologically simple if all its relaxation times change by one factor. Each
sweep by itself is followed by some material; what one material with free factors leaves beyond that
is the failure of superposition.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf, f_sum_sf, normal_sf
from springpot.identification.free_factors import FactorRows
from springpot.identification.levels_alone import Alone, parts_of
from springpot.identification.problem import weighted
from springpot.plain_data import Plain
from springpot.rheology.points import Real
from springpot.thresholds import SUPERPOSITION, VERDICT

from ..numerics import DECADE, ROUNDING, SMALLEST, Tangent, level_means, rms

Verdict = Literal["simple", "nearly-simple", "not-simple", "not-judged"]


LEFT = 1e-8
"""Share of a direction's power left by rounding where spectrum and factors can do all of it."""


@dataclass(frozen=True)
class Failure(Plain):
    """One place where superposition fails.

    Attributes
    ----------
    kind : str
        ``level``, ``no-material``, ``part``, ``storage-and-loss`` or ``branch``.
    place : float
        The level, or the relaxation time of the middle of the branch in s.
    size : float
        Error over that of the level alone; error of the best material; factor by which a part is
        missed; shift of the loss relative to the storage in ln omega; relative change of the
        branch's ln a.
    chance : float
        That noise looks like this.
    share : float
        Of the misfit that superposition leaves beyond noise, in chi-square, how much goes if this
        is mended; nan for ``no-material`` and ``part``.
    says : str
        One plain sentence.
    """

    kind: Literal["level", "no-material", "part", "storage-and-loss", "branch"]
    place: float
    size: float
    chance: float
    share: float
    says: str


@dataclass(frozen=True, eq=False)
class Simplicity:
    """The verdict on superposition.

    Attributes
    ----------
    verdict : str
        ``simple`` where nothing is left but noise, in storage and in loss, ``nearly-simple`` where
        the error is within 1.5 times that of each level by itself or superposition adds no more
        than 1 %, ``not-simple``, or ``not-judged`` where no level has points enough.
    error, alone : float
        Relative error of the one material, and of a material for each level.
    added : float
        What the one material adds to the error, levels that no material follows aside.
    chance : float
        That noise alone makes the difference.
    level_error, level_alone : ndarray, shape (m,)
        The same for each level.
    failures : tuple of Failure
        Where it fails, the gravest first.
    """

    verdict: Verdict
    error: float
    alone: float
    added: float
    chance: float
    level_error: Real
    level_alone: Real
    failures: tuple[Failure, ...]

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "verdict": self.verdict,
            "error": self.error,
            "alone": self.alone,
            "added": self.added,
            "chance": self.chance,
            "failures": [failure.to_dict() for failure in self.failures],
        }


def simplicity(rows: FactorRows, alone: Alone) -> Simplicity:
    """Test superposition.

    Parameters
    ----------
    rows : FactorRows
        The fitted material with its factors.
    alone : Alone
        Each level by itself, at the same weights.
    """
    error = _level_errors(rows)
    judged = alone.judged
    overall = rms(_relative(rows))
    if not np.any(judged):
        nothing = float("nan")
        return Simplicity("not-judged", overall, nothing, nothing, nothing, error, alone.error, ())
    chance = _chance(rows, alone)
    places = [
        *_levels(rows, alone, error),
        *_storage_and_loss(rows, alone),
        *_branches(rows, alone),
    ]
    # What explains most comes first: it is what to look at.
    places.sort(key=lambda place: -place.share)
    strange = _no_material(rows, alone)
    # A level that no material follows is no failure of superposition, and must not count as one.
    usual = judged & ~np.isin(rows.elements[0].shown, [each.place for each in strange])
    if not np.any(usual):
        usual = judged
    shared, own = _mean(rows, error, usual), _mean(rows, alone.error, usual)
    added = float(np.sqrt(max(shared**2 - own**2, 0.0)))
    verdict: Verdict = "not-simple"
    missed = _missed_parts(rows, alone)
    if chance >= VERDICT.structure_alarm and not missed:
        verdict = "simple"
    elif shared <= VERDICT.agrees * own or added <= SUPERPOSITION.added:
        verdict = "nearly-simple"
    failures = [*strange, *missed]
    # Where superposition holds, what is found among so many places is chance.
    if verdict != "simple":
        failures += [place for place in places if place.share > SUPERPOSITION.worth_a_place]
    return Simplicity(
        verdict,
        overall,
        _mean(rows, alone.error, judged),
        added,
        chance,
        error,
        alone.error,
        tuple(failures),
    )


def _variance(alone: Alone, rows: FactorRows) -> Real:
    """Variance (m,) of a weighted residual at each level.

    That of its own material, else of the common one.
    """
    common = level_means(rows.level_of_row, rows.scale**2)
    own = alone.cost / np.maximum(alone.dof, 1.0)
    return np.maximum(np.where(alone.judged, own, common), ROUNDING**2)


def _excess(alone: Alone, rows: FactorRows) -> Real:
    """Chi-square (m,) that the common material leaves at each level beyond that level's own."""
    left = np.bincount(rows.level_of_row, rows.residual**2) / _variance(alone, rows)
    return np.where(alone.judged, left - alone.dof, 0.0)


def _mean(rows: FactorRows, error: Real, which: NDArray[np.bool_]) -> float:
    """Root mean square of errors (m,) over the points of some levels."""
    counts = np.bincount(rows.number)[which]
    return float(np.sqrt(np.sum(error[which] ** 2 * counts) / counts.sum()))


def _relative(rows: FactorRows) -> Real:
    """Relative error (n,) of each point."""
    data = rows.fit.measurement
    return np.asarray(
        np.abs(rows.fit.model.stiffness(rows.fit.theta, data.points) / data.stiffness - 1.0)
    )


def _level_errors(rows: FactorRows) -> Real:
    return np.asarray(np.sqrt(level_means(rows.number, _relative(rows) ** 2)))


def _chance(rows: FactorRows, alone: Alone) -> float:
    """That one material for all levels leaves so much more than one for each, by Fisher's tests.

    Each level is measured in units of its own scatter, so that one noisy level does not hide the
    others.
    """
    counts, judged = np.bincount(rows.number), alone.judged
    nu = alone.dof[judged]
    left = rows.fit.dof
    saved = left * counts[judged] / counts.sum() - nu
    # Nothing is saved by one material for all: there is nothing to be tested. And four degrees of
    # freedom at a level tell no variance of its scatter.
    known = (saved > 0.0) & (nu > 4.0)
    if not np.any(known):
        return 1.0
    extra = float(np.sum(_excess(alone, rows)[judged][known]))
    return f_sum_sf(max(extra, 0.0), saved[known], nu[known])


def _no_material(rows: FactorRows, alone: Alone) -> list[Failure]:
    """Levels at which no material at all comes as near as elsewhere."""
    judged = alone.judged
    usual = float(np.median(alone.error[judged]))
    values, failures = rows.elements[0].shown, []
    for level in np.flatnonzero(alone.strange).tolist():
        ratio = (alone.error[level] / usual) ** 2
        by_one = float(f_sf(ratio, alone.dof[level], np.median(alone.dof[judged])))
        chance = by_one * int(judged.sum())
        if chance < VERDICT.structure_alarm:
            off, at = alone.error[level], rows.named(level)
            says = (
                f"at {at} no linear material comes nearer than {_percent(off)}, elsewhere"
                f" {_percent(usual)}: this is the instrument, the amplitude or the specimen, not"
                " superposition"
            )
            failures.append(Failure("no-material", values[level], off, chance, float("nan"), says))
    return sorted(failures, key=lambda one: -one.size)


def _missed_parts(rows: FactorRows, alone: Alone) -> list[Failure]:
    """Levels at which the line misses storage or loss by as much as it is, and not by its scatter.

    The misfit counts relative to |K|, of which a part may be a hundredth and less.
    """
    data = rows.fit.measurement
    line = rows.fit.model.stiffness(rows.fit.theta, data.points)
    values, failures = rows.elements[0].shown, []
    looked = 2 * int(alone.judged.sum())
    for level in np.flatnonzero(alone.judged).tolist():
        here = rows.number == level
        drawn = line[here][np.argsort(data.omega[here], kind="stable")]
        parts = zip(parts_of(data.subset(here)), (drawn.real, drawn.imag), strict=True)
        for word, (part, curve) in zip(rows.material.columns[1:], parts, strict=False):
            off = (part.values - curve) / np.maximum(np.abs(part.values), ROUNDING**2)
            typical = float(np.median(np.abs(off)))
            ratio = float(np.mean(off**2)) / max(part.scatter**2, ROUNDING**2)
            chance = looked * float(f_sf(ratio, len(off), part.dof))
            if typical <= SUPERPOSITION.missed or chance >= VERDICT.structure_alarm:
                continue
            says = (
                f"at {rows.named(level)} the line misses the {word} by {typical:.2g} times its"
                f" size, which is {_percent(typical * part.share)} of |K|: less than |K| scatters,"
                " and more than its own points do"
            )
            failures.append(Failure("part", values[level], typical, chance, float("nan"), says))
    return sorted(failures, key=lambda one: -one.size)


def _levels(rows: FactorRows, alone: Alone, error: Real) -> list[Failure]:
    """Levels that a material of their own follows and the common one does not."""
    excess, judged = _excess(alone, rows), alone.judged
    whole = _total(excess)
    values, failures = rows.elements[0].shown, []
    for level in np.flatnonzero(judged & (error > VERDICT.agrees * alone.error)).tolist():
        count = float(rows.numbers[level])
        ratio = (excess[level] + alone.dof[level]) / count
        # All levels are looked at, and any one of them may look like this by chance.
        chance = float(f_sf(ratio, count, alone.dof[level])) * int(judged.sum())
        if chance < VERDICT.structure_alarm:
            off, own = _percent(error[level]), _percent(alone.error[level])
            share = float(excess[level]) / whole
            says = (
                f"at {rows.named(level)} the curve is {off} off,"
                f" a material of its own {own}{_of_all(share)}"
            )
            size = float(error[level] / alone.error[level])
            failures.append(Failure("level", values[level], size, chance, share, says))
    return failures


def _total(excess: Real) -> float:
    return max(float(np.sum(np.maximum(excess, 0.0))), 1.0)


def _direction(size: float) -> str:
    if size > 0:
        return "more"
    return "less"


def _of_all(share: float) -> str:
    return f" ({100.0 * min(share, 1.0):.0f} % of what is left)"


def _storage_and_loss(rows: FactorRows, alone: Alone) -> list[Failure]:
    """Levels at which the loss would have to be shifted otherwise than the storage."""
    data = rows.fit.measurement
    # After a step there is one function, not two.
    if not np.any(rows.weights.imag):
        return []
    slope = rows.fit.model.slope(rows.fit.theta, data.points)
    # Half forward and half back: one runs ahead by all of it, and the common factor is left alone.
    apart = 0.5 * (1j * slope.imag - slope.real)
    count = int(rows.number.max()) + 1
    columns = np.array([np.where(rows.number == i, apart, 0.0) for i in range(count)])
    size, chance, share = _one_step(rows, alone, columns)
    values, failures = rows.elements[0].shown, []
    for i in np.flatnonzero(chance < VERDICT.structure_alarm).tolist():
        shifted = float(size[i])
        says = (
            f"at {rows.named(i)} the loss asks for {_percent(abs(float(np.expm1(shifted))))} "
            f"{_direction(shifted)} shift than the storage{_of_all(share[i])}"
        )
        failures.append(
            Failure("storage-and-loss", values[i], shifted, float(chance[i]), float(share[i]), says)
        )
    return failures


def _branches(rows: FactorRows, alone: Alone) -> list[Failure]:
    """Decades of relaxation times whose factors depend on the level more, or less, than others."""
    material = rows.material
    data, (factor, x) = rows.fit.measurement, rows.reduced
    log_rates, weights = np.log(material.rates), rows.fit.theta[2 : 2 + len(material.rates)]
    basis, by_x = (each[2:] for each in material.basis(x, True))
    # As its level's shift: a branch with its own activation energy shifts more further off.
    by_shift = weights[:, None] * by_x * factor * (x - data.points.log_omega)
    # Of each line in |K|: what adds nothing to the data can be shifted as one likes.
    share = np.abs(weights[:, None] * basis * factor) / data.magnitude
    band = np.floor(log_rates / DECADE).astype(np.int64)
    columns, places = [], []
    for each in np.unique(band).tolist():
        lines = band == each
        # A branch at the edge of what was measured stands for all that lies beyond.
        if share[lines].sum(axis=0).max() > SUPERPOSITION.branch_seen and _inside(each, x):
            columns.append(by_shift[lines].sum(axis=0))
            places.append(float(np.exp(-(each + 0.5) * DECADE)))
    # A branch shifts more or less than the others: one alone has none to differ from.
    if len(columns) < 2:
        return []
    size, chance, share = _one_step(rows, alone, np.array(columns))
    failures = []
    for i in np.flatnonzero(chance < VERDICT.structure_alarm).tolist():
        # The branch is a decade wide, and the place its middle.
        low, high = places[i] / 10.0**0.5, places[i] * 10.0**0.5
        shifted = float(size[i])
        by = "otherwise than"
        # A step that takes more than all of the shift, or doubles it, is too long to be a size.
        if abs(shifted) < 1.0:
            by = f"{_percent(abs(shifted))} {_direction(shifted)} than"
        says = (
            f"the branch of relaxation times {low:.1g} to {high:.1g} s shifts {by} the others"
            f"{_of_all(share[i])}"
        )
        failures.append(
            Failure("branch", places[i], shifted, float(chance[i]), float(share[i]), says)
        )
    return failures


def _inside(band: int, x: Real) -> bool:
    return bool((band + 1) * DECADE > x.min() and band * DECADE < x.max())


def _one_step(
    rows: FactorRows, alone: Alone, columns: NDArray[np.complex128]
) -> tuple[Real, Real, Real]:
    """Size (c,), chance and share of the excess of one least-squares step in each direction.

    All that spectrum and factors can do is taken out; each row is weighted by the scatter of its
    level about a material of its own. The chance counts all directions that are tried.
    """
    excess = _excess(alone, rows)
    scale = np.sqrt(_variance(alone, rows))[rows.level_of_row, None]
    # What spectrum and factors can do in its place is no failure of superposition.
    spectrum = rows.by_theta[:, : len(rows.fit.model.material.parameters)]
    asked = weighted(columns, rows.weights).T / scale
    slopes = Tangent.of(np.column_stack([spectrum, rows.factors]) / scale).left(asked)
    square = np.sum(slopes**2, axis=0)
    whole = np.sum(asked**2, axis=0)
    seen = square > LEFT * np.maximum(whole, SMALLEST)
    square = np.where(seen, square, 1.0)
    residual = rows.residual / scale[:, 0]
    size = np.where(seen, slopes.T @ residual / square, 0.0)
    score = np.abs(size) * np.sqrt(square)
    chance = np.minimum(2.0 * normal_sf(score) * len(score), 1.0)
    return size, np.where(seen, chance, 1.0), score**2 / _total(excess)


def _percent(fraction: float) -> str:
    return f"{100.0 * fraction:.2g} %"
