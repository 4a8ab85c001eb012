"""A plugin as a whole: everything that it offers, each against its contract.

Those of data sets, objectives and formats for solvers stand here, others in files of their own.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import numpy as np

from springpot.errors import DataError
from springpot.hooks import GROUP, SolverFormat
from springpot.identification.problem import Objective
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import DataSet
from springpot.registry import Registry, parse_model
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex, Real

from ..numerics import ROUNDING
from .effects import check_effect, check_model
from .networks import (
    CONTRACT,
    SAMPLE,
    cited,
    complaints,
    derivative,
    name_and_summary,
    sample_measurement,
)
from .others import check_optimiser, check_reader


def check_writer(
    writer: SolverFormat,
    read: Callable[[str, Real], Complex] | None = None,
    *,
    skip: Collection[str] = (),
) -> list[str]:
    """What is wrong with a writer, as plain sentences.

    Aspects: ``words``, ``text`` (the same twice, with every line of the heading), ``holds`` (weight
    and time of every term, the long-term stiffness, a dashpot and Poisson's ratio where the format
    has them), ``refuses`` (what does not fit, in one line), ``several`` (none of two materials is
    lost) and ``read-back`` (K of the card is that of the series), for which a reader is needed.

    Parameters
    ----------
    writer : Writer
        The writer.
    read : callable, optional
        From the text of a card and angular frequencies (n,) in rad/s to K (n,), of the modulus that
        was handed over: Young's, or that which the format takes. Not by the writer's own constants.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    aspects = {
        "words": lambda: name_and_summary(writer.name, writer.summary, writer.aliases),
        **writer.aspects(read),
    }
    return complaints(aspects, skip)


KINDS = ("measured", "artificial", "reconstruction")


def check_dataset(
    dataset: DataSet, *, models: Mapping[str, Model] | None = None, skip: Collection[str] = ()
) -> list[str]:
    """What is wrong with a data set, as plain sentences.

    Aspects: ``words`` (name, summary, kind, licence, citation), ``loads`` (as many points as it
    says, the same bits twice) and ``truth`` (the parameters are those of its model). A set that
    says why it is unavailable here, or that would first be downloaded, is not loaded.

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
        or len(dataset.summary) > CONTRACT.described
    ):
        yield (
            f"the summary must be one sentence of at most {CONTRACT.described} characters, not"
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


THETA = np.array([60.0, 900.0, 300.0, 0.45])


def check_objective(objective: Objective, *, skip: Collection[str] = ()) -> list[str]:
    """What is wrong with an objective, as plain sentences.

    Aspects: ``words``, ``weights`` (finite, not negative, one for each point, with given standard
    deviations and without them; one that needs them refuses with a `DataError`), ``value`` (the sum
    of squared residuals, zero for perfect data) and ``derivative`` (exact).

    Parameters
    ----------
    objective : Objective
        The objective.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    aspects = {
        "words": lambda: name_and_summary(objective.name, objective.summary),
        "weights": lambda: _weights(objective),
        "value": lambda: _value(objective),
        "derivative": lambda: _derivative(objective),
    }
    return complaints(aspects, skip)


def _data(objective: Objective) -> dict[str, Measurement]:
    """Data with standard deviations, and without unless the objective says it needs them."""
    plain = sample_measurement()
    # Different in storage and loss, so that a mix-up of the two shows.
    given: Complex = (0.01 + 0.02j) * plain.stiffness.real.astype(np.complex128)
    data = {"with standard deviations": replace(plain, sd=given)}
    try:
        objective.weights(plain)
    # It needs standard deviations and says so, as it should.
    except DataError:
        return data
    return {"without standard deviations": plain, **data}


def _weights(objective: Objective) -> Iterator[str]:
    for which, data in _data(objective).items():
        weights = np.asarray(objective.weights(data))
        if weights.shape != data.stiffness.shape or not np.iscomplexobj(weights):
            yield (
                f"{which}: weights must be complex, one for each of the {len(data)} points,"
                f" not {weights!r:.60}"
            )
        elif not np.isfinite(weights).all() or np.any(weights.real < 0) or np.any(weights.imag < 0):
            yield f"{which}: weights must be finite and not negative in K' and in K''"
        elif not np.any(weights):
            yield f"{which}: all weights are zero"
        if not np.array_equal(weights, objective.weights(data)):
            yield f"{which}: two calls give different weights"


