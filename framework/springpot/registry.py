"""Finds plugins and keeps what they offer; a faulty one is named and set aside, the rest work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pluggy

import springpot.hooks as hooks  # not from the package, whose table of names leads back here
from springpot.errors import (
    LONGEST_REASON,
    DataError,
    ModelError,
    OptionError,
    OutputError,
    PluginError,
    SpringpotError,
    use_owners,
)
from springpot.files import write_text
from springpot.measurement.covered import OtherTest
from springpot.measurement.from_signals import OneTest, measurement_of_tests
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import DataSet, Suite, Test, open_in_time as in_time_by
from springpot.measurement.reader import OpenQuestion, Part
from springpot.measurement.steady import Signals
from springpot.measurement.timetest import TimeTest
from springpot.processes import kept_surroundings
from springpot.rheology.effect import Effect, use_finder
from springpot.rheology.model import Family, Model
from springpot.rheology.typed import expression_parts, is_law, law, model_of
from springpot.writing import near_names, suggested

from .hooks import KINDS, Kind, Owner, Shelf
from .measurement import opening

if TYPE_CHECKING:
    from springpot.identification.runs import Optimiser

T = TypeVar("T")

PREFIX = f"{hooks.GROUP}_"


@dataclass(frozen=True)
class Fault:
    """A plugin, or one of its hooks, that could not be used.

    Parameters
    ----------
    plugin, distribution : str
        Entry point and the installed distribution it comes from.
    reason : str
        What went wrong, in one line.
    """

    plugin: str
    distribution: str
    reason: str

    def __str__(self) -> str:
        return f"plugin '{self.plugin}' of {self.distribution} is unavailable: {self.reason}"


class Registry:
    """Plugins and what they offer.

    Parameters
    ----------
    points : iterable of EntryPoint
        Entry points of the group ``springpot``. Those of springpot itself come first, then one
        distribution after the other by name, so that nothing depends on the order in which they
        were installed.
    """

    def __init__(self, points: Iterable[EntryPoint]) -> None:
        self._faults: list[Fault] = []
        self._filled: dict[str, Shelf[Any]] = {}
        self.manager = pluggy.PluginManager(hooks.GROUP)
        self.manager.add_hookspecs(hooks)
        self._owners: dict[str, Owner] = {}
        # Once for each: to tell its name, all that is known of a distribution is read.
        named = [(_distribution(point), point) for point in points]
        for distribution, point in sorted(named, key=lambda pair: _order(pair[0])):
            owner = self._owner(point.name, distribution)
            with self._guarded(owner), self._undone(owner, point.module):
                self.manager.register(point.load(), name=owner.plugin)
        self._report_slips()

    def _owner(self, name: str, distribution: str) -> Owner:
        """The plugin of an entry point; two distributions may well choose the same name for it."""
        if name in self._owners:
            name = f"{name} ({distribution})"
        return self._owners.setdefault(name, Owner(name, distribution))

    @contextmanager
    def _guarded(self, owner: Owner) -> Iterator[None]:
        try:
            yield
        # The user's wish to stop is no fault of a plugin.
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            # Not only exceptions: a plugin may call sys.exit, and faults of extensions in Rust
            # derive from the base.
            reason = f"{type(error).__name__}: {error}"
            if isinstance(error, SpringpotError):
                reason = str(error)
            self._fault(owner, reason)

    @contextmanager
    def _undone(self, owner: Owner, module: str) -> Iterator[None]:
        """Undo what a plugin does to the program when it is loaded, and list it."""
        package = module.partition(".")[0]

        def tell(what: str) -> None:
            self._fault(owner, f"when it is loaded {what}")

        with kept_surroundings(tell, lambda of: of.partition(".")[0] == package):
            yield

    def _fault(self, owner: Owner, reason: str) -> None:
        # One line of it: a plugin's message may be of any length, and every list of faults shows
        # it.
        line = " ".join(reason.split())
        if len(line) > LONGEST_REASON:
            line = f"{line[: LONGEST_REASON - 3]}..."
        self._faults.append(Fault(owner.plugin, owner.distribution, line))

    def _report_slips(self) -> None:
        # pluggy passes over a function whose name it does not know: its author would wait for it in
        # vain.
        known = [name for name in dir(hooks) if name.startswith(PREFIX)]
        for name, plugin in self.manager.list_name_plugin():
            # A plugin may be any object, whose attributes may raise when they are only looked at.
            with self._guarded(self._owners[name]):
                for attribute in [each for each in dir(plugin) if each.startswith(PREFIX)]:
                    slip = _slip(attribute, getattr(plugin, attribute), known)
                    if slip:
                        self._fault(self._owners[name], slip)

    def _fill(self, kind: Kind[T]) -> Shelf[T]:
        shelf: Shelf[T] = Shelf(kind)
        # One by one, not all by pluggy in one call: that would end at the first that raises.
        for impl in getattr(self.manager.hook, kind.hook).get_hookimpls():
            owner = self._owners[impl.plugin_name]
            with self._guarded(owner), self._undone(owner, impl.function.__module__):
                # One faulty item does not take the others of its plugin along.
                for item in _sequence(impl.function(), kind):
                    with self._guarded(owner):
                        shelf.put(_accepted(item, kind), owner)
        # Once all is there: an alias may be the name of what a later plugin offers.
        for owner, says in shelf.disputes():
            self._fault(owner, says)
        return shelf

    def shelf(self, word: str) -> Shelf[Any]:
        """All things of one kind, asked of the plugins once, and only if somebody wants one."""
        if word not in self._filled:
            self._filled[word] = self._fill(KINDS[word])
        return self._filled[word]

    @property
    def shelves(self) -> dict[str, Shelf[Any]]:
        """All things of all kinds."""
        return {word: self.shelf(word) for word in KINDS}

    @property
    def faults(self) -> list[Fault]:
        """What could not be used, of all kinds."""
        for word in KINDS:
            self.shelf(word)
        return self._faults

    def names(self, word: str) -> list[str]:
        """Names of all things of one kind whose name is not in dispute."""
        return list(self.shelf(word).undisputed())

    def items(self, word: str) -> Iterator[Any]:
        """All things of one kind whose name is not in dispute."""
        return iter(self.shelf(word).undisputed().values())

    def find(self, word: str, name: str) -> Any:
        """The thing of that kind and name.

        Raises
        ------
        ModelError
            If there is none, with the nearest names.
        PluginError
            If two plugins claim the name.
        """
        item = self.shelf(word).find(name)
        # Libraries of many optimisers are imported only when one of their names is asked for.
        if item is None and word == "optimiser":
            item = self._member(name)
        if item is None:
            hint = _proposal(name, self.shelf(word).known(), f"{word.replace(' ', '')}s")
            # It may be what a plugin that could not be used would have offered.
            broken = "".join(f"; {fault}" for fault in self._faults[:1])
            raise ModelError(f"unknown {word} '{name}': {hint}{broken}")
        return item

    def _member(self, name: str) -> type[Optimiser] | None:
        """The optimiser of a library that is imported only now.

        None if the name begins with no library's.

        Raises
        ------
        ModelError
            If the library has no such optimiser, or is not installed.
        """
        for family in self.items("optimiser family"):
            if not name.startswith(family.prefix):
                continue
            members: Mapping[str, type[Optimiser]] = family.members()
            if name in members:
                return members[name]
            hint = _proposal(name, members, f"optimisers {family.name}")
            raise ModelError(f"unknown optimiser '{name}': {hint}")
        return None

    def problem(self, name: str) -> DataSet | None:
        """The problem of a suite, ``SUITE/NAME``; None where that is no such name."""
        of, stroke, _ = name.partition("/")
        suite: Suite | None = self.shelf("suite").find(of) if stroke else None
        if suite is None:
            return None
        return suite.problem(name)

    def owner_of(self, word: str, name: str) -> str:
        """The plugin that offers a thing of that kind and name; empty for springpot's own."""
        return _foreign(self.shelf(word).owner(name))

    def owner_of_module(self, module: str) -> str:
        """The plugin whose package a module is in; empty for springpot's own."""
        package = module.partition(".")[0]
        for name, plugin in self.manager.list_name_plugin():
            # A plugin may be a module or any object.
            own = getattr(plugin, "__name__", None) or type(plugin).__module__
            if str(own).partition(".")[0] == package:
                return _foreign(self._owners[name])
        return ""

    def distributions(self) -> list[str]:
        """The installed distributions whose plugins are used, springpot's own first."""
        # A dictionary keeps the order, which a set would lose.
        return list(dict.fromkeys(owner.distribution for owner in self._owners.values()))

    def model(self, name: str) -> Model:
        """The model without effects called `name`, a member of a family included."""
        registered = self.shelf("model").find(name)
        # A name of its own goes before that of a member of a family.
        if registered is None:
            registered = self._family_member(name) or self.find("model", name)
        if isinstance(registered, Family):
            raise ModelError(
                f"model '{name}' needs a number for N, such as {registered.name[:-1]}3"
            )
        model: Model = registered
        return model

    def _family_member(self, name: str) -> Model | None:
        for item in self.items("model"):
            if isinstance(item, Family) and (member := item.member(name)) is not None:
                return member
        return None

    def effect(self, name: str) -> Effect:
        """The effect called `name`, a law as text, or ``NAME:TEST``, which one test alone has.

        Of effects with a factor for each level, ``NAME:COLUMN`` is that of another column.
        """
        if is_law(name):
            return law(name)
        kind, colon, where = name.partition(":")
        effect: Effect = self.find("effect", kind.strip())
        if not colon:
            return effect
        if not where.strip():
            what = "a test"
            if effect.by_levels:
                what = "a column"
            raise ModelError(f"'{name}': name {what} after the colon, such as {effect.name}:water")
        if effect.by_levels:
            return effect.of_column(where.strip())
        return effect.of_one(where.strip())


