"""A plugin as a whole: everything that it offers, each against its contract."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

from springpot.hooks import GROUP
from springpot.registry import Registry
from springpot.rheology.model import Model

from .datasets import check_dataset
from .effects import check_effect
from .models import check_model
from .objectives import check_objective
from .optimisers import check_optimiser
from .readers import check_reader

Samples = Mapping[str, Sequence[Path | bytes]]
Skips = Mapping[str, Collection[str]]

CONTRACTS: dict[str, Callable[..., list[str]]] = {
    "model": check_model,
    "effect": check_effect,
    "optimiser": check_optimiser,
    "objective": check_objective,
    "data set": check_dataset,
    "reader": check_reader,
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
    """

    source: ModuleType | str
    samples: Samples = field(default_factory=dict)
    skip: Skips = field(default_factory=dict)
    passive: bool = False

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
        unknown = {*self.skip, *self.samples} - names
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
        return CONTRACTS[word](self.registry.find(word, name), skip=self.skip.get(name, ()), **more)


def check_plugin(
    plugin: ModuleType | str,
    *,
    samples: Samples | None = None,
    skip: Skips | None = None,
    passive: bool = False,
) -> list[str]:
    """What is wrong with a plugin and everything that it offers, as plain sentences.

    Parameters
    ----------
    plugin, samples, skip, passive
        As in `Plugin`.

    Returns
    -------
    list of str
        Each sentence preceded by the thing that it is about; empty if nothing is wrong.
    """
    whole = Plugin(plugin, samples or {}, skip or {}, passive)
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
    samples, skip, passive
        As in `Plugin`.
    """

    plugin: ClassVar[ModuleType | str] = ""
    samples: ClassVar[Samples] = {}
    skip: ClassVar[Skips] = {}
    passive: ClassVar[bool] = False

    @classmethod
    def _whole(cls) -> Plugin:
        # Kept in the class itself: a subclass tests another plugin.
        if "_loaded" not in cls.__dict__:
            cls._loaded = Plugin(cls.plugin, cls.samples, cls.skip, cls.passive)
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
