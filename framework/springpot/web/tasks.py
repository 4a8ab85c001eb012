"""What a worker process can be asked to do: functions of plain arguments that give plain data.

The answer to a state is exactly what ``springpot discover DATA --accept ...`` gives, with what is
drawn of it.
"""

from __future__ import annotations

import base64
import re
import shlex
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from springpot.api import compare, discover, identify, invent, mastercurve
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Fitted, silent, unseen
from springpot.errors import DataError, SpringpotError, blamed, described
from springpot.files import bytes_of
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import sweep_of
from springpot.measurement.reader import OpenQuestion, Part, Question
from springpot.measurement.units import FILE_UNITS, MODULUS_UNITS
from springpot.misfit.residuals_of_tests import units_of
from springpot.registry import open_measurement, parse_model, plugins
from springpot.report.figures import in_words
from springpot.report.interactive.answers import drawn
from springpot.report.interactive.scene import rounded
from springpot.report.plugin_cards import EXAMPLE_MEMBER, effect as effect_card, model as model_card
from springpot.rheology.drawing import network_svg
from springpot.rheology.model import Family, Model
from springpot.writing import suggested

from . import leaving
from .folders import report_of, studies, study, watched
from .leaving import curves_in_time, understood
from .sessions import (
    Opened,
    Specimen,
    State,
    data_of,
    digest_of,
    is_session,
    joined,
    kept,
    measured_in,
    opened,
    safe_name,
    session_of,
    tests_in,
    text_of,
)
from .trying import (
    Told,
    bound,
    drawing,
    first_look,
    hand_of,
    invented,
    leveled,
    looked_at,
    ranked,
    scene_of,
    telling,
    theta_of,
    tried,
    with_law,
)

SCHEMA = "springpot.workbench/1"


def ladder_of(
    state: State,
    measurement: Opened,
    told: Told = silent,
    begun: Ladder | None = None,
    fitted: Fitted = unseen,
) -> Ladder:
    """The ladder of a state; the same bits for the same state and data.

    `begun` is that of the state before its last effect, where it is known: it is not climbed again.
    `fitted` is given each effect that was fitted by itself.

    Raises
    ------
    SpringpotError
        If a name is unknown, or if model and data do not fit each other.
    """
    used = tests_in(kept(measurement, state.excluded))
    # A list, though it may be empty: without one the evidence would accept effects by itself.
    accepted, model = list(state.accepted), state.model or None
    ladder = discover(
        used,
        model,
        accept=accepted,
        seed=state.seed,
        progress=told,
        begun=begun,
        fitted=fitted,
        **state.known,
    )
    assert isinstance(ladder, Ladder)
    return ladder


def answer(state: State, ladder: Ladder, measurement: Opened) -> dict[str, Any]:
    """Schema ``springpot.workbench/1``: the discovery, and K of the model and of every candidate.

    Parameters
    ----------
    state : State
        What is asked.
    ladder : Ladder
        Its ladder, see `ladder_of`.
    measurement : Measurement
        The data, all rows.

    Returns
    -------
    dict
        ``schema``, ``state``, its ``key``, and all that `springpot.report.interactive.drawn` gives.
    """
    shown = drawn(ladder, scene_of(state, measurement))
    return {"schema": SCHEMA, "state": state.to_dict(), "key": state.key, **shown}


LADDERS = 8
"""Ladders that a worker remembers, for exports of what is on the page; each holds some MB."""
_SCHEMA = re.compile(rb'\s*{\s*"schema"\s*:\s*"(springpot\.[\w./-]{1,40})"')
"""The beginning of a file that springpot wrote, and of no data."""

_ladders: OrderedDict[str, Ladder] = OrderedDict()


@lru_cache(maxsize=4)
def _opened(text: str) -> Opened:
    return data_of(text)


def _measured(text: str) -> Measurement:
    data = _opened(text)
    if isinstance(data, Specimen):
        raise DataError("that is for sweeps at frequencies: these are tests in time")
    return data


