"""``springpot diagnose``, ``discover``, ``compare`` and ``demo``.

What they print, write and refuse.
"""

import json
from time import sleep

import numpy as np
import pytest

import springpot as library

pytestmark = pytest.mark.usefixtures("asked_once", "unpainted")

OMEGA = 2.0 * np.pi * np.geomspace(0.5, 100.0, 24)
CANDIDATE = {
    "effect",
    "class",
    "probability",
    "delta_bic",
    "score",
    "verdict",
    "predicted_error",
    "error_after",
    "parameters",
    "says",
}


def table(stiffness, header="frequency [Hz],storage [kN/m],loss [kN/m]"):
    rows = [
        f"{w / (2 * np.pi)!r},{k.real!r},{k.imag!r}"
        for w, k in zip(OMEGA.tolist(), stiffness.tolist(), strict=True)
    ]
    return "\n".join([header, *rows]) + "\n"


def damper(mass=0.0, delay=0.0, seed=7):
    """A fractional Maxwell damper on a rig, with 1 % noise."""
    s = 1j * OMEGA
    exact = (1.0 / (1.0 / 400.0 + 1.0 / (60.0 * s**0.5)) + mass * s**2) * np.exp(-delay * s)
    rng = np.random.default_rng(seed)
    return exact * (1 + 0.01 * (rng.normal(size=len(s)) + 1j * rng.normal(size=len(s))))


@pytest.fixture
def heavy(write):
    return write(table(damper(mass=6e-4)), "heavy.csv")


@pytest.fixture
def sound(write):
    return write(table(damper()), "sound.csv")


@pytest.mark.soak
def test_json_is_as_agreed(springpot, heavy):
    answer = springpot("diagnose", heavy, "--model", "fractional-maxwell", "--json").json
    assert answer["schema"] == "springpot.diagnosis/2"
    assert (answer["data"], answer["model"]) == ("heavy", "fractional-maxwell")
    assert set(answer["error"]) >= {"relative_rms", "noise_floor", "noise_source"}
    assert answer["error"]["noise_source"] == "estimated"
    assert (
        answer["error"]["noise_floor"]
        < answer["error"]["material_floor"]
        < answer["error"]["relative_rms"]
    )
    assert answer["error"]["material_chance"] < 0.005
    assert answer["verdict"] == "effect-missing"
    assert set(answer["where"][0]) >= {"plane", "condition", "from", "to", "size", "says"}
    best = answer["candidates"][0]
    assert set(best) >= CANDIDATE
    assert (best["effect"], best["verdict"]) == ("inertia", "missing")
    mass = best["parameters"]["m"]
    assert mass["unit"] == "kg"
    assert mass["low"] < mass["value"] < mass["high"]
    assert mass["value"] == pytest.approx(0.6, rel=0.1)
    assert {row["verdict"] for row in answer["candidates"]} <= {"missing", "absent", "cannot-tell"}
    assert best["error_after"] < 0.1 * answer["error"]["relative_rms"]
    assert "inertia" in answer["classes"][0]


def test_text_begins_with_the_verdict_and_ends_with_advice(springpot, heavy):
    answer = springpot("diagnose", heavy, "--model", "fractional-maxwell")
    assert answer.code == 0
    lines = answer.out.splitlines()
    assert lines[0] == "fractional-maxwell of heavy: effect-missing"
    assert "missing is inertia" in lines[1]
    [error] = [line for line in lines if line.startswith("error ")]
    assert " -> " in error
    assert "with inertia" in error
    assert "x floor; noise floor " in error
    assert "% (estimated); material floor " in error
    assert lines[lines.index(error) + 1].startswith(
        ("a material could be at ", "any linear material would be ")
    )
    assert "where it fails:" in lines
    [row] = [line for line in lines if line.startswith("inertia ")]
    assert " kg" in row


@pytest.mark.soak
def test_nothing_missing_is_said_plainly(springpot, sound):
    answer = springpot("diagnose", sound, "--model", "fractional-maxwell")
    assert "nothing is missing down to the noise floor" in answer.out
    assert "absent, or it would have been seen" in answer.out


