"""What a person who types something not quite right, or looks for a catch, is told."""

import pytest

pytestmark = pytest.mark.usefixtures("asked_once")

MAXWELL = ("--model", "fractional-maxwell")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["regression"], ["check", "update", "regression --help"]),
        (["identify", "{damper}", "--model", "inertia"], ["is an effect", "MODEL + inertia"]),
        (["discover", "{damper}", *MAXWELL, "--auto", "--accept", "inertia"], ["not both"]),
        (["discover", "{damper}", *MAXWELL], ["--auto", "--accept EFFECT"]),
        (["demo", "--out", "{damper}"], ["damper.csv", "is a file"]),
    ],
)
def test_a_slip_is_answered_with_how_to_mend_it(springpot, damper, arguments, words):
    answer = springpot(*(argument.format(damper=damper) for argument in arguments))
    assert answer.is_one_line(*words)


@pytest.mark.soak
def test_discovery_says_what_an_accepted_effect_may_be_as_well(springpot):
    answer = springpot("discover", "artificial-hidden", *MAXWELL, "--auto")
    assert answer.code == 0, answer.err
    said = [line for line in answer.out.splitlines() if "may as well be" in line]
    steps = springpot("discover", "artificial-hidden", *MAXWELL, "--auto", "--json").json["steps"]
    doubtful = [step["accepted"] for step in steps if len(step["class"]) > 1]
    assert doubtful
    assert [line.split()[1] for line in said] == doubtful


def test_large_numbers_are_written_out():
    from springpot.misfit.error import plain

    assert [plain(value, 2) for value in (890.4, 12.0, 0.05, 1234.0, 3e7)] == [
        "890",
        "12",
        "0.05",
        "1200",
        "3e+07",
    ]


def test_tables_of_a_run_are_named_once(springpot, tmp_path):
    script = tmp_path / "tiny.py"
    script.write_text(
        "from springpot.benchmark import Study\n"
        "study = Study('tiny', datasets=['artificial-springpot'], models=['own'],"
        " objectives=['paper'],\n"
        "              optimisers=['native'], repetitions=1, budget=100)\n"
    )
    answer = springpot("run", script, "--engine", "serial", "--quiet", "--out", tmp_path)
    assert answer.code == 0, answer.err
    lines = answer.out.splitlines()
    assert len(lines) == 3
    assert "summary" in lines[1]
    assert ".md" in lines[1]
    assert lines[2] == f"report: {tmp_path / 'tiny' / 'report.html'}"