def _ladder(state: State, text: str, told: Told, fitted: Fitted = unseen) -> Ladder:
    # What one leaves with is asked after the answer: its ladder need not be climbed twice.
    if state.key not in _ladders:
        before = replace(state, accepted=state.accepted[:-1])
        begun = _ladders.get(before.key) if state.accepted else None
        _ladders[state.key] = ladder_of(state, _opened(text), told, begun, fitted)
        while len(_ladders) > LADDERS:
            _ladders.popitem(last=False)
    # The one asked for last goes last: what somebody works with stays, however early it was
    # climbed.
    _ladders.move_to_end(state.key)
    return _ladders[state.key]


def library(told: Told) -> dict[str, Any]:
    """All models, effects and data sets that are installed."""
    # Once at the start: drawings, equations and summaries are in the page before anything is
    # computed.
    installed = plugins()
    return {
        "models": [_model(item) for item in installed.items("model")],
        # The page is of sweeps: what a test in time did is in none of them.
        "effects": [_effect(item) for item in installed.items("effect") if not item.of_test],
        "datasets": [
            {
                "name": item.name,
                "summary": item.summary,
                "kind": item.kind,
                "unavailable": item.unavailable,
            }
            for item in installed.items("data set")
            # Nothing that the page asks for may leave the machine.
            if not item.remote
        ],
        "faults": [str(fault) for fault in installed.faults],
    }


def _model(item: Model | Family) -> dict[str, Any]:
    # Of a family one member shows how all of them are built.
    if isinstance(item, Family):
        shown = item.build(EXAMPLE_MEMBER)
    else:
        shown = item
    whole = model_card(item)
    card = {key: whole[key] for key in ("name", "aliases", "summary", "citation", "needs")}
    return {**card, "parameters": list(shown.names), "svg": network_svg(shown.network)}


def _effect(item: Any) -> dict[str, Any]:
    card = effect_card(item)
    return {
        key: card[key]
        for key in ("name", "summary", "equation", "plane", "layer", "needs", "citation")
    }


def understand(
    told: Told, name: str, content: str, choice: str = "", onto: str = "", onto_name: str = ""
) -> dict[str, Any]:
    """What a dropped file holds; a question where the reader must be told more.

    A session with its data.

    `content` is base64; `onto` is the text of data that the file joins.
    """
    # Bytes cross to a worker as text: the pipe between them carries lines of JSON.
    raw = base64.b64decode(content)
    if is_session(raw):
        session = session_of(raw)
        measurement = data_of(session["data"].pop("text"))
        return {**_understood(measurement, session["data"]["source"]), "session": session}
    if named := _SCHEMA.match(raw):
        raise DataError(
            f"{name} is an answer of springpot ({named[1].decode()}): open the data that it is of,"
            " or a session of the workbench"
        )
    told(f"reading {len(raw)} bytes")
    try:
        measurement, parts = measured_in(name, raw, choice)
        _ask_unit(measurement)
    except OpenQuestion as error:
        return {"question": _asked(error)}
    if onto:
        measurement = joined(_opened(onto), measurement)
    return _understood(measurement, onto_name or f"{name}{choice}", parts, joined=bool(onto))


def begin(told: Told, spec: str, model: str = "") -> dict[str, Any]:
    """What the command line named: a file, a session or a data set, each as for any other command.

    And a model.

    A file that leaves something open comes with its content, so that the page can ask and send it
    again: nothing that a page says is ever part of a path.

    Raises
    ------
    SpringpotError
        If one of them cannot be used.
    """
    # A model that is mistyped is told before data are read.
    if model:
        parse_model(model)
    if not spec:
        return {}
    path = Path(spec)
    # Before it is opened as data: some tables are JSON too.
    if path.suffix == ".json" and path.is_file() and _opens_a_session(path):
        content = base64.b64encode(bytes_of(path)).decode()
        return understand(told, path.name, content)
    try:
        data, parts = opened(spec)
        if path.is_file():
            _ask_unit(data)
        return _understood(data, _relative(spec), parts)
    except OpenQuestion as error:
        # Something is said behind its name already: the page cannot say more.
        if not path.is_file():
            raise
        content = base64.b64encode(bytes_of(path)).decode()
        return {"question": _asked(error) | {"name": path.name, "content": content}}


