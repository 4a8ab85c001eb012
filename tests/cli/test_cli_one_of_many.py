"""One file that cannot be used among many.

Told in one line, the others answered, exit code 2 at the end.
"""

import json

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("asked_once")

MODEL = ("--model", "fractional-maxwell")


@pytest.fixture
def empty(write):
    return write("", "empty.csv")


def told_of(answer, bad):
    """One line on stderr that names the bad file, and exit code 2."""
    assert answer.code == 2, answer.err
    lines = [line for line in answer.err.splitlines() if line.startswith("springpot: ")]
    assert len(lines) == 1
    assert bad.name in lines[0]
    return True


@pytest.mark.soak_cases("identify-model0", "diagnose-model1")
@pytest.mark.parametrize(
    ("command", "model"),
    [("identify", MODEL), ("diagnose", (*MODEL, "--effects", "inertia")), ("inspect", ())],
)
def test_an_empty_file_stops_no_other(springpot, damper, empty, write, command, model):
    other = write(damper.read_bytes(), "other.csv")
    answer = springpot(command, damper, empty, other, *model, "--json")
    assert told_of(answer, empty)
    assert [json.loads(line)["data"] for line in answer.out.splitlines()] == ["damper", "other"]


def signals(write, name, hertz):
    time = np.linspace(0.0, 4.0, 801)
    phase = 2.0 * np.pi * hertz * time
    rows = zip(
        time.tolist(), np.sin(phase).tolist(), (3.0 * np.sin(phase + 0.5)).tolist(), strict=True
    )
    header = "time [s],displacement [mm],force [kN]\n"
    return write(header + "".join(f"{t!r},{x!r},{f!r}\n" for t, x, f in rows), name)


def test_signals_of_many_go_on_past_one(springpot, write, empty, damper, tmp_path):
    first, last, table = (
        signals(write, "one.csv", 2.0),
        signals(write, "two.csv", 3.0),
        tmp_path / "out.csv",
    )
    answer = springpot("signals", first, empty, last, "-o", table, "--json")
    assert told_of(answer, empty)
    assert [row["file"] for row in json.loads(answer.out)["rows"]] == ["one", "two"]
    assert table.read_text(encoding="utf-8").count("one") > 0
    assert told_of(springpot("signals", damper, first), damper)
    assert springpot("signals", empty).is_one_line("empty.csv", "empty")


def test_a_joint_answer_lacks_none_of_its_tests(springpot, write, empty):
    """It would be another answer: nothing is printed but the line."""
    rows = "".join(f"{0.1 * 1.5**i!r},{400.0 * 1.5 ** (-0.3 * i)!r}\n" for i in range(18))
    pad = write("time [s],relaxation [kPa]\n" + rows, "pad.csv")
    assert springpot("identify", pad, empty, "--model", "springpot").is_one_line("empty.csv")


def test_text_of_several_is_parted_by_a_blank_line(springpot, damper, write):
    other = write(damper.read_bytes(), "other.csv")
    whole = springpot("inspect", damper, other)
    assert whole.code == 0
    alone = springpot("inspect", damper).out
    assert whole.out == f"{alone}\n{alone.replace('damper', 'other')}"