def _foreign(owner: Owner | None) -> str:
    if owner is None or owner.distribution == hooks.GROUP:
        return ""
    return str(owner)


def _proposal(name: str, known: Iterable[str], listed: str) -> str:
    """The nearest known names, or else the command that lists them all."""
    if near := near_names(name, known):
        return f"did you mean {', '.join(near)}?"
    return f"see '{suggested(f'list {listed}')}'"


def _distribution(point: EntryPoint) -> str:
    if point.dist is None:
        return "an unknown distribution"
    return point.dist.name


def _order(distribution: str) -> tuple[bool, str]:
    # False comes before True.
    return distribution != hooks.GROUP, distribution


def _slip(attribute: str, value: object, known: list[str]) -> str:
    """What is wrong with a function that looks like a hook, or nothing."""
    marked = hasattr(value, f"{PREFIX}impl")
    if marked and attribute not in known:
        # The prefix that all hooks share would make anything look near.
        words = [name.removeprefix(PREFIX) for name in known]
        near = get_close_matches(attribute.removeprefix(PREFIX), words, n=1)
        hint = f"known are {', '.join(known)}"
        if near:
            hint = f"did you mean {PREFIX}{near[0]}?"
        return f"there is no hook {attribute}: {hint}"
    # Hooks themselves, which a plugin may have imported to look at, are no slips.
    if (
        attribute in known
        and callable(value)
        and not marked
        and not hasattr(value, f"{PREFIX}spec")
    ):
        return f"{attribute} is not marked with @hookimpl and does nothing"
    return ""