def _opens_a_session(path: Path) -> bool:
    """Whether a file begins as a session does; only its head is read, however large it is."""
    with path.open("rb") as file:
        return is_session(file.read(400))


def _ask_unit(data: Opened) -> None:
    """Ask for a unit that nobody told: here a click gives it, where a shell has a note.

    Raises
    ------
    OpenQuestion
        To which the file's own units are an answer as well.
    """
    if not isinstance(data, Measurement) or data.units.stiffness != FILE_UNITS:
        return
    note = data.provenance.get("note units")
    # Who has answered so is not asked again.
    if note is None:
        return
    usual = "Pa" if data.units.is_modulus else "N/mm"
    asked = (Question.of_unit(role, usual, MODULUS_UNITS) for role in ("storage", "loss"))
    raise OpenQuestion(note, asked)


def _asked(error: OpenQuestion) -> dict[str, Any]:
    return {"says": str(error), "asked": [asked.to_dict() for asked in error.questions]}


def _relative(spec: str) -> str:
    """`spec` without folders of this machine alone, for command lines and scripts handed on."""
    path = Path(spec)
    if not path.is_absolute():
        return spec
    if path.is_relative_to(Path.cwd()):
        return str(path.relative_to(Path.cwd()))
    return path.name


def again(
    told: Told, state: Mapping[str, Any], text: str, source: str, joined: bool
) -> dict[str, Any]:
    """Data that the server still has, for a page that was loaded anew."""
    return _understood(_opened(text), source, joined=joined)


def turned(
    told: Told, state: Mapping[str, Any], text: str, source: str, joined: bool
) -> dict[str, Any]:
    """The data with the channels turned that seem to count the other way."""
    data = _opened(text)
    if not isinstance(data, Specimen):
        raise DataError("a channel is turned of tests in time: these are sweeps at frequencies")
    data = data.turned()
    return _understood(data, ", ".join(data.sources), joined=joined)


def dataset(told: Told, name: str) -> dict[str, Any]:
    """A registered data set, with conditions behind ``@``; never a file.

    Raises
    ------
    DataError
        If it is none.
    """
    bare = name.partition("@")[0]
    # Looked up first, as a name that is none would be opened as a file.
    known = [
        item
        for item in plugins().items("data set")
        if bare in (item.name, *item.aliases) and not item.remote
    ]
    if not known:
        raise DataError(
            f"'{name[:80]}' is no registered data set; see '{suggested('list datasets')}'"
        )
    return _understood(open_measurement(name), name)


def _understood(
    data: Opened, source: str, parts: tuple[Part, ...] = (), joined: bool = False
) -> dict[str, Any]:
    text = text_of(data)
    whole = {"digest": digest_of(text), "text": text, "source": source, "joined": joined}
    return {**whole, **understood(data, parts)}


def answered(told: Told, state: Mapping[str, Any], text: str) -> dict[str, Any]:
    """See `springpot.web.tasks.answer`; its ladder is kept for what one leaves with."""
    asked = State.of(state)
    ladder = _ladder(asked, text, told, telling(told, asked, _opened(text)))
    # Told, as the previews of a large library take a while themselves.
    told("drawing what each effect would change")
    return answer(asked, ladder, _opened(text))


def first(told: Told, state: Mapping[str, Any], text: str) -> dict[str, Any]:
    """See `springpot.web.trying.first_look`."""
    asked, data = State.of(state), _opened(text)
    model, tests = looked_at(asked, data)
    (judged,) = compare(tests, [model], seed=asked.seed).judgements
    return first_look(asked, data, judged)


def curve(
    told: Told, state: Mapping[str, Any], text: str, hands: Mapping[str, Any]
) -> dict[str, Any]:
    """The curve of a model whose parameters were set by hand, and its error."""
    asked, data = State.of(state), _opened(text)
    model = bound(asked, data)
    theta = theta_of(model, units_of(tests_in(data)), hand_of(model, hands))
    return drawing(asked, data)(model, theta)


