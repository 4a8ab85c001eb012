"""What became of each cell and optimiser since the baseline was made, in numbers and in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from .baseline import EVALUATIONS, SEPARATOR, Baseline, Sample, Successes, Verdict, verdicts


@dataclass(frozen=True)
class Change:
    """What became of one cell, or of one optimiser over all its problems.

    Parameters
    ----------
    who : str
        Optimiser and problem.
    costs : tuple of (Sample, Sample, Verdict), or None
        Before, after, and what is thought of it; none of several problems, whose costs have no
        common scale.
    counts : tuple of (Successes, Successes, Verdict)
        The same of the trials that reached the target.
    """

    who: str
    costs: tuple[Sample, Sample, Verdict] | None
    counts: tuple[Successes, Successes, Verdict]

    @property
    def worse(self) -> bool:
        """Whether costs rose or successes became fewer."""
        return self.counts[2].worse or (self.costs is not None and self.costs[2].worse)

    @property
    def better(self) -> bool:
        """The reverse."""
        return self.counts[2].better or (self.costs is not None and self.costs[2].better)

    def sentence(self, word: str) -> str:
        """What changed for the ``worse`` or the ``better``."""
        told = []
        if self.costs is not None and getattr(self.costs[2], word):
            told.append(_costs_in_words(*self.costs))
        if getattr(self.counts[2], word):
            told.append(self._fewer())
        return f"{self.who} got {word}: {'; '.join(told)}"

    def _fewer(self) -> str:
        before, after, verdict = self.counts
        return f"target reached in {before} before, in {after} after (p = {verdict.p:.1g})"

    def doubtful(self) -> str:
        """A drop of successes that may be chance; empty if there is none."""
        before, after, verdict = self.counts
        if verdict.worse or after.rate >= before.rate:
            return ""
        return f"{self.who}: {self._fewer()}: fewer, but not for certain"


def changes_since(
    before: Baseline, after: dict[str, Sample], level: float, factor: float
) -> list[Change]:
    """Cells by name, then optimisers over all their problems, of which no single one may tell."""
    keys = sorted(after)
    pairs = [(before.samples[key].array(), after[key].array()) for key in keys]
    counts = [(before.samples[key].successes, after[key].successes) for key in keys]
    several = {name: cells for name, cells in by_optimiser(after).items() if len(cells) > 1}
    for cells in several.values():
        counts.append((together(before.samples, cells), together(after, cells)))
    # Judged together: the level is the chance that any of them is reported, not each.
    found = verdicts(pairs, level, factor, counts)
    of_counts = [
        (*count, verdict) for count, verdict in zip(counts, found[len(pairs) :], strict=True)
    ]
    changed = []
    for key, cost, count in zip(keys, found, of_counts, strict=False):
        changed.append(Change(who(key), (before.samples[key], after[key], cost), count))
    for (name, cells), count in zip(several.items(), of_counts[len(keys) :], strict=True):
        # Where a problem of it tells already, all of them together say nothing new.
        if not any(
            change.counts[2].worse
            for key, change in zip(keys, changed, strict=False)
            if key in cells
        ):
            changed.append(Change(f"{name} over {len(cells)} problems", None, count))
    return changed


def by_optimiser(samples: Iterable[str]) -> dict[str, list[str]]:
    """Keys of each optimiser's cells."""
    found: dict[str, list[str]] = {}
    for key in sorted(samples):
        found.setdefault(key.rpartition(SEPARATOR)[2], []).append(key)
    return found


def together(samples: Mapping[str, Sample], keys: Sequence[str]) -> Successes:
    """Successes of several cells."""
    return Successes(
        sum(samples[key].reached for key in keys), sum(len(samples[key].values) for key in keys)
    )


def _costs_in_words(before: Sample, after: Sample, verdict: Verdict) -> str:
    what = "final error"
    if before.measure == EVALUATIONS:
        what = "evaluations to target"
    evidence = "the intervals are apart"
    if verdict.tested:
        evidence = f"p = {verdict.p:.1g}"
    return f"{what} {_in_words(before)} before, {_in_words(after)} after ({evidence})"


def _in_words(sample: Sample) -> str:
    """The median, and how many trials it is of; an infinite one was missed."""
    median = float(np.median(sample.array()))
    middle = f"{median:.4g}"
    if median == inf:
        middle = "missed"
    trials = f"{len(sample.values)} trials"
    missed = sum(value == inf for value in sample.values)
    if missed:
        trials += f", {missed} missed"
    return f"{middle} (median of {trials})"


def who(key: str) -> str:
    """A cell as a sentence begins."""
    dataset, model, objective, optimiser = key.split(SEPARATOR)
    return f"{optimiser} on {dataset} (model {model}, objective {objective})"
