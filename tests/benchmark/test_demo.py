"""The demonstration: chapters one after another, kept as they were printed."""

from types import SimpleNamespace

import pytest
from test_whole_benchmark import filled, study

from springpot import registry
from springpot.benchmark import runner
from springpot.benchmark.commands import demo
from springpot.cli import group
from springpot.hooks import Chapter, Race

WORDS = Chapter("Words", ("list", "--help"))
PAGE = Chapter("A page", ("workbench", "data.csv", "--out", "{out}"), left_to_user=True)
RACE = Chapter("A race", race=Race("small", ("artificial",), ("walk",), "paper", 2, 60))


@pytest.fixture
def story(monkeypatch, springpot, tmp_path):
    """What a demonstration of some chapters says; its race is one that was run before."""
    asked = []

    def run_study(study, **given):
        asked.append((study.name, study.repetitions, study.budget, given["quiet"]))
        return SimpleNamespace(store=filled(tmp_path / "made.sqlite", made))

    made, installed = study(2, 2, 3).plan(), registry.plugins()

    def items(kind):
        return told["chapters"] if kind == "chapter" else installed.items(kind)

    class Installed:
        def __getattr__(self, name):
            return items if name == "items" else getattr(installed, name)

    told = {"asked": asked}
    monkeypatch.setattr(registry, "plugins", Installed)
    monkeypatch.setattr(runner, "run_study", run_study)

    def say(*chapters, more=()):
        told["chapters"] = chapters
        return springpot("demo", "--out", tmp_path / "a b" / "c", *more), asked

    return say


def test_chapters_are_told_in_turn_and_kept(story, tmp_path, stays):
    folder = tmp_path / "a b" / "c"
    for _ in range(2):
        answer, asked = story(WORDS, PAGE, RACE)
    assert answer.code == 0
    lines = answer.out.splitlines()
    assert lines[:3] == ["1. Words", "========", "$ springpot list --help"]
    assert f"$ springpot workbench data.csv --out '{folder}'" in lines
    at = lines.index("2. A page")
    assert lines[at - 1 : at + 2] == ["", "2. A page", "========="]
    assert lines[-1] == f"written: {folder}"
    assert asked == [("small", 2, 60, True)] * 2
    race = lines[lines.index("3. A race") + 2 :]
    stays({"race": [line for line in race if str(tmp_path) not in line]})
    assert answer.out.startswith((folder / "story.txt").read_text(encoding="utf-8")[:40])


def test_as_json_only_the_files_are_told(story, tmp_path):
    answer, _ = story(WORDS, more=["--json"])
    assert answer.json["files"] == [str(tmp_path / "a b" / "c" / "story.txt")]


def test_a_chapter_without_a_full_answer_ends_no_story(monkeypatch, tmp_path):
    codes = {"one": 1, "two": 3, "three": 0}
    monkeypatch.setattr(group, "run", lambda words: print("answer") or codes[words[0]])
    chapters = [demo._told(Chapter(name, (name, "{out}/x")), tmp_path) for name in codes]
    assert [code for _, code in chapters] == [1, 3, 0]
    assert chapters[0][0] == f"$ springpot one {tmp_path}/x\n\nanswer\n"
    told = iter(chapters)
    monkeypatch.setattr(demo, "_told", lambda chapter, out: next(told))
    chosen = SimpleNamespace(items=lambda kind: [WORDS] * 3)
    monkeypatch.setattr(registry, "plugins", lambda: chosen)
    assert demo.command.callback(tmp_path, False) == 3


def test_without_chapters_there_is_no_demonstration(story):
    answer, _ = story()
    assert answer.is_one_line("there is no demonstration")
