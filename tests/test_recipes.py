"""The recipes and tutorials run, and print to the letter what they show.

Blocks are marked as in the README.

``python tests/test_recipes.py`` shows what each page prints today.
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
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"
WISHES = DOCS / "wishes.md"
PAGES = [DOCS / "recipes.md", WISHES, *sorted((DOCS / "tutorials").glob("*.md"))]
BLOCK = re.compile(r"^```(\S+)(?: (\S+))?\n(.*?)^```$", re.M | re.S)
GAP = "..."
RUNS = r"^```(?:console|python)"


def commanded(line: str) -> list[str]:
    """What a command of springpot prints; ``> FILE`` puts it there."""
    from springpot.cli.group import exit_code, run

    words = shlex.split(line)
    target = words[words.index(">") + 1] if ">" in words else None
    arguments = words[1 : words.index(">") if target else None]
    with (
        contextlib.redirect_stdout(io.StringIO()) as stream,
        contextlib.redirect_stderr(io.StringIO()) as errors,
    ):
        code = exit_code(lambda: run(arguments))
    assert code == 0, f"{line}: {errors.getvalue()}"
    if target:
        Path(target).write_text(stream.getvalue(), encoding="utf-8")
        return []
    return stream.getvalue().splitlines()


def shown_and_real(text: str) -> Iterator[tuple[str, list[str], list[str]]]:
    """What a page shows and what comes, in the order of the page."""
    names: dict[str, object] = {}
    printed = io.StringIO()
    for language, name, body in BLOCK.findall(text):
        if "." in name:
            Path(name).write_text(body, encoding="utf-8")
        elif language == "console":
            for part in re.split(r"^\$ ", body, flags=re.M)[1:]:
                command, *shown = part.splitlines()
                yield command, shown, commanded(command)
        elif language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile(body, "page", "exec"), names)
        elif language == "output":
            yield "python", body.splitlines(), printed.getvalue().splitlines()


def alike(shown: list[str], real: list[str]) -> bool:
    """Whether lines are the same, ``...`` standing for any number of them."""
    pattern = "".join(
        r"(?:.*\n)*?" if line == GAP else re.escape(line.rstrip()) + r"\s*?\n" for line in shown
    )
    return (
        re.fullmatch(pattern + r"\n*", "".join(f"{line.rstrip()}\n" for line in real)) is not None
    )


@pytest.mark.soak_cases("damper", "optimisers", "recipes", "wishes")
@pytest.mark.usefixtures("asked_once", "unpainted")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_print_what_they_show(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    found = list(shown_and_real(page.read_text(encoding="utf-8")))
    assert found
    for title, shown, real in found:
        assert alike(shown, real), f"{title}\n" + "\n".join(real)


def run_in(page: Path) -> set[str]:
    """Anchors of the sections of a page in which something runs."""
    sections = re.split(r"^## ", page.read_text(encoding="utf-8"), flags=re.M)[1:]
    titles = [part.splitlines()[0].lower() for part in sections if re.search(RUNS, part, re.M)]
    return {re.sub(r"[^\w -]", "", title).replace(" ", "-") for title in titles}


def test_fifty_of_54_wishes_are_one_command_or_three_lines_that_run():
    rows = re.findall(r"^\| (\d+) \| .+? \| (.+) \|$", WISHES.read_text(encoding="utf-8"), re.M)
    assert [int(number) for number, _ in rows] == list(range(1, 55))
    refused = [how for _, how in rows if how.startswith("not: ")]
    assert len(refused) <= 4
    sections = {"recipes.md": run_in(DOCS / "recipes.md"), "": run_in(WISHES)}
    for number, how in rows:
        if how not in refused:
            [(page, anchor)] = re.findall(r"\]\(([\w.]*)#([\w-]+)\)", how)
            assert anchor in sections[page], number


def test_a_wrong_number_is_noticed():
    assert alike(["a 1", GAP, "b"], ["a 1", "x", "b"])
    assert not alike(["a 1"], ["a 2"])
    assert not alike(["a", "b"], ["a", "c", "b"])


if __name__ == "__main__":
    os.environ["COLUMNS"] = "120"
    for path in [Path(name).resolve() for name in sys.argv[1:]] or PAGES:
        os.chdir(tempfile.mkdtemp())
        for title, shown, real in shown_and_real(path.read_text(encoding="utf-8")):
            if not alike(shown, real):
                print(f"{path.name}: {title}", *real, sep="\n    ")