def _sequence(offered: object, kind: Kind[Any]) -> Iterable[object]:
    # These can be iterated over too, but what comes out is letters or names, and each would be a
    # fault of its own.
    if isinstance(offered, str | bytes | Mapping) or not isinstance(offered, Iterable):
        raise PluginError(f"{kind.hook} must return a list of {kind.word}s, not {offered!r:.80}")
    return offered


def _accepted(item: Any, kind: Kind[T]) -> T:
    if not kind.accepts(item):
        hint = ""
        # All other things are offered as objects, so that an object is the likely slip.
        if kind.word == "optimiser":
            hint = " (offer the class itself, with minimise written)"
        raise PluginError(f"{kind.hook} offers {item!r:.80}, which is no {kind.word}{hint}")
    # A value is told, held and started by its name: of two alike one would be lost.
    names = [each.name for each in getattr(getattr(item, "element", item), "parameters", ())]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise PluginError(
            f"{kind.word} '{item.name}' has two parameters called {twice[0]}: rename one of them"
        )
    accepted: T = item
    return accepted


@cache
def plugins() -> Registry:
    """The plugins installed here, loaded once.

    Examples
    --------
    >>> import springpot
    >>> "inertia" in springpot.plugins().names("effect")
    True
    """
    registry = Registry(entry_points(group=hooks.GROUP))
    # Models below this room name effects too: they are given the way to look them up, as they
    # cannot import it.
    use_finder(registry.effect)
    use_owners(registry.owner_of, registry.owner_of_module)
    return registry


