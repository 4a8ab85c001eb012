"""Whether the tests of a room notice a changed line of it."""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

import numpy as np
from mutation import PACKAGE, ROOT, Copy, Mutant, drawn
from soak import Row

COUNT = 100
LEAST = 0.85
"""Share that the room's own tests are to notice of the changes that change anything."""
LEFT_ALONE = "texts, annotations, guards, tolerances and numbers that have a name"
"""What is never changed; `mutation` says why."""
HARMLESS = {
    (
        "benchmark/trial.py",
        "case: RaceCase, plan: Plan | None = None, repetition: int = 0",
        "1",
    ): "without a plan no repetition is asked for",
    (
        "benchmark/fork_server.py",
        "signal.set_wakeup_fd(self._ring, warn_on_full_buffer=False)",
        "True",
    ): "only a warning is at stake",
    (
        "identification/fitted_quantities.py",
        "x = self.band[1] - 0.1 * DECADE * np.arange(10.0 * FARTHEST)",
        "0.2",
    ): "how finely a place is looked for",
    (
        "diagnosis/discovery.py",
        "if not search.grown or search.alarm > VERDICT.accepted:",
        "search.alarm >= VERDICT.accepted",
    ): "a chance that is a level to the last bit",
    (
        "identification/intervals.py",
        "first, width, iterations = first + width, width + (first > 0), 2 * iterations",
        "1",
    ): "how many starts are tried at once",
    (
        "identification/uncertainty.py",
        "if self.at_bound[i] < 0:",
        "1",
    ): "on a bound it is never nothing",
    (
        "identification/robust.py",
        "base, spare = begun.objective, max(begun.dof, 1)",
        "2",
    ): "of one number to spare none is far off",
    (
        "invention/inventing.py",
        "scaled = 2.0 * (log_omega - log_omega.min()) / (float(np.ptp(log_omega)) or 1.0) - 1.0",
        "(float(np.ptp(log_omega)) and 1.0)",
    ): "polynomials of any scale of their variable are the same together",
    (
        "invention/inventing.py",
        'by_profile = verdict != "none" and each.probability > VERDICT.profiled',
        "each.probability >= VERDICT.profiled",
    ): "a chance that is a level to the last bit",
    (
        "invention/result.py",
        "return distance(frame, law.grown.refit, other.grown.refit) < INVENTION.same",
        "distance(frame, law.grown.refit, other.grown.refit) <= INVENTION.same",
    ): "a distance that is a level to the last bit",
    (
        "invention/inventing.py",
        "return bool(spread < INVENTION.repeated * np.std(column))",
        "spread <= INVENTION.repeated * np.std(column)",
    ): "only of one value are both nothing, and such a column is none that was varied",
    (
        "measurement/imposed.py",
        "up = value * np.sign(value[np.argmax(np.abs(value))])",
        "(value / np.sign(value[np.argmax(np.abs(value))]))",
    ): "a sign is its own inverse",
    (
        "misfit/material.py",
        "for each in range(int(number.max()) + 1):",
        "2",
    ): "a level more, which has no points",
    (
        "identification/material.py",
        "basis, _ = material.basis(self.points.log_omega, False)",
        "True",
    ): "slopes that nobody asks for, beside the same values",
    (
        "timetests/disturbances.py",
        "alone = at**2 + np.append(np.cumsum((after**2)[::-1])[::-1][1:], 0.0)",
        "1.0",
    ): "the last samples, among which no jump is looked for",
    (
        "processes.py",
        "part = os.read(fd, 1 << 16)",
        "32",
    ): "how much is read at once",
    (
        "rheology/written.py",
        "values = [value * by for value, by in zip(usual, (*share, 1.0, 1.0), strict=False)]",
        "2.0",
    ): "at which sizes of a fifth parameter a law is tried",
    (
        "solvers/prony.py",
        "if best is None or series.error < best.error:",
        "series.error <= best.error",
    ): "errors that are equal to the last bit",
    (
        "structure/damper.py",
        "now, here, fast = np.zeros(1), np.array([way]), np.array([speed])",
        "2",
    ): "a moment that is asked twice",
    (
        "structure/damper.py",
        "self._pointwise(0.0, 1.0) - self._pointwise(0.0, -1.0)",
        "1.0",
    ): "where the slope is taken beside which a jump is negligible",
    (
        "testreport/record.py",
        "fits = (freedom <= 0) | (chi2_sf(left, np.maximum(freedom, 1.0)) > SIGNALS.ruled_out)",
        "chi2_sf(left, np.maximum(freedom, 1.0)) >= SIGNALS.ruled_out",
    ): "a chance that is a level to the last bit",
    (
        "identification/free_factors.py",
        "known = values > LOST * values[0]",
        "values >= LOST * values[0]",
    ): "a share that is a level to the last bit",
    (
        "invention/search.py",
        'kind = (effect.plane, of_frequency, text.startswith("-"), "i*" in text)',
        "'i*' not in text",
    ): "whether two are alike is the same by what both have not",
    (
        "report/figures.py",
        "_mark(fit.name, scene.fit_colour(i, 0), linewidth=4.0)",
        "1",
    ): "where a colour stands for a model it is that of all sweeps",
    (
        "rheology/elements.py",
        "tall = column.ndim == 2 and row.ndim == 1 and len(column) > len(row)",
        "len(column) >= len(row)",
    ): "how a square table lies in memory",
    (
        "testreport/record.py",
        "len(channel.within(each.time - half, each.time + half)[0]) > 2 * WINDOW.smooth + 2",
        "1",
    ): "times and values are as many",
    (
        "superposition/laws.py",
        "block = np.ix_(used + offset, used + offset)",
        "(used - offset)",
    ): "the second half, counted from its end",
}
"""Changes, by file, line and what stands there instead, that change nothing anybody could see.

Nobody noticed them, each was read, and the table tells of it with the reason.
"""


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """One promise: enough of the changes are noticed; those that were not are named."""
    count = max(1, round(scale * COUNT))
    unnoticed = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        for number, mutant in enumerate(drawn(rng, count), 1):
            by = copy.notices(mutant)
            # A hundred take an hour.
            print(f"{number} of {count}: {told(mutant)}: {by or 'NOT NOTICED'}", flush=True)
            if not by:
                unnoticed.append(mutant)
    yield counted(count, unnoticed, copy.failing)


