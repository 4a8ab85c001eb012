"""The report of a discovery: one HTML file that needs nothing else, whoever opens it."""

from __future__ import annotations

import platform
import shlex
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import isfinite
from pathlib import Path

from springpot.diagnosis.ladder import Ladder, Step
from springpot.diagnosis.result import Diagnosis
from springpot.errors import OutputError
from springpot.files import require_writable, write_text
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test, sweep_of
from springpot.misfit.residuals_of_tests import SweepPart, parts_of_specimen
from springpot.registry import versions
from springpot.rheology.drawing import network_svg
from springpot.writing import LISTED, Html, joined, tag, wide, wide_table

from .answers import (
    absent_text,
    effects_note,
    left_out,
    not_shown,
    physics,
    places_failed,
    quantities_passages,
    ranking,
    reference_note,
    times,
    worth_showing,
)
from .canvas import require_matplotlib
from .figures import scene_of
from .fit_text import parameters_table
from .interactive.answers import DrawnTests, TimeScene, drawn, rungs
from .interactive.scene import PageScene
from .ladder_text import accepted_name, data_of, draw_ladder, remarks, steps_table
from .page import PageParts, bench_of, page
from .residuals import (
    data_and_model,
    figure_tests,
    fits_in_time,
    framed,
    keys,
    other_views,
    panel,
    residual_planes,
    set_aside,
    with_noise_of,
)
from .text import percent, told_range
from .views import DrawnFit, Scene

SUFFIXES = (".html", ".htm")


def check_report_path(path: str | Path) -> Path:
    """`path`, after a check that a report can be written there.

    Called before long work, not after it.

    Raises
    ------
    OutputError
        If its name does not end in .html, matplotlib is missing, or the place cannot be written.
    """
    if Path(path).suffix.lower() not in SUFFIXES:
        raise OutputError(f"cannot write the report {path}: its name must end in .html")
    # Asked before minutes of fitting, like all else that could prevent the report.
    require_matplotlib()
    return require_writable(path)


