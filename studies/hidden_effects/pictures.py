"""Pictures of the hidden-effect test (matplotlib)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from hidden_effects.figures import Figure, Row, accepted, first, named, settled, verdict


def draw(
    rows: list[Row], strata: list[tuple[str, float, float, list[Figure]]], folder: Path
) -> None:
    """Draw power, reliability, confusion and error after acceptance."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(15, 4.5), layout="constrained")
    _power(axes[0], strata)
    _reliability(axes[1], [r for r in rows if r["kind"] in {"nothing", "one"}])
    _settled(axes[2], rows)
    figure.savefig(folder / "figures.png", dpi=110)
    figure, axis = plt.subplots(figsize=(11, 9), layout="constrained")
    _confusion(axis, rows)
    figure.savefig(folder / "confusion.png", dpi=110)
    plt.close("all")


def _power(axis: Any, strata: list[tuple[str, float, float, list[Figure]]]) -> None:
    # Signals are too few for a curve: their bars would only hide the others.
    for design, mark in {"sweep": "-o", "field": "--s"}.items():
        here = [s for s in strata if s[0] == design]
        middle = [np.sqrt(low * min(high, 3.0 * low)) for _, low, high, _ in here]
        for i, colour in enumerate(("tab:grey", "tab:blue", "tab:orange")):
            cells = [cells[i] for *_, cells in here]
            if not cells:
                continue
            values = np.array([c.value for c in cells])
            errors = [values - [c.low for c in cells], np.array([c.high for c in cells]) - values]
            label = f"{cells[0].name}, {design}"
            axis.errorbar(
                middle, values, np.abs(errors), fmt=mark, color=colour, label=label, capsize=2, ms=4
            )
    axis.set(
        xscale="log",
        xlabel="noise-free chi-square left by the base model",
        ylabel="share",
        ylim=(0, 1.02),
    )
    # Long enough for its dashes to be seen.
    axis.legend(fontsize=7, handlelength=4)
    axis.set_title("One hidden effect")


def _reliability(axis: Any, rows: list[Row]) -> None:
    use = [r for r in rows if verdict(r) == "effect-missing"]
    p = np.array([float(first(r).get("probability") or 0.0) for r in use])
    hit = np.array([float(named(r)) for r in use])
    place = np.minimum((p * 10).astype(int), 9)
    for b in np.unique(place):
        chosen = place == b
        axis.plot(
            p[chosen].mean(),
            hit[chosen].mean(),
            "o",
            color="tab:blue",
            ms=3 + np.sqrt(chosen.sum()),
        )
    axis.plot([0, 1], [0, 1], "k:", lw=1)
    axis.set(
        xlabel="probability of the first name",
        ylabel="share that is right",
        xlim=(0, 1.02),
        ylim=(0, 1.05),
    )
    axis.set_title("Calibration (area: cases)")


def _settled(axis: Any, rows: list[Row]) -> None:
    use = [r for r in rows if r["kind"] in {"one", "two"} and r["chi2"] >= 30]
    use = [r for r in use if accepted(r)] or [r for r in use if verdict(r) == "effect-missing"]
    ratios = np.array([settled(r) for r in use])
    axis.hist(
        np.clip(ratios[np.isfinite(ratios)], 0.5, 2.0),
        bins=np.linspace(0.5, 2.0, 61),
        color="tab:blue",
    )
    axis.axvspan(0.95, 1.05, color="tab:green", alpha=0.2)
    axis.set(xlabel="error after acceptance / noise floor", ylabel="cases")
    axis.set_title("Where the ladder ends")


def _confusion(axis: Any, rows: list[Row]) -> None:
    from hidden_effects.report import confusion

    truths, answers, counts = confusion(
        [r for r in rows if r["chi2"] >= 60 or r["kind"] == "nothing"], "label"
    )
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axis.imshow(shares, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    axis.set_xticks(range(len(answers)), answers, rotation=90, fontsize=7)
    axis.set_yticks(
        range(len(truths)),
        [f"{t} ({n})" for t, n in zip(truths, counts.sum(axis=1), strict=True)],
        fontsize=7,
    )
    for i, j in zip(*np.nonzero(counts), strict=True):
        axis.text(
            j,
            i,
            counts[i, j],
            ha="center",
            va="center",
            fontsize=6,
            color="k" if shares[i, j] < 0.6 else "w",
        )
    axis.set(xlabel="answer", ylabel="truth", title="First label, chi2 >= 60 or nothing missing")