def told(mutant: Mutant) -> str:
    """A change in words."""
    change = mutant.change
    place = mutant.path.relative_to(PACKAGE)
    return f"{place}:{change.line} `{change.before}` to `{change.after}`"


def reason(mutant: Mutant) -> str:
    """Why a change changes nothing that anybody could see; nothing where nobody has found it so."""
    change, lines = mutant.change, (ROOT / mutant.path).read_text(encoding="utf-8").splitlines()
    place = mutant.path.relative_to(PACKAGE).as_posix()
    return HARMLESS.get((place, lines[change.line - 1].strip(), change.after), "")


def counted(count: int, unnoticed: Sequence[Mutant], failing: Collection[str]) -> Row:
    """The row of so many changes."""
    noticed = count - len(unnoticed)
    real = [told(mutant) for mutant in unnoticed if not reason(mutant)]
    none = [f"{told(mutant)} ({reason(mutant)})" for mutant in unnoticed if reason(mutant)]
    says = (
        f"{noticed} of {count}, of all but {LEFT_ALONE}; not noticed: {'; '.join(real) or 'none'}"
    )
    if none:
        says += "; not noticed either, as whoever read them saw nothing that they change, and not"
        says += f" counted: {'; '.join(none)}"
    if failing:
        says += f"; left out, as they fail without any change: {', '.join(sorted(failing))}"
    kept = noticed >= LEAST * (count - len(none))
    what = f"{100 * LEAST:.0f} % of single-line changes are noticed by the tests of their room"
    return Row(what, 1, int(kept), says.replace("|", "\\|"))