def write_report(
    ladder: Ladder,
    data: Measurement | Sequence[Test],
    path: str | Path,
    command: Sequence[str],
) -> Path:
    """Write the report of a discovery.

    Parameters
    ----------
    ladder : Ladder
        The discovery.
    data : Measurement, or a sequence of tests
        What was measured: a sweep, or tests with one in time among them.
    path : str or Path
        Where to write.
    command : sequence of str
        What gives the same result again.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    return write_text(check_report_path(path), report_html(ladder, data, command))


def report_html(ladder: Ladder, data: Measurement | Sequence[Test], command: Sequence[str]) -> Html:
    """The report as text; parameters as in `write_report`."""
    tests: Sequence[Test] = [data] if isinstance(data, Measurement) else data
    sweep = sweep_of(tests)
    bench = _bench(ladder, tests if sweep is None else sweep)
    if sweep is not None:
        scenes = _scenes(ladder, sweep)
        pictures = [*_seen(scenes), *_places(ladder), *_planes(scenes)]
    else:
        pictures = [*_drawn_tests(ladder, tests), *_places(ladder)]
    body = [
        # The answer first, then what can be pointed at, then the evidence, and last how to repeat
        # it.
        *_head(ladder),
        tag("h2", "Point at it"),
        tag("p", POINTING, class_="quiet"),
        bench.body,
        *_ladder(ladder),
        *pictures,
        *_rankings(ladder),
        *_classes(ladder),
        *_next(ladder),
        *_models(ladder),
        *_repeat(ladder, tests, command),
    ]
    title = f"{ladder.steps[0].model.name} of {ladder.data}"
    return page(title, *body, style=bench.style, script=bench.policy)


def _seen(scenes: dict[str, Scene]) -> Iterator[Html]:
    yield tag("h2", "Data and model")
    for name, scene in scenes.items():
        yield tag("p", tag("b", f"{name}: "), scene.fits[0].name)
    yield keys(next(iter(scenes.values())))
    yield data_and_model(scenes)


def _planes(scenes: dict[str, Scene], of: str = "") -> Iterator[Html]:
    yield tag("h2", f"Residual planes{of}")
    yield tag("p", READING, class_="quiet")
    yield from residual_planes(scenes)
    yield tag("h2", f"Other views{of}")
    yield other_views(scenes)


def _drawn_tests(ladder: Ladder, tests: Sequence[Test]) -> Iterator[Html]:
    """Each test in time with the first and the last model, which may be one."""
    yield tag("h2", "Data and model")
    ends = dict.fromkeys((ladder.steps[0], ladder.steps[-1]))
    fits = fits_in_time(step.examined.base for step in ends if step.examined is not None)
    figure = figure_tests(fits, tests)
    # Without a path it is the figure itself.
    assert not isinstance(figure, Path)
    yield framed(figure, "Each test, the models, and what these leave over the noise")
    for part in parts_of_specimen(tests):
        if isinstance(part, SweepPart):
            words = ("before", "after") if len(fits) > 1 else ("the model",)
            scenes = {each: scene_of(part, [fit]) for each, fit in zip(words, fits, strict=True)}
            yield keys(scenes[words[0]])
            yield from _planes(scenes, f" of {part.test.name}")


def _diagnosed(ladder: Ladder) -> dict[Step, Diagnosis]:
    """The steps that were judged, with what was said of them: of one from a file the last alone."""
    judged = {step: step.diagnosis for step in ladder.steps if step.examined is not None}
    return judged or {ladder.steps[-1]: ladder.diagnosis}


POINTING = (
    "An effect shows what it would do: its curve, dashed, and the error with it. A step of the"
    " ladder shows the model of that step. All of it is in this file. On paper, and where no"
    " scripts run, there are the pictures below."
)
READING = (
    "An effect that is missing is simplest in the plane in which it adds up. A moving mass grows as"
    " the square of the frequency in the stiffness, a soft mounting is constant in the compliance,"
    " a delay grows with the frequency in the phase, and a change of temperature is constant in the"
    " shift. Where most points lie in the band, or of several in that of their own colour, nothing"
    " is missing."
)


def _bench(ladder: Ladder, data: Measurement | Sequence[Test]) -> PageParts:
    """The panels of the workbench, with every step of the ladder."""
    # The same scene as the workbench, so that a report and the page cannot say different things.
    scene: DrawnTests
    if isinstance(data, Measurement):
        scene, excluded = PageScene(data), excluded_rows(ladder, data)
    else:
        scene, excluded = TimeScene(data), []
    steps = rungs(ladder, lambda part: drawn(part, scene))
    return bench_of({"scene": scene.to_dict(), "rungs": steps, "excluded": excluded})


def excluded_rows(ladder: Ladder, measurement: Measurement) -> list[int]:
    """Rows that no model was fitted to."""
    aside = set_aside(measurement, ladder.steps[-1].case.search.base.data.raw)
    if aside is None:
        return []
    # A subset does not remember its rows; both are copies of the same floats, so that equal means
    # the same point.
    points = set(zip(aside.omega.tolist(), aside.stiffness.tolist(), strict=True))
    measured = zip(measurement.omega.tolist(), measurement.stiffness.tolist(), strict=True)
    return [row for row, point in enumerate(measured) if point in points]


def _scenes(ladder: Ladder, measurement: Measurement) -> dict[str, Scene]:
    """Data with the first and the last model, which are one if nothing was accepted."""
    first, last = ladder.steps[0].case.search.base, ladder.steps[-1].case.search.base
    # The noise as the last model tells it, for both: two bands would look like two sets of data.
    data = with_noise_of(last.data.mean, last.noise.sd)
    aside = set_aside(measurement, last.data.raw)
    if len(ladder.steps) == 1:
        return {"the model": Scene(data, [DrawnFit(first.model, first.theta)], aside)}
    return {
        "before": Scene(data, [DrawnFit(first.model, first.theta)], aside),
        "after": Scene(data, [DrawnFit(last.model, last.theta)], aside),
    }


def _head(ladder: Ladder) -> Iterator[Html]:
    first, last = ladder.steps[0], ladder.steps[-1]
    error = ladder.diagnosis.error
    added = [accepted_name(step) for step in ladder.steps[1:]]
    material = []
    # Where no material was looked for there is nothing to tell.
    if isfinite(last.material_floor):
        material = [("material floor", percent(last.material_floor))]
    facts = [
        ("error of the model given", percent(first.relative_rms)),
        ("error at the end", percent(last.relative_rms)),
        (f"noise floor ({error.noise_source})", percent(last.noise_floor)),
        *material,
        ("error against the floor", times(last.relative_rms, error).replace(" x ", " × ")),
        ("accepted", joined(tag("span", name, class_="whole") for name in added) or "nothing"),
    ]
    yield tag("h1", f"What is missing from {first.model.name}?")
    points, size = sum(test.points for test in last.tests), "the signal"
    if measured := data_of(first):
        points, size = len(measured), measured.units.magnitude
    yield tag("p", f"Data: {ladder.data}, {points} points", class_="quiet")
    if added:
        names = " ".join(added)
        fall = f"{percent(first.relative_rms)} to {percent(last.relative_rms)} of {size}"
        story = f"Accepted: {names}. The error falls from {fall}."
    else:
        story = f"The error is {percent(first.relative_rms)} of {size}; no effect was accepted."
    # By `tag`, as everywhere: names of data and plugins are escaped, whatever stands in them.
    verdict = tag("div", tag("b", f"{ladder.verdict}: "), f"{ladder.diagnosis.says}.")
    split = [tag("div", f"{_capital(sentence)}.") for sentence in _splits(ladder)]
    yield tag("div", tag("div", story), verdict, *split, class_="verdict")
    yield tag(
        "div",
        *(tag("div", tag("b", value), word, class_="fact") for word, value in facts),
        class_="facts",
    )
    for note in ladder.diagnosis.notes:
        yield tag("p", f"Note: {note}.")


def _splits(ladder: Ladder) -> list[str]:
    """What the material floor says of the first model, and of the last where that is another."""
    judged = _diagnosed(ladder)
    ends = [judged[step] for step in (ladder.steps[0], ladder.steps[-1]) if step in judged]
    # Where nothing was accepted both are one, which is told once.
    return list(dict.fromkeys(f"{one.model.name}: {one.split}" for one in ends if one.split))


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _ladder(ladder: Ladder) -> Iterator[Html]:
    yield tag("h2", "The error, step by step")
    caption = (
        "Error after each accepted effect, as predicted before and as reached, against the noise"
        " floor and the least error that any material reaches with the same effects"
    )
    picture = panel(
        lambda axes: draw_ladder(axes, ladder),
        caption,
        max(4.6, 0.8 * len(ladder.steps) + 1.4),
        3.6,
    )
    yield tag("div", picture, class_="alone")
    yield steps_table(ladder).as_html()
    yield remarks(ladder).as_html()


def _places(ladder: Ladder) -> Iterator[Html]:
    """Where the first and the last model fail, as their diagnoses say.

    Bands, single points and what swings.
    """
    yield tag("h2", "Where the model fails")
    judged = _diagnosed(ladder)
    # Where nothing was accepted the first step is the last one too.
    for step in dict.fromkeys((ladder.steps[0], ladder.steps[-1])):
        if step not in judged:
            continue
        diagnosis = judged[step]
        yield tag("h3", step.model.name)
        yield places_failed(diagnosis).as_html()


def _rankings(ladder: Ladder) -> Iterator[Html]:
    yield tag("h2", "Which effects could it be?")
    yield tag(
        "p",
        "Each effect of the library was tried on the data. Probability: that it is among what is"
        " missing. ΔBIC: how strongly the data ask for it; above 6 is clear, above 10 decisive."
        " Predicted and after: the error with it, and in brackets how many noise floors that is."
        " What helps lowers the error, which is no proof that it is there.",
        class_="quiet",
    )
    judged = _diagnosed(ladder)
    for i, step in enumerate(ladder.steps):
        if step not in judged:
            continue
        parts = [tag("summary", f"Step {i}: {step.model.name}"), *_ranking(step, judged[step])]
        # The first and the last are read, those between are looked up.
        if i == 0 or i + 1 == len(ladder.steps):
            yield tag("details", *parts, open="")
        else:
            yield tag("details", *parts)


def _ranking(step: Step, diagnosis: Diagnosis) -> Iterator[Html]:
    yield tag("p", f"{_capital(diagnosis.says)}.")
    shown = worth_showing(diagnosis, LISTED)
    yield ranking(diagnosis, shown).as_html()
    yield physics(shown, LISTED).as_html()
    yield from _note(effects_note(data_of(step), (row.effect for row in shown)))
    judged = [row.effect for row in diagnosis.candidates]
    yield left_out(diagnosis.left_out, judged).as_html()
    if diagnosis.verdict != "adequate":
        yield not_shown(diagnosis, shown).as_html()
    yield from _note(absent_text(diagnosis))


def _classes(ladder: Ladder) -> Iterator[Html]:
    """What an accepted effect stands for, and which of those still open look alike."""
    yield tag("h2", "What these data cannot tell apart")
    # The first step is the model that was given: nothing was accepted there.
    doubtful = [step for step in ladder.steps[1:] if len(step.alike) > 1]
    lines = []
    for step in doubtful:
        others = " or ".join(_others(step))
        lines.append(f"{accepted_name(step)} was accepted; as well it might be {others}.")
    # Of an adequate model no effect is open any more, alike or not.
    if ladder.verdict != "adequate":
        for names in ladder.diagnosis.classes:
            if len(names) > 1:
                lines.append(f"Still open and alike: {', '.join(names)}.")
    if lines:
        yield tag(
            "p", "These effects change the data alike. Only another experiment separates them."
        )
        yield tag("ul", *(tag("li", line) for line in lines))
    else:
        yield tag(
            "p", "Each accepted effect is the only one of the library that explains these data."
        )


def _others(step: Step) -> list[str]:
    return [name for name in step.alike if name != step.accepted]


def _next(ladder: Ladder) -> Iterator[Html]:
    """Advice of the last diagnosis.

    Where nothing is open there, of the last step whose answer was not unique.
    """
    yield tag("h2", "What to measure next")
    diagnosis = ladder.diagnosis
    # Where nothing is missing any more, the open question is which of several alike was accepted.
    if ladder.verdict == "adequate":
        pairs = pairwise(ladder.steps)
        judged = _diagnosed(ladder)
        unsure = (before for before, step in pairs if len(step.alike) > 1)
        doubtful = [judged[step] for step in unsure if step in judged]
        if not doubtful:
            yield tag("p", "Nothing is left that another measurement would have to decide.")
            return
        diagnosis = doubtful[-1]
    advice = diagnosis.next_experiment
    if advice is None:
        yield tag("p", "No further measurement is known that would help.")
    else:
        yield tag("p", f"{_capital(advice.says)}.")


def _models(ladder: Ladder) -> Iterator[Html]:
    yield tag("h2", "The model")
    # By name, since both are one where nothing was accepted.
    steps = {step.model.name: step for step in (ladder.steps[0], ladder.steps[-1])}
    for name, step in steps.items():
        yield tag("h3", name)
        # Made here with every label escaped, so that it may enter the page as it is.
        yield wide(f"network of {name}", Html(network_svg(step.model.network)))
        yield parameters_table("parameter", step.parameters).as_html()
        yield from _note(reference_note(data_of(step), [step.model.network]))
    if ladder.diagnosis.quantities:
        yield tag("h3", "Quantities of the last model")
        for passage in quantities_passages(ladder.diagnosis.quantities, verbose=True):
            yield passage.as_html()


def _note(text: str) -> Iterator[Html]:
    if text:
        yield tag("p", f"{_capital(text)}.", class_="quiet")


def _repeat(ladder: Ladder, tests: Sequence[Test], command: Sequence[str]) -> Iterator[Html]:
    rows = []
    for test in tests:
        rows.append(("data", test.name))
        if isinstance(test, Measurement):
            rows.append(("points", f"{len(test)}, {told_range(test)}"))
            # Of the numbers, not of the file: whoever repeats it may have another format.
            rows.append(("SHA-256 of the data", test.digest()))
        rows += [(str(key), str(value)) for key, value in test.provenance.items()]
    yield tag("h2", "To repeat this")
    # Quoted for a shell, as it is to be copied.
    yield tag("pre", shlex.join(command))
    yield wide_table(("what", "value"), [*rows, *_versions()])
    yield tag(
        "p", f"Verdict of the last step: {ladder.verdict}. Made by springpot.", class_="quiet"
    )


def _versions() -> Iterator[tuple[str, str]]:
    yield "Python", platform.python_version()
    yield from versions().items()
