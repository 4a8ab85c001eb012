"""What ``springpot demo`` shows: a fluid, a race and a damper with a secret."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import Chapter, Race, hookimpl

FLUID = "nist-srm2491"
FLUID_MODEL = "fractional-maxwell-dashpot"
HIDDEN = "artificial-hidden"
ENTRANTS = ("pso-paper", "cma-es", "differential-evolution", "nlopt-mlsl", "native")


@hookimpl
def springpot_demo() -> Iterable[Chapter]:
    """Identify, diagnose, race, discover."""
    return (
        Chapter(
            "Identify: a silicone fluid of NIST at 20 degC",
            (
                *("identify", f"{FLUID}@temperature=20", "--model", FLUID_MODEL),
                *("--figure", "{out}/identify.png"),
            ),
        ),
        Chapter(
            "Diagnose: the same model for all six temperatures fails; what is missing?",
            ("diagnose", FLUID, "--model", FLUID_MODEL),
        ),
        Chapter(
            "Accept what was found missing: the temperature shift",
            (
                *("discover", FLUID, "--model", FLUID_MODEL, "--accept", "wlf-shift"),
                *("--figure", "{out}/temperature.png"),
            ),
        ),
        Chapter(
            "Race: optimisers on the paper's artificial data, the same budget for all",
            race=Race(
                "race",
                ("artificial-fractional-maxwell", "artificial-fractional-zener-symmetric1"),
                ENTRANTS,
                objective="paper",
                repetitions=5,
                budget=3000,
            ),
        ),
        Chapter(
            "Compare: an artificial damper with something hidden,"
            " and the model that its maker gives",
            ("compare", HIDDEN, "--model", "fractional-maxwell", "--figure", "{out}/compare.png"),
        ),
        Chapter(
            "Discover: add what is missing and watch the error fall",
            (
                *("discover", HIDDEN, "--model", "fractional-maxwell", "--auto"),
                *("--figure", "{out}/ladder.png", "--report", "{out}/report.html"),
            ),
        ),
        Chapter(
            "Now you: the same damper in your browser, where effects are pointed at",
            ("workbench", HIDDEN, "--model", "fractional-maxwell"),
            left_to_user=True,
        ),
    )
