"""Makes the reports that gallery.md shows, in docs/gallery/.

Run by 'make site', as a user would run them.

They are not kept in the repository: a page that is made anew shows what today's springpot says.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent
GALLERY = HERE / "gallery"
RACE = HERE.parent / "results" / "optimiser_comparison" / "report.html"
MADE = {
    "damper.html": "discover artificial-hidden --model fractional-maxwell --auto --report",
    "fluid.html": (
        "discover nist-srm2491 --model maxwell-4 --accept wlf-shift --accept vertical-shift"
        " --report"
    ),
    "ladder.svg": "discover artificial-hidden --model fractional-maxwell --auto --figure",
    "fit.svg": (
        "identify artificial-hidden --model 'fractional-maxwell + inertia + time-delay' --figure"
    ),
    "models.svg": (
        "compare artificial-hidden --model fractional-maxwell --model 'fractional-maxwell +"
        " inertia' --figure"
    ),
    "mastercurve.svg": "mastercurve nist-srm2491 --reference 20degC --figure",
}
"""Files and the commands, as they stand on the page, that make them."""


def make(names: Sequence[str] = (), folder: Path = GALLERY) -> list[Path]:
    """Make the files of these names, by default all of them, and copy the report of the race.

    Parameters
    ----------
    names : sequence of str
        Keys of `MADE`.
    folder : Path
        Where to.
    """
    import shlex

    folder.mkdir(parents=True, exist_ok=True)
    for name in names or MADE:
        command = [sys.executable, "-m", "springpot", *shlex.split(MADE[name]), str(folder / name)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    shutil.copy(RACE, folder / "race.html")
    return sorted(folder.iterdir())


if __name__ == "__main__":
    for path in make(sys.argv[1:]):
        print(path)
