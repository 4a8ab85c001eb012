"""Whole answers of small cases, each kept in a file beside its test.

A test hands over all that it was told; the file ``answers/NAME.json`` in the folder of the test
says what that was. ``SPRINGPOT_KEEP=1 pytest TESTS`` writes anew what a change moved on purpose.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

DIGITS = 7
WITHIN = 1e-4
"""Relative difference that another machine's rounding may make."""
NEXT_TO_NOTHING = 1e-8
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
IN_FULL = 6
"""Digits of a number as files hold them; what is rounded for a reader must stay to the letter."""
NOTHING = re.compile(r"-?\d+(?:\.\d+)?e-(?:1[2-9]|[2-9]\d)\d*|(?<![\d.])-?0\.0(?!\d)")
"""What only rounding leaves, however a machine writes it."""
WHOLE = re.compile(r"(?<=\d)\.0(?!\d)")
MOST = 20
"""Places that are told of an answer that moved."""
LONGEST = 12
"""Numbers of an array that are kept one by one; of a longer one its size and four sums."""


def plain(part: Any) -> Any:
    """What JSON holds of an answer: fields of objects by name, long arrays by their sums."""
    if isinstance(part, np.ndarray):
        return _of_array(part)
    if isinstance(part, np.generic):
        return plain(part.item())
    if isinstance(part, complex):
        return [plain(part.real), plain(part.imag)]
    if isinstance(part, float):
        return float(f"{part:.{DIGITS}g}") if math.isfinite(part) else str(part)
    if isinstance(part, str | int | None):
        return part
    if isinstance(part, Mapping):
        return {str(key): plain(value) for key, value in part.items()}
    if dataclasses.is_dataclass(part):
        return {each.name: plain(getattr(part, each.name)) for each in dataclasses.fields(part)}
    if hasattr(part, "savefig"):
        size = plain(np.array(part.get_size_inches()))
        above = [_of_legend(legend) for legend in part.legends]
        return [{"size": size, "above": above}, *(_of_axes(axes) for axes in part.axes)]
    if hasattr(part, "_asdict"):
        return plain(part._asdict())
    return [plain(each) for each in part]


def _a_line_each(answer: Any) -> str:
    """JSON with a line for each part, so that a change of one is a change of one line."""
    if not isinstance(answer, dict):
        return json.dumps(answer) + "\n"
    lines = ",\n".join(f"{json.dumps(key)}: {json.dumps(part)}" for key, part in answer.items())
    return f"{{\n{lines}\n}}\n"


def _of_array(values: np.ndarray) -> Any:
    if values.size <= LONGEST:
        return [plain(each) for each in values.tolist()] if values.ndim else plain(values.item())
    flat = np.nan_to_num(values.ravel().astype(complex))
    along = np.linspace(-1.0, 1.0, flat.size)
    sums = [flat.sum(), np.abs(flat).sum(), flat @ along, flat @ along**2]
    kept = sums if np.iscomplexobj(values) else [each.real for each in sums]
    return {"shape": list(values.shape), "sums": [plain(complex(each)) for each in kept]}


def _of_axes(axes: Any) -> dict[str, Any]:
    """What a reader of a figure sees: the axes, what is written, and where the curves run."""
    legend = axes.get_legend()
    return {
        "title": axes.get_title(),
        "x": [axes.get_xlabel(), *_of_axis(axes.xaxis), *plain(np.array(axes.get_xlim()))],
        "y": [axes.get_ylabel(), *_of_axis(axes.yaxis), *plain(np.array(axes.get_ylim()))],
        "legend": _of_legend(legend) if legend else [],
        "texts": [[text.get_text(), *plain(np.array(text.get_position()))] for text in axes.texts],
        "lines": [[_of_line(line), plain(np.array(line.get_xydata()))] for line in axes.lines],
        "areas": [
            [
                _of_look(each, plain(np.array(each.get_facecolor()))),
                plain(
                    np.concatenate([path.vertices for path in each.get_paths()] or [np.zeros(0)])
                ),
            ]
            for each in axes.collections
        ],
        "patches": [plain(np.array(patch.get_extents().size)) for patch in axes.patches],
    }