def parse_model(expression: str) -> Model:
    """The model that an expression such as ``fractional-maxwell + inertia`` names.

    A formula stands for a model, and in brackets for an effect: see `law`.

    Raises
    ------
    ModelError
        If a part of it is unknown or empty, or the same effect stands twice where two are no more
        than one.

    Examples
    --------
    >>> import springpot
    >>> springpot.parse_model("fractional-maxwell + inertia").names
    ('k', 'c', 'alpha', 'inertia.m')
    """
    registry = plugins()
    known = registry.shelf("effect").find
    parts = expression_parts(expression, lambda name: known(name.partition(":")[0]) is not None)
    if parts.by_formula:
        model = model_of(parts.model)
    else:
        model = _named(parts.model)
    for number, name in enumerate(parts.effects, 1):
        model = model.taking(effect_of(name, number))
    return model


def effect_of(text: str, number: int = 1) -> Effect:
    """The effect of a name, or of a law as text; without a name of its own by its number.

    Raises
    ------
    ModelError
        If there is none of that name, or the law is none.

    Examples
    --------
    >>> from springpot.registry import effect_of
    >>> effect_of("inertia").name, effect_of("parallel: -m*omega^2", 2).name
    ('inertia', 'law-2')
    """
    if is_law(text):
        return law(text, f"law-{number}")
    return plugins().effect(text)


def of_each(column: str) -> Effect:
    """The effect that gives each value of a column a factor of its own.

    Raises
    ------
    OptionError
        If none of the installed ones does.
    """
    for effect in plugins().items("effect"):
        if effect.by_levels and effect.plane != "shift":
            each: Effect = effect.of_column(column)
            return each
    raise OptionError(
        f"--split {column}: no installed effect has a factor of its own at each value"
    )


def _named(name: str) -> Model:
    registry = plugins()
    try:
        return registry.model(name)
    except ModelError:
        # That an effect is no known model would be true, and help nobody.
        if registry.shelf("effect").find(name) is None:
            raise
        raise ModelError(f"'{name}' is an effect: write MODEL + {name}") from None


def open_measurement(spec: str | Path) -> Measurement:
    """The measurement that a user names.

    A file, or a data set, either with conditions (``NAME@temperature=20``).

    Raises
    ------
    DataError
        If there is no such thing, it cannot be read, or no row has the conditions.

    Examples
    --------
    >>> import springpot
    >>> springpot.open_measurement("artificial-hidden@frequency=1..10")
    <Measurement artificial-hidden@frequency=1..10: 17 points, 1.13 to 9.93 Hz>
    """
    registry = plugins()
    problem = registry.problem(str(spec))
    if problem is not None:
        return problem.open()
    return opening.open_measurement(spec, registry.items("data set"), registry.items("reader"))


def open_in_time(spec: str | Path) -> tuple[TimeTest | OtherTest, ...]:
    r"""The tests in time in the file that a user names.

    None for sweeps, data sets and whatever else.

    Raises
    ------
    DataError
        If the file holds tests in time that cannot be used.

    Examples
    --------
    >>> import springpot
    >>> rows = [f"{0.1 * 1.5**i},{400.0 * 1.5 ** (-0.3 * i)}" for i in range(18)]
    >>> with open("pad.csv", "w") as file:
    ...     _ = file.write("\n".join(["time [s],relaxation [kPa]", *rows]))
    >>> springpot.open_in_time("pad.csv")
    (<TimeTest pad: relaxation, 18 samples, 0.1 to 98.5 s>,)
    """
    problem = plugins().problem(str(spec))
    if problem is not None:
        tests = problem.tests()
        in_time = tuple(test for test in tests if not isinstance(test, Measurement))
        # Of a sweep among them only who opens all tests can make something.
        return in_time if len(in_time) == len(tests) else ()
    return in_time_by(spec, plugins().items("time reader"))