def test_several_files_give_json_lines_and_a_bad_one_stops_nobody(
    springpot, heavy, sound, tmp_path
):
    answer = springpot(
        "diagnose", heavy, tmp_path / "no.csv", sound, "-m", "fractional-maxwell", "--json"
    )
    assert answer.code == 2
    # On a busy machine what is being done is told too.
    [line] = [line for line in answer.err.splitlines() if line.startswith("springpot: ")]
    assert "no.csv" in line
    lines = [json.loads(line) for line in answer.out.splitlines()]
    assert [line["data"] for line in lines] == ["heavy", "sound"]
    assert [line["verdict"] for line in lines] == ["effect-missing", "adequate"]


def test_the_same_seed_gives_the_same_bits(springpot, heavy, monkeypatch):
    few = "--effects", "inertia,time-delay,series-spring"
    asked = "diagnose", heavy, "-m", "fractional-maxwell", *few, "--json"
    first = springpot(*asked)
    monkeypatch.undo()  # this one is worked out, whatever is remembered
    again = springpot(*asked, "--seed", "0")
    assert first.out == again.out


@pytest.mark.soak_cases("way0")
@pytest.mark.parametrize("way", [("--accept", "inertia"), ("--auto",)])
def test_the_error_falls_to_the_floor(springpot, heavy, way):
    answer = springpot("discover", heavy, "--model", "fractional-maxwell", *way, "--json").json
    assert answer["schema"] == "springpot.discovery/2"
    first, last = answer["steps"]
    assert set(first) >= {"model", "accepted", "relative_rms", "noise_floor", "predicted_error"}
    assert first["material_floor"] > 3.0 * last["material_floor"]
    assert first["material_chance"] < 0.005 < last["material_chance"]
    assert (first["accepted"], first["predicted_error"]) == (None, None)
    assert (last["accepted"], last["model"]) == ("inertia", "fractional-maxwell + inertia")
    assert last["relative_rms"] / last["noise_floor"] == pytest.approx(1.0, abs=0.1)
    assert answer["verdict"] == "adequate"
    assert answer["diagnosis"]["model"] == last["model"]


@pytest.mark.soak_cases("effects0", "effects1")
@pytest.mark.parametrize(
    "effects",
    [("--accept", "inertia", "--accept", "time-delay"), ("--accept", "inertia", "time-delay")],
)
def test_effects_are_accepted_in_the_given_order(springpot, write, effects):
    data = write(table(damper(mass=6e-4, delay=4e-4)))
    answer = springpot("discover", data, "--model", "fractional-maxwell", *effects)
    assert "fractional-maxwell + inertia + time-delay" in answer.out
    assert "+ time-delay changed" in answer.out
    assert "time-delay.tau" in answer.out


@pytest.mark.soak
def test_report_and_figure_are_written(springpot, heavy, tmp_path):
    pytest.importorskip("matplotlib")
    report, figure = tmp_path / "a.html", tmp_path / "a.png"
    answer = springpot(
        "discover",
        heavy,
        "-m",
        "fractional-maxwell",
        "--accept",
        "inertia",
        "--report",
        report,
        "--figure",
        figure,
    )
    assert answer.code == 0
    assert str(report) in answer.out
    assert report.read_text(encoding="utf-8").endswith("</html>\n")
    assert figure.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("--auto", "--accept")),
        (("--auto", "--accept", "inertia"), ("--auto", "--accept")),
        (("--accept", "inertai"), ("unknown effect", "inertia")),
        (("--auto", "--report", "a.txt"), (".html",)),
        (("--auto", "--report", "no/a.html"), ("no folder",)),
        (("--auto", "--figure", "a.bmp"), (".png",)),
        (("--accept", "friction"), ("amplitude",)),
    ],
)
def test_what_discover_cannot_do_is_one_line(springpot, heavy, arguments, words):
    springpot("discover", heavy, "-m", "fractional-maxwell", *arguments).is_one_line(*words)


@pytest.mark.parametrize("command", [("diagnose",), ("discover", "--auto"), ("compare",)])
def test_too_few_points_is_one_line(springpot, write, command):
    data = write("frequency [Hz],storage [kN/m],loss [kN/m]\n1,2,3\n")
    springpot(command[0], data, *command[1:], "-m", "fractional-zener").is_one_line(
        "point", "parameters"
    )