def _of_legend(legend: Any) -> list[Any]:
    """What is named, and by which lines."""
    named = [text.get_text() for text in legend.get_texts()]
    return [legend.get_title().get_text(), *named, *map(_of_line, legend.get_lines())]


def _of_line(line: Any) -> list[Any]:
    """How a line looks and its marks."""
    marks = [line.get_linestyle(), line.get_marker(), plain(line.get_markersize())]
    return [*_of_look(line, str(line.get_color())), *marks]


def _of_axis(axis: Any) -> list[Any]:
    """How an axis is scaled, where it has numbers, and by which rule they are written."""
    low, high = sorted(axis.get_view_interval())
    ticks = axis.get_majorticklocs()
    return [
        axis.get_scale(),
        plain(ticks[(ticks >= low) & (ticks <= high)]),
        type(axis.get_major_formatter()).__name__,
    ]


def _of_look(drawn: Any, colour: Any) -> list[Any]:
    """Colour, opacity, width of its lines and what lies above what."""
    return [
        colour,
        *(plain(each) for each in (drawn.get_alpha(), drawn.get_zorder())),
        _wide(drawn),
    ]


def _wide(drawn: Any) -> Any:
    return plain(np.array(drawn.get_linewidth()))


def moved(before: Any, after: Any, within: float, place: str = "") -> Iterator[str]:
    """Each place where two answers differ, numbers by more than rounding."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in {**before, **after}:
            yield from moved(before.get(key), after.get(key), within, f"{place}.{key}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for index, (old, new) in enumerate(zip(before, after, strict=True)):
            yield from moved(old, new, within, f"{place}[{index}]")
    elif isinstance(before, int | float) and isinstance(after, int | float):
        if not math.isclose(before, after, rel_tol=within, abs_tol=NEXT_TO_NOTHING):
            yield f"{place}: {before!r} -> {after!r}"
    elif isinstance(before, str) and isinstance(after, str):
        # Texts are alike where their words are, and their numbers but for rounding.
        before, after = rounded(before), rounded(after)
        words = NUMBER.split(before) == NUMBER.split(after)
        numbers = zip(NUMBER.findall(before), NUMBER.findall(after), strict=False)
        if not words or not all(_alike(old, new, within) for old, new in numbers):
            yield f"{place}: {before!r} -> {after!r}"
    elif before != after:
        yield f"{place}: {before!r} -> {after!r}"


def _alike(old: str, new: str, within: float) -> bool:
    """Whether two numbers of a text are one: in full but for rounding, else to the letter."""
    if old == new:
        return True
    digits = min(len(re.sub(r"e.*|[-.]", "", each).lstrip("0")) for each in (old, new))
    return digits >= IN_FULL and not list(moved(float(old), float(new), within))


def rounded(text: str) -> str:
    """A text in which numbers that rounding alone made long are short.

    3.0000000000000027 and 3.0 are 3.
    """

    def short(found: re.Match[str]) -> str:
        value = f"{float(found[0]):.{DIGITS}g}"
        return value if len(value) < DIGITS else found[0]

    return WHOLE.sub("", NUMBER.sub(short, NOTHING.sub("0", text)))


@pytest.fixture
def stays(request: pytest.FixtureRequest) -> Any:
    """Hold an answer against the one that is kept under the name of the test."""
    folder = Path(request.path).parent / "answers"
    name = request.node.name.removeprefix("test_").replace("[", "-").replace("]", "")
    file = folder / f"{name}.json"

    def check(answer: Any, within: float = WITHIN) -> None:
        now = plain(answer)
        if "SPRINGPOT_KEEP" in os.environ:
            folder.mkdir(exist_ok=True)
            file.write_text(_a_line_each(now), encoding="utf-8")
        before = json.loads(file.read_text(encoding="utf-8"))
        found = list(moved(before, json.loads(json.dumps(now)), within))
        assert not found, "\n".join(found[:MOST])

    return check
