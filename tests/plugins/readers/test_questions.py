"""What a file leaves open comes as questions; an answer typed behind its name opens the file."""

from __future__ import annotations

from pathlib import Path

import pytest

import springpot
from springpot.measurement import OpenQuestion, Question

ROWS = "".join(f"{i},{9 + i},{i}\n" for i in range(1, 9))
WARM = ROWS.replace("\n", ",293\n")
TIMES = "".join(f"{i / 200},{i % 100 - 50},{(i + 5) % 100 - 50}\n" for i in range(1000))
PARTS = "T = 20 °C\nf [Hz],G' [Pa],G'' [Pa]\n{0}\nT = 40 °C\nf [Hz],K' [N/mm],K'' [N/mm]\n{0}"
FILES = {
    "all units": ("f,G',G'',T\n" + WARM, ["unit"] * 4),
    "no names": (ROWS, ["meaning", "meaning", "meaning"]),
    "base of logarithms": ("frequency [Hz],log G' [Pa],log G'' [Pa]\n" + ROWS, ["base"]),
    "no frequency": ("T [°C],G' [Pa],G'' [Pa]\n" + ROWS, ["constant"]),
    "which channel": ("time [s],displacement [mm],signal\n" + TIMES, ["column"]),
    "parts of two kinds": (PARTS.format(ROWS), ["part"]),
}


def ask(path: Path, said: list[str]) -> OpenQuestion | None:
    """The question that is left when this much is said."""
    parts = [piece for piece in said if piece.startswith("#")]
    columns = [piece for piece in said if not piece.startswith("#")]
    spec = f"{path}{''.join(parts)}" + (f"?{','.join(columns)}" if columns else "")
    try:
        springpot.read(spec)
    except OpenQuestion as error:
        return error
    return None


@pytest.mark.parametrize("name", FILES)
def test_the_usual_answers_open_the_file(tmp_path: Path, name: str):
    text, kinds = FILES[name]
    path = tmp_path / "mine.csv"
    path.write_text(text, encoding="utf-8")
    asked = ask(path, [])
    assert asked is not None
    assert [question.kind for question in asked.questions] == kinds
    assert str(path) in str(asked), "the one line of the terminal names the file"
    usual = [next(iter(question.answers.values())) for question in asked.questions]
    assert ask(path, usual) is None


def test_another_answer_gives_other_numbers(tmp_path: Path):
    path = tmp_path / "mine.csv"
    path.write_text(FILES["all units"][0], encoding="utf-8")
    asked = ask(path, [])
    assert asked is not None
    assert [question.about for question in asked.questions] == [
        *("frequency", "storage", "loss", "temperature")
    ]
    usual = [next(iter(question.answers.values())) for question in asked.questions]
    said = [each.replace("=Pa", "=kPa") for each in usual]
    assert springpot.read(f"{path}?{','.join(said)}").units.stiffness == "kPa"


def test_a_column_without_a_known_name_is_left_out_until_somebody_says_what_it_is(tmp_path: Path):
    path = tmp_path / "mine.csv"
    path.write_text("frequency [Hz],A,B\n" + ROWS, encoding="utf-8")
    asked = ask(path, [])
    assert asked is not None
    assert [(question.about, question.kind) for question in asked.questions] == [
        ("A", "meaning"),
        ("B", "meaning"),
    ]
    assert {next(iter(question.answers)) for question in asked.questions} == {"ignore"}
    said = [asked.questions[0].answers["storage[Pa]"], asked.questions[1].answers["loss[Pa]"]]
    assert ask(path, said) is None


def test_a_question_as_json_keeps_the_order_of_its_answers():
    told = Question.of_unit("loss", "MPa", ["Pa", "MPa"]).to_dict()
    assert told["kind"] == "unit"
    assert told["answers"] == [
        {"answer": "MPa", "said": "loss=MPa"},
        {"answer": "Pa", "said": "loss=Pa"},
    ]
