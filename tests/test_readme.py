"""Every example of the README runs and gives the output that it shows.

The first line of a fenced block says what it is: ``csv NAME`` and ``python NAME`` are files,
``console`` is commands after ``$`` with their output, ``python`` is run as it stands, ``output`` is
what it prints, ``python quoted`` is part of the example plugin, ``sh`` is not run. A line ``...``
stands for any number of lines. Numbers and the width of columns may differ, words may not. ``python
tests/test_readme.py`` writes today's numbers into the README.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
BLOCK = re.compile(r"^```(\S+)(?: (\S+))?\n(.*?)^```$", re.M | re.S)
NUMBER = re.compile(r"[<>]?-?(?:\d+(?:\.\d+)?(?:e[+-]?\d+)?|∞|–)")
GAP = "..."


@dataclass(frozen=True)
class Example:
    """What the README shows, and what really comes."""

    title: str
    shown: list[str]
    actual: list[str]

    def pairs(self) -> Iterator[tuple[str, str | None]]:
        """Each line shown with the actual one that it stands for, if there is one at its place."""
        rest = iter(self.actual)
        gap = False
        for line in self.shown:
            if line.strip() == GAP:
                gap = True
                continue
            found = next((real for real in rest if not gap or masked(real) == masked(line)), None)
            yield line, found if found is not None and masked(found) == masked(line) else None
            gap = False
        if not gap:
            yield from (("", real) for real in rest if real.strip())


def masked(line: str) -> str:
    """A line without what may differ: numbers, rules and spaces."""
    return " ".join(re.sub(r"-{3,}", "-", NUMBER.sub("#", line)).split())


def run(command: str) -> list[str]:
    """What a command of springpot prints."""
    from springpot.cli.group import exit_code, run as springpot

    name, *arguments = shlex.split(command)
    assert name == "springpot", f"the README runs {name}"
    if arguments[0] == "run":
        # The same bytes, and no processes that take longer to start than the race.
        arguments += ["--engine", "serial"]
    with contextlib.redirect_stdout(io.StringIO()) as stream:
        code = exit_code(lambda: springpot(arguments))
    assert code == 0, f"{command} ends with exit code {code}"
    return stream.getvalue().splitlines()


def examples(text: str) -> Iterator[Example]:
    """All examples in the order of the README, run in the current folder."""
    names: dict[str, object] = {}
    printed = io.StringIO()
    for language, name, body in BLOCK.findall(text):
        if language in ("csv", "python") and "." in name:
            Path(name).write_text(body, encoding="utf-8")
        elif language == "console":
            for part in re.split(r"^\$ ", body, flags=re.M)[1:]:
                command, *shown = part.splitlines()
                yield Example(command, shown, run(command))
        elif language == "python" and not name:
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile(body, "README.md", "exec"), names)
        elif language == "output":
            yield Example("python", body.splitlines(), printed.getvalue().splitlines())


@pytest.mark.usefixtures("asked_once", "unpainted")
def test_examples_give_what_they_show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    found = list(examples(README.read_text(encoding="utf-8")))
    assert len(found) >= 6
    for example in found:
        for shown, actual in example.pairs():
            where = f"$ {example.title}\nREADME shows: {shown}\nin reality:\n" + "\n".join(
                example.actual
            )
            assert actual is not None, where
            assert masked(shown) == masked(actual), where
    assert (tmp_path / "report.html").stat().st_size > 0
    assert (tmp_path / "ladder.png").stat().st_size > 0


def test_a_line_that_is_not_printed_is_noticed():
    real = ["error 5 %", "", "note one", "note two"]
    assert all(
        found is not None
        for _, found in Example("", ["error 4.9 %", GAP, "note two"], real).pairs()
    )
    assert None in [found for _, found in Example("", ["fault 5 %", GAP], real).pairs()]
    assert None in [
        found for _, found in Example("", ["error 5 %", GAP, "note three", GAP], real).pairs()
    ]
    assert ("", "note two") in list(Example("", ["error 5 %", "", "note one"], real).pairs())


def test_quoted_code_is_that_of_the_example_plugin():
    source = (ROOT / "tests" / "example_plugin" / "springpot_example.py").read_text(
        encoding="utf-8"
    )
    quoted = [
        body
        for language, name, body in BLOCK.findall(README.read_text(encoding="utf-8"))
        if name == "quoted"
    ]
    assert len(quoted) == 3
    for body in quoted:
        assert body in source
        assert len(body.splitlines()) < 30


@pytest.mark.parametrize(
    "page", [README, *sorted((ROOT / "docs").glob("*.md"))], ids=lambda page: page.name
)
def test_links_lead_somewhere(page: Path):
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        # The reports of the gallery are made with the site; tests/test_gallery.py holds their
        # names.
        if not target.startswith(("http:", "https:", "gallery/")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def refreshed(text: str) -> str:
    """The README with today's numbers in the lines that it shows."""
    for example in examples(text):
        for shown, actual in example.pairs():
            if shown.strip() and actual is not None:
                text = text.replace(f"\n{shown}\n", f"\n{actual}\n", 1)
            elif masked(shown) != masked(actual or ""):
                print(f"$ {example.title}: paste by hand: {shown or actual}", file=sys.stderr)
    return text


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        README.write_text(refreshed(README.read_text(encoding="utf-8")), encoding="utf-8")