def _value(objective: Objective) -> Iterator[str]:
    for which, data in _data(objective).items():
        weights = objective.weights(data)
        computed = SAMPLE.stiffness(THETA, data.points)
        residual = objective.residual(computed, data, weights)
        if residual.shape != (2 * len(data),):
            yield f"{which}: residuals have the shape {residual.shape}, not ({2 * len(data)},)"
        if not np.allclose(
            objective.value(computed, data, weights), np.sum(residual**2), rtol=ROUNDING
        ):
            yield f"{which}: the value is not the sum of the squared residuals"
        if not np.allclose(objective.value(data.stiffness.copy(), data, weights), 0.0, atol=1e-20):
            yield f"{which}: the value of perfect data is not zero"


def _derivative(objective: Objective) -> Iterator[str]:
    for which, data in _data(objective).items():
        weights = objective.weights(data)
        response = SAMPLE.network.respond(THETA, data.points, GRADIENT)
        exact = np.swapaxes(
            objective.derivative(response.by_theta, response.value, weights), -1, -2
        )

        def residual(theta: np.ndarray) -> np.ndarray:
            # Refused at once: the derivative is then differenced along the real axis.
            if np.iscomplexobj(theta):
                raise TypeError("residuals are real parts: no analytic functions")
            computed = SAMPLE.stiffness(theta, data.points)  # noqa: B023  used at once
            return objective.residual(computed, data, weights)  # noqa: B023  used at once

        numeric = derivative(residual, THETA)
        # Times the parameters, for these differ by orders of magnitude.
        if not np.max(np.abs(exact - numeric) * THETA) < CONTRACT.exact * np.max(
            np.abs(numeric) * THETA
        ):
            yield f"{which}: derivative is not that of the residuals"


Samples = Mapping[str, Sequence[Path | bytes]]
Skips = Mapping[str, Collection[str]]
Reads = Mapping[str, Callable[[str, Real], Complex]]

CONTRACTS: dict[str, Callable[..., list[str]]] = {
    "model": check_model,
    "effect": check_effect,
    "optimiser": check_optimiser,
    "objective": check_objective,
    "data set": check_dataset,
    "reader": check_reader,
    "writer": check_writer,
}


@dataclass(frozen=True)
class Plugin:
    """A plugin under test, whether it is installed or not.

    Parameters
    ----------
    source : module or str
        The module, or what an entry point would say: ``package.module`` or
        ``package.module:object``.
    samples : mapping of str to sequence of Path or bytes
        Sample files by the name of the reader.
    skip : mapping of str to collection of str
        Aspects to leave out, by the name of the thing.
    passive : bool
        Whether storage and loss of the models may never be negative.
    reads : mapping of str to callable
        From a card and angular frequencies to K, by the name of the writer.
    """

    source: ModuleType | str
    samples: Samples = field(default_factory=dict)
    skip: Skips = field(default_factory=dict)
    passive: bool = False
    reads: Reads = field(default_factory=dict)

    @cached_property
    def registry(self) -> Registry:
        """The plugin alone."""
        if isinstance(self.source, str):
            value = self.source
        else:
            value = self.source.__name__
        # By itself: what other plugins offer must neither hide its faults nor dispute its names.
        return Registry([EntryPoint(value, value, GROUP)])

    def offers(self) -> list[tuple[str, str]]:
        """Kind and name of everything that it offers and that there is a contract for."""
        return [(word, name) for word in CONTRACTS for name in self.registry.names(word)]

    def faults(self) -> list[str]:
        """What the host has against it."""
        faults = [fault.reason for fault in self.registry.faults]
        if not self.offers():
            faults.append(
                "it offers nothing that can be checked:"
                " write a hook such as springpot_models, marked with @hookimpl"
            )
        names = {name for _, name in self.offers()}
        # A name that is misspelt here would leave a test out in silence, or a sample unread.
        unknown = {*self.skip, *self.samples, *self.reads} - names
        return faults + [f"'{name}' is to be skipped but not offered" for name in unknown]

    def unavailable(self, word: str, name: str) -> str:
        """Why a data set cannot be loaded here, or nothing."""
        offered = self.registry.find(word, name)
        unavailable = getattr(offered, "unavailable", "")
        if unavailable:
            return str(unavailable)
        remote = getattr(offered, "remote", "")
        # A test must not reach for the network.
        if remote:
            return f"it is downloaded from {remote} when it is used"
        return ""

    def check(self, word: str, name: str) -> list[str]:
        """What is wrong with one thing that it offers."""
        more: dict[str, Any] = {}
        if word == "model":
            more = {"passive": self.passive}
        elif word == "data set":
            # A data set may name a model of its own plugin, which need not be installed.
            own = [model for model in self.registry.items("model") if isinstance(model, Model)]
            more = {"models": {model.base: model for model in own}}
        elif word == "reader":
            more = {"samples": self.samples.get(name, ())}
        elif word == "writer":
            more = {"read": self.reads.get(name)}
        return CONTRACTS[word](self.registry.find(word, name), skip=self.skip.get(name, ()), **more)


