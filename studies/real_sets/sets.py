"""The measured sets: where they are, which models are tried, what is known, what is asked."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from glob import glob
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import springpot
from springpot import Measurement
from springpot.errors import DataError

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"


COMPLETE = ("adequate", "small in practice", "it is little")
"""What is said where a linear material is all that there is."""
SHIFTED = ("wlf-shift", "arrhenius-shift", "free-shift", "vertical-shift")
RUBBER = ("payne", "strain-softening")
YIELDING = ("friction", "elasto-sliding", "smooth-hysteresis", "yielding", "power-law-damper")
INSTRUMENT = ("phase-error", "time-delay", "filter-mismatch", "series-spring")


@dataclass(frozen=True)
class RealSet:
    """One set and one question to it.

    Parameters
    ----------
    name : str
        Name of its row, its answer and its figure.
    data : str
        As on the command line, or a pattern of signal files below the data directory.
    models : tuple of str
        Where discovery begins, one after the other; the last is the one that is drawn.
    known : str
        What its publication or its working principle says is in it.
    question : str
        What is asked.
    rows : tuple of str, optional
        A label and how it begins in the rows that are meant, where several values of it are.
    accept : tuple of str
        Effects that the last model is also given in this order, where the literature names them.
    true : tuple of str
        Effects, or words of a headline, that an expert would name where no model is given.
    drawn : bool
        Whether there is a picture; against frequency two strain sweeps are only clouds.
    """

    name: str
    data: str
    models: tuple[str, ...]
    known: str
    question: str
    rows: tuple[str, str] | None = None
    accept: tuple[str, ...] = ()
    true: tuple[str, ...] = ()
    drawn: bool = True

    @property
    def is_signals(self) -> bool:
        """Whether the data are time signals."""
        return "*" in self.data


SETS = (
    RealSet(
        "pdms",
        "nist-srm2491",
        ("maxwell-5",),
        "thermorheologically simple melt: WLF with C1 = 6.64 (ln), C2 = 299.4 K at 25 degC and a"
        " vertical shift",
        "is the shift missed, and is it NIST's?",
        accept=("wlf-shift", "vertical-shift"),
        true=SHIFTED,
    ),
    RealSet(
        "bitumen-58",
        "fhwa-ptf-binder-dsr@lane=1,temperature=58",
        ("fractional-maxwell", "fractional-maxwell-ab"),
        "bitumen, three specimens; fractional models are the customary ones",
        "is the fractional Maxwell model adequate?",
        true=COMPLETE,
    ),
    RealSet(
        "bitumen-82",
        "fhwa-ptf-binder-dsr@lane=1,temperature=82",
        ("fractional-maxwell", "fractional-maxwell-ab"),
        "bitumen, three specimens; fractional models are the customary ones",
        "is the fractional Maxwell model adequate?",
        true=COMPLETE,
    ),
    RealSet(
        "bitumen-all",
        "fhwa-ptf-binder-dsr@lane=1",
        ("fractional-maxwell-ab", "1s2p1d"),
        "seven temperatures, shifted in practice by WLF",
        "is the temperature found, and is anything left?",
        accept=("wlf-shift",),
        true=SHIFTED,
    ),
    RealSet(
        "elastomer",
        "elastomer-epdm-70-dma-payne",
        ("springpot",),
        "Payne effect of a filled rubber",
        "is the amplitude found?",
        rows=("run", "sd_"),
        drawn=False,
        true=RUBBER,
    ),
    RealSet(
        "elastomer-10hz",
        "elastomer-epdm-70-dma-payne@run=sd_10hz",
        ("springpot",),
        "Payne effect of a filled rubber",
        "can it be named from one frequency?",
        true=RUBBER,
    ),
    RealSet(
        "polyisoprene",
        "reptate-polyisoprene-osc@molar_mass=33.6",
        ("fractional-maxwell-ab",),
        "melt with WLF constants C1 = 8.772 (log10), C2 = 79.03 K at -35 degC and a small vertical"
        " shift",
        "is the temperature found, and is it the published WLF?",
        true=SHIFTED,
    ),
    RealSet(
        "tape-cold",
        "3m-468mp-acrylic-tts@temperature=-40",
        ("fractional-kelvin", "fractional-zener"),
        "compliance or phase error of the instrument: the loss turns negative above 60 rad/s",
        "is the artefact found and named?",
        true=INSTRUMENT,
    ),
    RealSet(
        "tape-warm",
        "3m-468mp-acrylic-tts@temperature=20",
        ("fractional-kelvin", "fractional-zener"),
        "the same tape far from the instrument's limit",
        "is nothing of the kind found here?",
        true=COMPLETE,
    ),
    RealSet(
        "tape-all",
        "3m-468mp-acrylic-tts",
        ("fractional-maxwell-ab", "huet"),
        "thermorheologically simple to first order; compliance at the cold end",
        "are shift and compliance told apart?",
        accept=("wlf-shift",),
        true=SHIFTED,
    ),
    RealSet(
        "friction-damper",
        "friction-damper-brfd-lehigh/signals/dataset-2_*36lb*.csv",
        ("kelvin",),
        "Coulomb friction with backlash",
        "from time signals to friction: is it found, and how large is the force?",
        true=YIELDING,
    ),
    *(
        RealSet(
            f"mr-damper-{current}A",
            f"mr-damper-utfsm-sinusoid@current={current}",
            ("kelvin",),
            "a yield force that grows with the current, beside seal friction and shear thinning",
            "is the yield force found, and does it grow?",
            true=(*YIELDING, "shear-thinning", "power-law-slip"),
        )
        for current in ("0", "0.5", "1")
    ),
    RealSet(
        "micelles",
        "mitmaps-saos",
        ("fractional-maxwell", "maxwell-2", "maxwell"),
        "nearly one Maxwell element, with a small departure at high frequency",
        "is anything invented?",
        true=COMPLETE,
    ),
    RealSet(
        "soft-solid",
        "hermes-multi-technique@step=Frequency",
        ("fractional-kelvin",),
        "inertia of the instrument: the loss is negative at 628 rad/s",
        "is the artefact found and named?",
        true=("inertia", "specimen-inertia"),
    ),
)


@cache
def use_shared_data() -> None:
    """Let ``shared/data`` beside the checkout be SPRINGPOT_DATA, where that names no other."""
    if "SPRINGPOT_DATA" not in os.environ and SHARED.is_dir():
        os.environ["SPRINGPOT_DATA"] = str(SHARED)


def opened(one: RealSet) -> Measurement:
    """The data of a set.

    Raises
    ------
    DataError
        If the set is not on this machine.
    """
    use_shared_data()
    if not one.is_signals:
        data = springpot.read(one.data)
        return (
            data
            if one.rows is None
            else data.subset(_beginning(data, *one.rows), f"{data.name}, {one.name}")
        )
    files = sorted(path for folder in folders() for path in glob(str(folder / one.data)))
    if not files:
        raise DataError(f"no files {one.data} in SPRINGPOT_DATA")
    return replace(springpot.signals_to_measurement(files), name=one.name)


def _beginning(data: Measurement, label: str, word: str) -> NDArray[np.bool_]:
    mask: NDArray[np.bool_] = np.char.startswith(data.labels[label].astype(str), word)
    return mask


def folders() -> Iterator[Path]:
    """The data directories."""
    use_shared_data()
    yield from (
        Path(part) for part in os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep) if part
    )