def held(
    told: Told, state: Mapping[str, Any], text: str, hands: Mapping[str, Any]
) -> dict[str, Any]:
    """The best fit that respects what the hand fixed and bounded, begun where the sliders stand."""
    asked, data = State.of(state), _opened(text)
    model = bound(asked, data)
    told(f"fitting {model.name} within the hand's bounds")
    hand = hand_of(model, hands)
    # What is fixed is no parameter of the model any more.
    start = {name: value for name, value in hand.values.items() if name not in hand.fix}
    used, units = tests_in(kept(data, asked.excluded)), units_of(tests_in(data))
    fit: Any = identify(used, model, fix=hand.fix, bounds=hand.bounds, start=start)
    values = hand.fix | {
        parameter.name: float(value * units.of(parameter.unit)[0])
        for parameter, value in zip(fit.model.parameters, fit.theta, strict=True)
    }
    return {**drawing(asked, data)(fit.model, fit.theta), "values": values}


def trial(told: Told, state: Mapping[str, Any], text: str, law: object) -> dict[str, Any]:
    """The model of a state, with a law that is typed if there is one, fitted and drawn."""
    (asked, own), data = with_law(State.of(state), law), _opened(text)
    used = tests_in(kept(data, asked.excluded))
    fit: Any = identify(used, parse_model(asked.expression), **asked.known)
    return tried(asked, own, data, fit)


def laws(told: Told, state: Mapping[str, Any], text: str) -> dict[str, Any]:
    """The laws that may be missing from the model of a state, each drawn."""
    asked, measurement = State.of(state), _measured(text)
    used = kept(measurement, asked.excluded)
    found = invent(used, asked.expression, seed=asked.seed, progress=told, **asked.known)
    return invented(asked, measurement, found)


def ranking(told: Told, state: Mapping[str, Any], text: str) -> dict[str, Any]:
    """All installed models against what any material reaches, see `ranked`."""
    asked, data = State.of(state), _opened(text)
    found = compare(tests_in(kept(data, asked.excluded)), seed=asked.seed, progress=told)
    return ranked(asked, data, found)


def mastered(told: Told, state: Mapping[str, Any], text: str) -> dict[str, Any]:
    """The master curve of the data with its shift factors."""
    asked = State.of(state)
    used = kept(_measured(text), asked.excluded)
    # Temperatures shift by laws that are known; amplitudes are tried where there are none.
    column = "amplitude"
    if "temperature" in used.conditions:
        column = "temperature"
    told(f"bringing the sweeps of each {column} onto one curve")
    result = mastercurve(used, column=column)
    return {"column": column, "curve": result.to_dict()}


def smoothed(told: Told, state: Mapping[str, Any], text: str) -> dict[str, Any]:
    """The spectrum of the material, as smooth as the data allow, with its band."""
    asked = State.of(state)
    used = kept(_measured(text), asked.excluded)
    told("seeking the smoothest spectrum that the data allow")
    found = identify(used, parse_model(asked.expression), fix=asked.fix)
    if found.spectrum is None:
        raise DataError(f"{found.model.name} has elements, and no spectrum that the data choose")
    spectrum, unit = found.spectrum, used.units.stiffness
    columns = ("rates", "density", "low", "high")
    drawn = {name: rounded(getattr(spectrum, name)) for name in columns}
    return {**drawn, "seen": list(spectrum.seen), "unit": unit, "says": in_words(spectrum, unit)}


ENDS = {
    "command": ".txt",
    "script": ".py",
    "data": "-used.csv",
    "curves": "-curves.csv",
    "plan": "-plan.csv",
    "report": "-report.html",
    "replay": "-replay.gif",
}
"""What a user leaves with, and how the names of the files end."""
LACKS = "tests in time leave as the files that were opened, which the session holds too"
"""Why they leave as no table of data."""