def check_plugin(
    plugin: ModuleType | str,
    *,
    samples: Samples | None = None,
    skip: Skips | None = None,
    passive: bool = False,
    reads: Reads | None = None,
) -> list[str]:
    """What is wrong with a plugin and everything that it offers, as plain sentences.

    Parameters
    ----------
    plugin, samples, skip, passive, reads
        As in `Plugin`.

    Returns
    -------
    list of str
        Each sentence preceded by the thing that it is about; empty if nothing is wrong.
    """
    whole = Plugin(plugin, samples or {}, skip or {}, passive, reads or {})
    sentences = whole.faults()
    for word, name in whole.offers():
        sentences += [f"{word} '{name}': {says}" for says in whole.check(word, name)]
    return sentences


class PluginContract:
    """Base of a test class for pytest: one test for everything that a plugin offers.

    Attributes
    ----------
    plugin : module or str
        What is tested.
    samples, skip, passive, reads
        As in `Plugin`.
    """

    plugin: ClassVar[ModuleType | str] = ""
    samples: ClassVar[Samples] = {}
    skip: ClassVar[Skips] = {}
    passive: ClassVar[bool] = False
    reads: ClassVar[Reads] = {}

    @classmethod
    def _whole(cls) -> Plugin:
        # Kept in the class itself: a subclass tests another plugin.
        if "_loaded" not in cls.__dict__:
            cls._loaded = Plugin(cls.plugin, cls.samples, cls.skip, cls.passive, cls.reads)
        return cls._loaded

    _loaded: ClassVar[Plugin]

    def pytest_generate_tests(self, metafunc: Any) -> None:
        """Make one test for each thing that is offered."""
        if "offered" in metafunc.fixturenames:
            # One test for each thing, not one for all: what fails is named, and the rest is still
            # tested.
            offers = self._whole().offers()
            metafunc.parametrize("offered", offers, ids=[f"{word} {name}" for word, name in offers])

    def test_the_host_finds_no_fault(self) -> None:
        """The plugin loads, its hooks are known, and what they give is what they should give."""
        faults = self._whole().faults()
        assert not faults, "\n".join(faults)

    def test_something_can_be_checked(self) -> None:
        """A plugin of which everything is unavailable here has not been tested."""
        whole = self._whole()
        assert any(not whole.unavailable(*offer) for offer in whole.offers()), (
            "everything is unavailable here"
        )

    def test_keeps_its_contract(self, offered: tuple[str, str]) -> None:
        """Whatever is offered does what its kind promises."""
        # Here, so that `check_plugin` works where pytest is not installed.
        import pytest

        whole = self._whole()
        sentences = whole.check(*offered)
        assert not sentences, "\n".join(sentences)
        # Skipped only now: what can be checked without its data has been.
        if reason := whole.unavailable(*offered):
            pytest.skip(reason)