@pytest.mark.soak
def test_models_are_compared_in_text_json_and_figure(springpot, heavy, tmp_path):
    pytest.importorskip("matplotlib")
    models = ("-m", "fractional-maxwell", "-m", "fractional-maxwell + inertia")
    answer = springpot("compare", heavy, *models, "--json").json
    assert [model["fails"] for model in answer["models"]] == [True, False]
    assert answer["best"] == "fractional-maxwell + inertia"
    figure = tmp_path / "a.svg"
    text = springpot("compare", heavy, *models, "--figure", figure)
    assert "fractional-maxwell + inertia holds" in text.out
    assert "fractional-maxwell fails" in text.out
    assert figure.read_bytes().endswith(b"</svg>\n")


@pytest.mark.soak
def test_without_a_model_any_material_is_judged(springpot, heavy):
    few = ("--effects", "inertia,time-delay,series-spring")
    answer = springpot("diagnose", heavy, *few, "--json").json
    assert answer["model"] == "material"
    floor = pytest.approx(answer["error"]["material_floor"], rel=1e-12)
    assert answer["error"]["relative_rms"] == floor
    assert answer["candidates"][0]["effect"] == "inertia"
    named = springpot("diagnose", heavy, "-m", "material", *few, "--json").json
    assert named["candidates"] == answer["candidates"]
    ladder = springpot("discover", heavy, *few, "--auto", "--json").json
    assert [step["model"] for step in ladder["steps"]] == ["material", "material + inertia"]
    text = springpot("discover", heavy, *few, "--auto").out
    assert text.splitlines()[2].split("  ")[-1] == "material floor"


@pytest.mark.soak
def test_a_report_without_a_model_tells_how_to_get_it_again(springpot, heavy, tmp_path):
    pytest.importorskip("matplotlib")
    report = tmp_path / "a.html"
    springpot("discover", heavy, "--auto", "--report", report)
    page = report.read_text(encoding="utf-8")
    assert "--model" not in page
    assert "What is missing from material?" in page
    assert "<b>" in page
    assert "material floor" in page


@pytest.mark.soak
def test_without_models_the_installed_ones_are_ranked(springpot, heavy, undrawn, tmp_path):
    answer = springpot("compare", heavy, "--json")
    row = answer.json
    assert row["best"] == row["ranking"]["adequate"][0] == "fractional-maxwell + inertia"
    assert row["ranking"]["accepted"] == ["inertia"]
    names = [model["model"] for model in row["models"]]
    # All beside the same effects, the hopeless ones too.
    assert {"springpot + inertia", "prony-2 + inertia"} <= set(names)
    assert not {"material", "material + inertia"} & set(names)
    assert {"material_floor", "material_chance"} <= set(row["models"][0]["error"])
    text = springpot("compare", heavy, "--figure", tmp_path / "a.png").out
    ranking = library.compare(library.read(heavy))
    assert ranking.best.model.name == "fractional-maxwell + inertia"
    assert len(repr(ranking)) < 600
    page = ranking._repr_html_()
    assert ranking.says in page
    assert page.count("<tr>") == 1 + len(ranking.shown)
    assert text.splitlines()[0].endswith("any material does is fractional-maxwell + inertia")
    assert "springpot + inertia  " not in text  # hopeless ones are in JSON only
    [figure] = undrawn
    assert (tmp_path / "a.png").is_file()
    assert all(axes.lines for axes in figure.axes[:2])


@pytest.mark.soak
def test_rows_of_several_tests_are_compared_one_by_one(springpot, write):
    omega, current = np.tile(OMEGA[::4], 3), np.repeat([0.0, 1.0, 2.0], len(OMEGA[::4]))
    loss = 0.5 * omega * (1.0 + 4.0 * current)
    rows = zip((omega / 2 / np.pi).tolist(), loss.tolist(), current.tolist(), strict=True)
    lines = [f"{f!r},20.0,{k!r},{i!r}" for f, k, i in rows]
    path = write(
        "\n".join(["frequency [Hz],storage [kN/m],loss [kN/m],current [A]", *lines]) + "\n",
        "mr.csv",
    )
    last = springpot("compare", path, "-m", "kelvin", "-m", "maxwell").out.splitlines()[-1]
    assert last == f"next: springpot compare {path}@current=0 --model kelvin --model maxwell"
    chosen = springpot("compare", f"{path}@current=0", "-m", "kelvin", "-m", "maxwell")
    assert chosen.out.splitlines()[-1].endswith("--model kelvin")