def open_tests(spec: str | Path) -> tuple[Test, ...]:
    """All tests of whatever a user names: those in time in a file, or a sweep.

    Raises
    ------
    DataError
        If there is no such thing or it cannot be read.
    """
    problem = plugins().problem(str(spec))
    if problem is not None:
        return problem.tests()
    try:
        return open_in_time(spec) or (open_measurement(spec),)
    except OpenQuestion:
        raise
    except DataError as error:
        # The question of a sweep's reader can be answered; what stops the other one would hide it.
        try:
            return (open_measurement(spec),)
        except OpenQuestion:
            raise
        except DataError:
            raise error from None


def parts_of(spec: str | Path) -> tuple[Part, ...]:
    """The steps, sweeps or sheets of the file that a user names, chosen by ``FILE#2``.

    None for anything else.

    Raises
    ------
    DataError
        If the file cannot be read.
    """
    return opening.parts_of(spec, plugins().items("reader"))


def signals_to_measurement(
    paths: Sequence[str | Path],
    *,
    omega: float | None = None,
    n_harmonics: int = 5,
    window: tuple[float, float] | None = None,
    name: str | None = None,
) -> Measurement:
    """Files of displacement and force against time, one test each, as one measurement.

    Parameters
    ----------
    paths : sequence of str or Path
        Files of displacement and force against time, one test in each; ``FILE?force=kN`` says what
        is left open.
    omega, n_harmonics, window, name
        As in `measurement_from_signals`.

    Raises
    ------
    DataError
        If a file holds no time signals or cannot be evaluated.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> time = np.linspace(0.0, 2.0, 1001)
    >>> phase = 2.0 * np.pi * 2.0 * time  # 2 Hz; the force leads by half a radian
    >>> columns = np.column_stack([time, np.sin(phase), 3.0 * np.sin(phase + 0.5)])
    >>> header = "time [s],displacement [mm],force [N]"
    >>> np.savetxt("test.csv", columns, delimiter=",", header=header, comments="")
    >>> data = springpot.signals_to_measurement(["test.csv"])
    >>> np.abs(data.stiffness).round(3), np.angle(data.stiffness).round(3)
    (array([3.]), array([0.5]))
    """
    evaluated = (
        evaluated_signals(path, omega=omega, n_harmonics=n_harmonics, window=window)
        for path in paths
    )
    return measurement_of_tests(evaluated, name)


def open_signals(spec: str | Path) -> Signals:
    """The displacement and force against time in the file that a user names.

    Raises
    ------
    DataError
        If the file holds no time signals.
    """
    return opening.open_signals(spec, plugins().items("reader"))


def evaluated_signals(
    path: str | Path,
    *,
    omega: float | None = None,
    n_harmonics: int = 5,
    window: tuple[float, float] | None = None,
) -> OneTest:
    """What one file of displacement and force against time comes to.

    A row for `measurement_of_tests`.

    Raises
    ------
    DataError
        If the file holds no time signals or cannot be evaluated.
    """
    readers = plugins().items("reader")
    return opening.evaluated_in(path, readers, omega=omega, n_harmonics=n_harmonics, window=window)


def write_measurement(measurement: Measurement, path: str | Path) -> Path:
    """Write a measurement to a file that opens again as the same bits.

    Raises
    ------
    OutputError
        If it cannot be written there.

    Examples
    --------
    >>> import springpot
    >>> data = springpot.read("artificial-hidden@frequency=1..10")
    >>> path = springpot.write_measurement(data, "part.csv")
    >>> bool((springpot.read(path).stiffness == data.stiffness).all())
    True
    """
    for reader in plugins().items("reader"):
        # Most readers only read; springpot's own come first, and their table opens again as the
        # same bits.
        if reader.text is not None:
            return write_text(path, reader.text(measurement))
    raise OutputError(f"cannot write {path}: no plugin offers a format to write measurements in")


LIBRARIES = ("springpot", "numpy", "scipy", "nlopt", "cma", "pluggy")
"""Distributions on which numbers depend."""


def versions(further: Iterable[str] = ()) -> dict[str, str]:
    """Versions by distribution: the libraries, those of all plugins, and further ones.

    What is absent is left out.

    Parameters
    ----------
    further : iterable of str
        Names of distributions.
    """
    by_name = {}
    for name in dict.fromkeys((*LIBRARIES, *plugins().distributions(), *further)):
        try:
            by_name[name] = version(name)
        # An extra that is not installed had no part in the result.
        except PackageNotFoundError:
            continue
    return by_name
