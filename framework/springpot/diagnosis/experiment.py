"""The next experiment: which feasible measurement would tell the leading explanations apart.

For every feasible action the two explanations are evaluated where the new points would lie, and one is allowed to
follow the other with all its parameters. Actions are ranked with linear slopes; those that would be named are fitted
in earnest, since a rival far from its old parameters can follow much better than its slopes tell.
"""

from __future__ import annotations

from .actions import Action, actions
from .refit import Refit
from .result import NextExperiment
from .separation import Clash
from .words import plain

TRIED = 3
"""Actions that are fitted in earnest at most."""
TELLING = 2.0
"""Separation below which a measurement is not worth its effort: the odds hardly change."""
SETTLED = 5.0
"""Separation in standard deviations that settles the matter."""
Pair = tuple[float, float]
"""Of the first and of the second explanation."""


def next_experiment(first: Refit, second: Refit, names: tuple[str, str], chances: Pair) -> NextExperiment:
    """The action that should best separate two explanations for its effort.

    Parameters
    ----------
    first, second : Refit
        The two fitted explanations.
    names : tuple of str
        The effects that set them apart.
    chances : tuple of float
        Their probabilities: who holds decides what a measurement can show, as a larger model follows a smaller one.
    """
    shares = (chances[0] / sum(chances), chances[1] / sum(chances))

    def clashes(action: Action) -> tuple[Clash, Clash]:
        return Clash(first, second, action), Clash(second, first, action)

    def worth(sigmas: Pair, action: Action) -> float:
        return _expected(shares, (_enough(sigmas[0]), _enough(sigmas[1]))) / action.effort

    linear = {action: _both(clashes(action), "linear") for action in actions(first.fit.measurement)}
    tried = sorted(linear, key=lambda action: -worth(linear[action], action))[:TRIED]
    fitted = {action: _both(clashes(action), "fitted") for action in tried}
    telling = [action for action in tried if max(fitted[action]) >= TELLING]
    if not telling:
        best = max(tried, key=lambda action: max(fitted[action]))
        expected = separation(shares, fitted[best])
        return NextExperiment(_no_use(best, names, expected), names, expected)
    best = max(telling, key=lambda action: worth(fitted[action], action))
    expected = separation(shares, fitted[best])
    return NextExperiment(f"{best.says}: {promise(names, shares, fitted[best])}", names, expected, best.action)


def _no_use(action: Action, names: tuple[str, str], sigma: float) -> str:
    """Where one explanation follows the other everywhere, nothing is to be bought by measuring."""
    size = plain(sigma, 2) if sigma > 0.1 else "less than 0.1"
    return (
        f"no feasible measurement tells {names[0]} from {names[1]}: even the best ({action.says}) would "
        f"separate them by {size} sigma"
    )


def _both(clashes: tuple[Clash, Clash], kind: str) -> Pair:
    first, second = (clash.linear if kind == "linear" else clash.fitted() for clash in clashes)
    return first, second


def _expected(shares: Pair, sigmas: Pair) -> float:
    return shares[0] * sigmas[0] + shares[1] * sigmas[1]


def _enough(sigma: float) -> float:
    """More than enough separation is worth no more."""
    return min(sigma, 3.0 * SETTLED)


def separation(shares: Pair, sigmas: Pair) -> float:
    """The standard deviations that are promised: at least so many, or where it depends on who is right, the mean."""
    return min(sigmas) if _either_way(sigmas) else _expected(shares, sigmas)


def _either_way(sigmas: Pair) -> bool:
    """Whether the measurement tells the two apart whoever is right."""
    return min(sigmas) >= SETTLED or 2.0 * min(sigmas) >= max(sigmas)


def promise(names: tuple[str, str], shares: Pair, sigmas: Pair) -> str:
    """What the measurement will show if the first or the second of two explanations holds."""
    less, more = sorted(range(2), key=lambda i: sigmas[i])
    told = plain(separation(shares, sigmas), 2)
    if _either_way(sigmas):
        return f"it separates {names[0]} from {names[1]} by {told} sigma"
    verb = "rules out" if sigmas[more] >= SETTLED else "speaks against"
    return (
        f"if {names[more]} is right it {verb} {names[less]} by {plain(sigmas[more], 2)} sigma; "
        f"if not, {names[more]} stays possible; {told} sigma are to be expected"
    )
