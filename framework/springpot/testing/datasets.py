"""The contract of a data set."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping

import numpy as np

from springpot.errors import DataError
from springpot.measurement.catalogue import DataSet
from springpot.measurement.units import AMPLITUDE_UNITS, MODULUS_UNITS
from springpot.registry import parse_model
from springpot.rheology.model import Model

from .aspects import cited, complaints

KINDS = ("measured", "artificial", "reconstruction")
LONGEST = 240
"""Characters of a summary."""


def check_dataset(
    dataset: DataSet, *, models: Mapping[str, Model] | None = None, skip: Collection[str] = ()
) -> list[str]:
    """What is wrong with a data set, as plain sentences.

    Aspects: ``words`` (name, summary, kind, licence, citation), ``loads`` (as many points as it
    says, in known units, the same bits twice) and ``truth`` (the parameters are those of its
    model). A set that says why it is unavailable here, or that would first be downloaded, is not
    loaded.

    Parameters
    ----------
    dataset : DataSet
        The data set.
    models : mapping of str to Model, optional
        Models by name beside the installed ones.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    aspects = {
        "words": lambda: _words(dataset),
        "loads": lambda: _loads(dataset),
        "truth": lambda: _truth(dataset, models or {}),
    }
    return complaints(aspects, skip)


def _words(dataset: DataSet) -> Iterator[str]:
    # Signs with a meaning in FILE#PART?COLUMN=UNIT@CONDITION would part the name.
    if not re.fullmatch(r"[A-Za-z0-9][\w.+-]*", dataset.name):
        yield f"the name '{dataset.name}' cannot be typed: use letters, digits, hyphens and points"
    if (
        len(dataset.summary.split()) < 3
        or "\n" in dataset.summary
        or len(dataset.summary) > LONGEST
    ):
        yield (
            f"the summary must be one sentence of at most {LONGEST} characters, not"
            f" {dataset.summary!r:.60}"
        )
    if dataset.kind not in KINDS:
        yield f"the kind is '{dataset.kind}', not one of {', '.join(KINDS)}"
    # What cannot be had here need not be described in full.
    if dataset.unavailable:
        return
    if not dataset.licence.strip():
        yield "there is no licence: say under which terms the numbers may be used"
    if dataset.kind != "artificial":
        yield from cited(dataset.citation)


def _loads(dataset: DataSet) -> Iterator[str]:
    if dataset.unavailable:
        try:
            dataset.open()
        except DataError as error:
            # Whoever opens it is to read the reason, not an error of a missing file.
            if dataset.unavailable not in str(error):
                yield f"it is unavailable, but opening it says: {error}"
        return
    # A test must not reach for the network.
    if dataset.remote:
        return
    # Twice, as numbers that are drawn must come again.
    first, second = dataset.open(), dataset.open()
    if dataset.size and len(first) != dataset.size:
        yield f"it loads {len(first)} points where it says {dataset.size}"
    if first.name != dataset.name:
        yield f"the measurement is called '{first.name}', not '{dataset.name}'"
    for unit, known in (
        (first.units.stiffness, MODULUS_UNITS),
        (first.units.amplitude, AMPLITUDE_UNITS),
    ):
        if unit not in known:
            yield f"the unit [{unit}] is unknown"
    for name in ("omega", "stiffness", "sd"):
        one, other = getattr(first, name), getattr(second, name)
        if (one is None) != (other is None) or (one is not None and not np.array_equal(one, other)):
            yield f"loaded twice, {name} differs"


def _truth(dataset: DataSet, models: Mapping[str, Model]) -> Iterator[str]:
    if dataset.truth and not dataset.model:
        yield "it gives true parameters but not the model that they belong to"
    if not dataset.model:
        return
    model = models.get(dataset.model) or parse_model(dataset.model)
    if dataset.truth and set(dataset.truth) != set(model.names):
        yield (
            f"its true parameters are {', '.join(dataset.truth)}; {model.name} has"
            f" {', '.join(model.names)}"
        )