def leave(
    told: Told, kind: str, state: Mapping[str, Any], text: str, source: str, joined: bool
) -> dict[str, Any]:
    """One of the things that a user leaves with: its name, and its text or its bytes.

    Raises
    ------
    DataError
        If there is no such thing of these tests.
    """
    asked, data = State.of(state), _opened(text)
    sources = [leaving.source_of(source, asked, joined)]
    if isinstance(data, Specimen):
        source, *_ = sources = data.sources
        _require_sayable(kind, asked, data)
    if kind not in ENDS:
        raise DataError(f"there is nothing called '{kind[:40]}' to leave with")
    name, command = Path(safe_name(source)).stem + ENDS[kind], leaving.command(asked, sources[0])
    if kind == "command":
        return {"name": name, "text": command + "\n"}
    if kind == "script":
        return {"name": name, "text": leaving.script(asked, *sources)}
    if kind == "data":
        return {"name": name, "text": text_of(kept(data, asked.excluded))}
    # What comes below needs the fits; command, script and data do not, and come at once.
    ladder = _ladder(asked, text, told)
    if kind == "replay":
        return {"name": name, "base64": leaving.replay(ladder)}
    # Of sweeps all rows, what is left out among them.
    shown = kept(data, asked.excluded) if isinstance(data, Specimen) else data
    tests = leveled(asked, tests_in(shown))
    if kind == "report":
        return {"name": name, "text": leaving.report(ladder, tests, shlex.split(command))}
    if kind == "plan":
        swept = next(test for test in tests if isinstance(test, Measurement))
        return {"name": name, "text": leaving.plan_csv(ladder, swept)}
    sweep = sweep_of(tests)
    if sweep is None:
        return {"name": name, "text": curves_in_time(ladder, tests)}
    return {"name": name, "text": leaving.curves_csv(ladder, sweep)}


def _require_sayable(kind: str, state: State, data: Specimen) -> None:
    """Refuse what cannot be said of tests in time."""
    if kind == "data":
        raise DataError(LACKS)
    if kind == "plan" and not any(isinstance(test, Measurement) for test in data.tests):
        raise DataError(leaving.IN_WORDS)
    if kind in ("script", "command") and state.excluded and len(data.tests) > 1:
        raise DataError("rows of several tests were left out, which only the session can say")
    if kind == "command" and len(data.sources) > 1:
        raise DataError("one command takes one file: the Python script takes all of them")


def look(
    told: Told, folder: str, known: str = "", base: str = "", before: str = ""
) -> dict[str, Any]:
    """What is new in the folder that is watched; its data as of a file that was dropped."""
    found, data = watched(folder, known, base, before)
    if data is None:
        return found
    shown = found["folder"]
    alone = not base and len(found["files"]) == 1
    source = _relative(str(Path(folder) / found["files"][0])) if alone else shown
    return {**found, **_understood(data, source, joined=not alone)}


def raced(told: Told, name: str = "", report: bool = False) -> dict[str, Any]:
    """The studies here, or one of them with its tables, or its report as a file."""
    if not name:
        return {"studies": studies()}
    if report:
        return report_of(name)
    return study(name)


TASKS: dict[str, Callable[..., dict[str, Any]]] = {
    "library": library,
    "understand": understand,
    "begin": begin,
    "dataset": dataset,
    "again": again,
    "turned": turned,
    "answer": answered,
    "first": first,
    "curve": curve,
    "held": held,
    "trial": trial,
    "laws": laws,
    "ranking": ranking,
    "mastercurve": mastered,
    "spectrum": smoothed,
    "leave": leave,
    "race": raced,
    "watch": look,
}


def perform(task: str, arguments: Mapping[str, Any], told: Told) -> dict[str, Any]:
    """What a task gives, or the one line that the command line would print.

    Returns
    -------
    dict
        ``{"result": ...}``, or ``{"error": line, "fault": whether it is one of springpot}``.
    """
    try:
        return {"result": TASKS[task](told, **arguments)}
    except SpringpotError as error:
        return {"error": " ".join(str(error).split()), "fault": False}
    # A plugin may raise anything, and the page must hear of it.
    except Exception as error:
        by_plugin = blamed(error)
        line = (
            by_plugin
            or f"a fault in springpot or one of its plugins, not in your input: {described(error)}"
        )
        return {"error": " ".join(line.split())[:400], "fault": not by_plugin}