def test_who_waits_is_told_why(capsys, monkeypatch):
    from springpot.cli import hints

    monkeypatch.setattr(hints, "PATIENCE", 0.01)
    with hints.Waiting() as told:
        told.told("looking here")
        while not told._begun:
            sleep(0.01)
        told.told("fitting model 1 of 2")
        told.told("fitting model 2 of 2")
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines()[-1].startswith("fitting model ")
    assert len(err.splitlines()) <= 2
    monkeypatch.setattr(hints, "PATIENCE", 60.0)
    with hints.Waiting() as told:
        told.told("looking here")
    assert capsys.readouterr().err == ""


@pytest.mark.soak
def test_the_demonstration_tells_its_whole_story(springpot, undrawn, tmp_path, monkeypatch):
    from springpot import api
    from springpot.api import library as effects_of
    from springpot.benchmark.commands import demo

    monkeypatch.setattr(demo, "_run", lambda race, out: f"{race.name} of {len(race.optimisers)}\n")
    few = effects_of(only=["inertia", "time-delay", "wlf-shift"])
    monkeypatch.setattr(api, "library", lambda *given: few)
    answer = springpot("demo", "--out", tmp_path / "story")
    assert answer.code == 0, answer.err
    assert {path.name for path in (tmp_path / "story").iterdir()} >= {
        "ladder.png",
        "report.html",
        "story.txt",
    }
    assert "fractional-maxwell + inertia + time-delay" in answer.out
    last = "$ springpot workbench artificial-hidden --model fractional-maxwell"
    assert last in answer.out.splitlines()[-3:]  # told, not run
    assert undrawn
    assert "race of 5" in (tmp_path / "story" / "story.txt").read_text(encoding="utf-8")


@pytest.mark.soak
def test_the_race_of_the_demonstration_runs(tmp_path):
    from springpot.benchmark.commands.demo import _run
    from springpot.hooks import Race

    text = _run(
        Race(
            "small", ("artificial-fractional-kelvin",), ("native", "random-search"), "paper", 2, 60
        ),
        tmp_path,
    )
    assert "random-search" in text
    assert (tmp_path / "small" / "small.sqlite").exists()


@pytest.mark.soak
def test_in_python_names_are_enough(heavy):
    import springpot

    data = springpot.read(heavy)
    diagnosis = springpot.diagnose(data, "fractional-maxwell")
    assert diagnosis.best.effect == "inertia"
    ladder = springpot.discover(data, diagnosis.model, accept=[diagnosis.best.effect])
    assert ladder.model.name == (diagnosis.model + "inertia").name
    assert "<td>inertia</td>" in diagnosis._repr_html_().replace(' data-label="effect"', "")
    assert "adequate" in ladder._repr_html_()


@pytest.mark.soak
def test_an_effect_of_the_users_own_takes_part(heavy):
    import springpot
    from springpot.rheology import Effect, Layer, mass, parallel

    mine = Effect(
        "my-flywheel",
        parallel,
        mass("m"),
        "a flywheel turns with the piston",
        Layer.MOUNTING,
        "none",
    )
    diagnosis = springpot.diagnose(springpot.read(heavy), "fractional-maxwell", effects=[mine])
    [row] = [row for row in diagnosis.candidates if row.effect == "my-flywheel"]
    assert "inertia" in row.alike
    assert row.error_after == pytest.approx(diagnosis.candidates[0].error_after, rel=1e-3)


def test_a_ladder_is_a_picture(heavy, tmp_path):
    pytest.importorskip("matplotlib")
    import springpot

    ladder = springpot.discover(springpot.read(heavy), "fractional-maxwell", accept=["inertia"])
    assert ladder.plot(tmp_path / "a.svg").read_bytes().endswith(b"</svg>\n")
    [axes] = ladder.plot().axes
    assert axes.get_yscale() == "log"
    [line] = [line for line in axes.lines if line.get_label() == "error"]
    np.testing.assert_allclose(line.get_ydata(), [100 * step.relative_rms for step in ladder.steps])
    [third] = [lines for lines in axes.collections if lines.get_label() == "material floor"]
    levels = [segment[0, 1] for segment in third.get_segments()]
    np.testing.assert_allclose(levels, [100 * step.material_floor for step in ladder.steps])
    assert "material floor" in [text.get_text() for text in axes.get_legend().get_texts()]


def test_a_stage_that_is_told_keeps_no_process_alive():
    from springpot.cli import hints

    assert hints.Waiting()._thread.daemon
