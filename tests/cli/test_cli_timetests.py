"""Tests in time on the command line: inspect and identify."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from springpot.registry import parse_model

pytestmark = pytest.mark.usefixtures("asked_once")

MODEL = parse_model("fractional-maxwell")
THETA = MODEL.theta(k=400.0, c=60.0, alpha=0.5)
T = np.geomspace(0.02, 50.0, 120)


def table(header, values, seed):
    scatter = 1.0 + 0.01 * np.random.default_rng(seed).normal(size=len(T))
    return (
        header
        + "\n"
        + "".join(
            f"{t!r},{v!r}\n" for t, v in zip(T.tolist(), (values * scatter).tolist(), strict=True)
        )
    )


@pytest.fixture
def relaxed(write):
    return write(
        table("time [s],relaxation [kPa]", MODEL.relaxation(THETA, T), 1), "relaxation.csv"
    )


@pytest.fixture
def crept(write):
    return write(table("time [s],compliance [1/MPa]", 1e3 * MODEL.creep(THETA, T), 2), "creep.csv")


@pytest.fixture
def swept(write):
    omega = np.geomspace(0.1, 30.0, 20)
    k = MODEL.stiffness(THETA, omega)
    rows = "".join(f"{w},{a.real},{a.imag}\n" for w, a in zip(omega, k, strict=True))
    return write(f"omega [rad/s],storage [kPa],loss [kPa]\n{rows}", "sweep.csv")


def test_inspect_says_what_was_understood(springpot, relaxed):
    answer = springpot("inspect", relaxed, "--json").json
    [test] = answer["tests"]
    assert (test["kind"], test["points"], test["imposed"]) == ("relaxation", 120, "displacement")
    assert test["noise"]["relative"] == pytest.approx(0.01, rel=0.4)
    shown = springpot("inspect", relaxed).out
    assert "relaxation: relaxation, 120 points" in shown
    assert "kPa" in shown


@pytest.mark.soak
def test_a_delay_of_the_sweep_is_fitted_beside_a_relaxation(springpot, swept, relaxed):
    expression = "fractional-maxwell + inertia + time-delay"
    answer = springpot("identify", swept, relaxed, "--model", expression, "--json").json
    assert answer["parameters"]["k"]["value"] == pytest.approx(400.0, rel=0.02)
    assert answer["kept"]["only_sweeps"] == ["time-delay"]


def test_identify_from_one_test(springpot, relaxed):
    answer = springpot("identify", relaxed, "--model", "fractional-maxwell", "--json").json
    assert answer["schema"] == "springpot.identification/2"
    assert answer["parameters"]["k"]["low"] < 400.0 < answer["parameters"]["k"]["high"]
    assert answer["tests"][0]["over_floor"] == pytest.approx(1.0, abs=0.25)
    assert np.array(answer["covariance"]).shape == (3, 3)


@pytest.mark.soak
def test_identify_from_all_tests_of_a_specimen(springpot, relaxed, crept, swept, tmp_path):
    figure = tmp_path / "tests.png"
    answer = springpot(
        "identify", swept, relaxed, crept, "-m", "fractional-maxwell", "--figure", figure
    )
    assert answer.code == 0, answer.err
    for word in ("3 tests", "sweep", "relaxation", "creep", "alone: x floor where"):
        assert word in answer.out
    assert figure.stat().st_size > 10_000


@pytest.fixture
def fit(springpot, relaxed, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(springpot("identify", relaxed, "-m", "fractional-maxwell", "--json").out)
    return path


@pytest.mark.soak
def test_predict_says_whether_it_holds(springpot, fit, crept, swept, tmp_path):
    table, picture = tmp_path / "predicted.csv", tmp_path / "predicted.png"
    told = springpot("predict", fit, "--history", crept, "-o", table, "--figure", picture)
    assert told.code == 0, told.err
    assert "the prediction of creep holds" in told.out
    assert table.read_text().startswith(
        "time [s],stress [MPa],strain [-],strain_low [-],strain_high [-],strain_measured [-],"
        "measured [text]\n"
    )
    assert "creep" in springpot("inspect", table).out
    assert picture.stat().st_size > 5_000
    assert springpot("predict", fit, "--history", swept, "-o", table).code == 0
    ends = ("", "_low", "_high", "_measured")
    names = [f"{quantity}{end} [kPa]" for quantity in ("storage", "loss") for end in ends]
    head = table.read_text().partition("\n")[0].split(",")
    assert head[1:] == [*names, "measured [text]"]
    answer = springpot("predict", fit, "--history", swept, "--json").json
    assert (answer["kind"], answer["verdict"]) == ("sweep", "holds")


def test_predict_the_force_of_a_displacement_alone(springpot, fit, write, tmp_path):
    path = write("time [s],displacement [mm]\n0,0\n1,1\n2,0.5\n", "course.csv")
    springpot("predict", fit, "--history", path).is_one_line("a stiffness is no modulus")
    strained = write("time [s],strain [%]\n0,0\n1,1\n2,0.5\n", "strain.csv")
    answer = springpot("predict", fit, "--history", strained, "--json").json
    assert (answer["verdict"], answer["unit"], len(answer["points"])) == ("not-judged", "Pa", 3)


def test_predict_frequencies_from_a_test_in_time(springpot, fit):
    answer = springpot("predict", fit, "--frequency", "0.1,1", "--json").json
    exact = MODEL.stiffness(THETA, 2 * np.pi * np.array([0.1, 1.0]))
    assert [row["storage"] for row in answer["points"]] == pytest.approx(exact.real, rel=0.05)
    springpot("predict", fit, "--frequency", "1", "--history", "x.csv").is_one_line(
        "or a --history"
    )


def test_export_from_a_fit_to_tests_in_time(springpot, fit):
    assert (
        "uniaxialMaterial"
        in springpot(
            "export-model", fit, "--to", "opensees", "--band", "0.1Hz:1Hz", "--modulus", "young"
        ).out
    )


@pytest.mark.soak
def test_diagnose_judges_the_raw_signal(springpot, relaxed):
    answer = springpot("diagnose", relaxed, "-m", "fractional-maxwell", "--json").json
    assert answer["schema"] == "springpot.diagnosis/2"
    assert answer["verdict"] == "adequate"
    assert springpot("diagnose", relaxed, "--json").json["model"] == "material"


@pytest.mark.soak
def test_any_optimiser_may_search(springpot, relaxed, fit):
    found = springpot(
        "identify",
        relaxed,
        "-m",
        "fractional-maxwell",
        "--optimiser",
        "least-squares",
        "--budget",
        "300",
        "--json",
    ).json
    assert found["optimiser"] == "least-squares"
    assert found["evaluations"] <= 300
    native = json.loads(fit.read_text())
    assert found["objective"]["value"] == pytest.approx(native["objective"]["value"], rel=1e-4)
    told = springpot(
        "identify", relaxed, "-m", "fractional-maxwell", "--optimiser", "cma-es", "--budget", "20"
    )
    assert "cma-es, budget, 20 evaluations" in told.out
    assert "other tests" not in told.out


@pytest.mark.soak
def test_parameters_are_held_bounded_and_begun_at_as_in_sweeps(springpot, relaxed, crept):
    words = ["-m", "fractional-maxwell", "--fix", "alpha=0.5", "--bounds", "k=0:300"]
    told = springpot("identify", relaxed, crept, *words, "--start", "c=50", "--json").json
    assert set(told["parameters"]) >= {"k", "c"}
    assert told["parameters"]["k"]["value"] <= 300.0
    missing = springpot("diagnose", relaxed, *words, "--effects", "force-drift", "--json").json
    assert missing["verdict"] != "adequate"
    refused = ["identify", relaxed, "-m", "fractional-maxwell", "--fix"]
    springpot(*refused, "m=1").is_one_line("no free parameter 'm'")


@pytest.mark.soak
def test_samples_are_left_out_by_time_number_and_name(springpot, relaxed, crept):
    def points(*words):
        told = springpot("identify", relaxed, crept, "-m", "fractional-maxwell", *words, "--json")
        return {test["name"]: test["points"] for test in told.json["tests"]}

    whole = points()
    names = list(whole)
    early = points("--exclude", "time=..1")
    assert all(early[name] < whole[name] for name in names)
    assert points("--exclude", f"test={names[1]},row=1..3") == {
        names[0]: whole[names[0]],
        names[1]: whole[names[1]] - 3,
    }
    assert list(points("--exclude", f"test={names[1]}")) == names[:1]
    words = ["identify", relaxed, "-m", "fractional-maxwell", "--exclude"]
    springpot(*words, "frequency=1..2").is_one_line("no condition 'frequency'", "time")
    springpot(*words, "time=..1e9").is_one_line("nothing would be left")


def test_a_geometry_turns_a_test_in_time_as_it_does_a_sweep(springpot, relaxed):
    pads = ["--geometry", "shear-pads area=1cm^2 gap=1mm"]
    words = ["identify", relaxed, "-m", "fractional-maxwell", "--json"]
    material, damper = springpot(*words).json, springpot(*words, *pads).json
    before, after = material["parameters"]["k"], damper["parameters"]["k"]
    assert (before["unit"], after["unit"]) == ("kPa", "N/m")
    # K = G A / h: 1 kPa over 1 cm^2 and 1 mm is 100 N/m.
    assert after["value"] == pytest.approx(100.0 * before["value"], rel=1e-6)


def test_bad_input_is_one_line(springpot, write, swept):
    bad = write("time [s],force [N]\n1,2\n2,3\n", "bad.csv")
    springpot("identify", bad, "-m", "fractional-maxwell").is_one_line(
        "a force without a displacement", "bad.csv"
    )
    assert "sweep  " in springpot("identify", swept, swept, "-m", "fractional-maxwell").out


@pytest.mark.soak
def test_compare_ranks_models_of_tests_in_time(springpot, relaxed, crept, tmp_path):
    picture = tmp_path / "views.png"
    told = springpot(
        "compare",
        relaxed,
        "-m",
        "fractional-maxwell",
        "-m",
        "maxwell",
        "-m",
        "spring + payne",
        "--figure",
        picture,
    )
    assert told.code == 0, told.err
    assert "fractional-maxwell is best" in told.out
    assert "left out" in told.out
    assert "'payne'" in told.out
    assert picture.stat().st_size > 10_000
    answer = springpot("compare", crept, "-m", "maxwell", "-m", "fractional-maxwell", "--json").json
    assert answer["best"] == "fractional-maxwell"
    assert [one["delta_bic"] > 10 for one in answer["models"]] == [False, True]


@pytest.mark.soak
def test_discover_is_for_tests_in_time_too(springpot, relaxed):
    told = springpot("discover", relaxed, "-m", "fractional-kelvin", "--accept", "series-spring")
    assert told.code == 0, told.err
    assert "fractional-kelvin + series-spring" in told.out
    assert "x floor" in told.out
    held = ["-m", "fractional-kelvin", "--fix", "alpha=0.5", "--accept", "series-spring"]
    assert "k, c, series" not in springpot("discover", relaxed, *held).out


@pytest.mark.soak
def test_without_a_model_any_material_is_judged(springpot, relaxed):
    told = springpot("diagnose", relaxed)
    assert told.code == 0, told.err
    assert told.out.startswith("material of relaxation: adequate")


def test_of_several_tests_the_one_with_an_unknown_unit_is_named(springpot, relaxed, write):
    other = write("time [jiffy],compliance [1/MPa]\n0.1,1\n1,2\n10,3\n", "other.csv")
    told = springpot("identify", relaxed, other, "-m", "fractional-maxwell")
    told.is_one_line("other.csv", "unknown unit [jiffy] for time")


@pytest.mark.soak
def test_an_effect_of_the_test_itself_is_found_named_and_added(springpot, write):
    drifting = write(
        table("time [s],relaxation [kPa]", MODEL.relaxation(THETA, T) + 0.5 * T, 3), "drifting.csv"
    )
    answer = springpot("diagnose", drifting, "-m", "fractional-maxwell", "--json").json
    assert answer["verdict"] == "effect-missing"
    assert "force-drift" in answer["candidates"][0]["class"]
    shown = springpot("diagnose", drifting, "-m", "fractional-maxwell").out
    assert "force-drift: the zero of the force transducer drifts" in shown
    named = springpot("identify", drifting, "-m", "fractional-maxwell + force-drift", "--json").json
    assert named["parameters"]["force-drift.rate"]["value"] == pytest.approx(0.5, rel=0.1)
    ladder = springpot(
        "discover", drifting, "-m", "fractional-maxwell", "--accept", "force-drift", "--json"
    ).json
    assert ladder["verdict"] == "adequate"


def test_a_sweep_has_no_effect_of_a_test_in_time(springpot, swept):
    springpot("identify", swept, "-m", "fractional-maxwell + force-drift").is_one_line(
        "'force-drift'", "sweep"
    )
    springpot("diagnose", swept, "-m", "fractional-maxwell + force-drift").is_one_line(
        "'force-drift'", "sweep"
    )


def test_inspect_of_a_record_tells_both_ways_on(springpot, write):
    t = np.linspace(0.0, 2.0, 200)
    rows = "".join(
        f"{a!r},{b!r},{2 * b!r}\n" for a, b in zip(t.tolist(), np.sin(9 * t).tolist(), strict=True)
    )
    shown = springpot(
        "inspect", write(f"time [s],displacement [mm],force [N]\n{rows}", "record.csv")
    ).out
    assert "next: springpot diagnose " in shown
    assert "steadily: springpot signals " in shown


@pytest.mark.soak
def test_which_of_several_absent_effects_is_absent_is_no_news(springpot, relaxed):
    answer = springpot("diagnose", relaxed, "--model", "fractional-maxwell", "--json").json
    assert {each["verdict"] for each in answer["candidates"]} == {"absent"}
    assert (
        "cannot tell apart"
        not in springpot("diagnose", relaxed, "--model", "fractional-maxwell").out
    )


@pytest.mark.soak
def test_a_discovery_from_tests_in_time_is_reported_and_drawn_as_one_of_sweeps(
    springpot, relaxed, swept, tmp_path
):
    import springpot as package

    page = tmp_path / "story.html"
    few = ["series-spring", "force-drift"]
    words = ["-m", "fractional-kelvin", "--effects", ",".join(few), "--accept", few[0]]
    told = springpot("discover", relaxed, *words, "--report", page)
    assert told.code == 0, told.err
    text = page.read_text()
    for word in ("What is missing from fractional-kelvin?", "series-spring", "To repeat this"):
        assert word in text
    # The program of the page knows the word; its data and its sentences do not.
    shown = re.sub(r"(?s)<script(?! type=.application/json).*?</script>", "", text)
    assert len(shown) < len(text)
    assert not re.search(r"\bnan\b", shown.lower().replace("nanometer", ""))
    ladder = package.discover(relaxed, "fractional-kelvin", accept=few[0], only=few)
    compared = package.compare(relaxed, ["maxwell", "fractional-maxwell"])
    for i, answer in enumerate(
        (ladder, ladder.diagnosis, compared, ladder.steps[-1].examined.base)
    ):
        assert answer.plot(tmp_path / f"{i}.png").stat().st_size > 10_000
        assert "<" in answer._repr_html_()
        assert len(str(answer).splitlines()) > 2


def test_a_predicted_test_has_the_asked_band_and_geometry(springpot, relaxed, crept, tmp_path):
    fit = tmp_path / "fit.json"
    fit.write_text(springpot("identify", relaxed, "-m", "fractional-maxwell", "--json").out)
    words = ["predict", fit, "--history", crept, "--json"]
    usual, wide = springpot(*words).json, springpot(*words, "--level", "0.99").json
    assert (usual["level"], wide["level"]) == (0.95, 0.99)
    pads = ["--geometry", "shear-pads area=1cm^2 gap=1mm"]
    # The other side of a geometry is no modulus: it is looked through, and told.
    springpot(*words, *pads).is_one_line("N/m")
    told = springpot("predict", fit, "--frequency", "1", *pads)
    assert told.code == 2
    assert "--history" in told.err


def test_a_table_of_fits_and_an_inspection_heed_their_options(springpot, relaxed):
    header, row = springpot("identify", relaxed, "-m", "maxwell", "--csv").out.splitlines()
    assert header.startswith("data,model,relative_rms [-],noise_floor [-],good_enough,k [kPa]")
    assert row.startswith("relaxation,maxwell,")
    pads = ["--geometry", "shear-pads area=1cm^2 gap=1mm"]
    [test] = springpot("inspect", relaxed, *pads, "--json").json["tests"]
    assert test["stiffness_unit"] == "N/m"


def test_a_test_that_is_named_twice_is_no_second_one(springpot, relaxed, swept):
    told = springpot("identify", relaxed, swept, relaxed, "--model", "fractional-maxwell")
    assert told.is_one_line("relaxation and relaxation hold the same numbers")


def test_where_a_temperature_is_said_of_a_file(springpot, relaxed):
    """The hint names the file, and not the test."""
    told = springpot("identify", relaxed, "--model", "fractional-maxwell + wlf-shift")
    assert told.is_one_line("'relaxation.csv?temperature=25[degC]'")


def test_a_view_of_a_sweep_is_refused_for_a_test_in_time(springpot, relaxed):
    words = "--figure", relaxed.with_suffix(".png"), "--view", "residual"
    springpot("identify", relaxed, "-m", "maxwell", *words).is_one_line("--view", "leave it out")
    assert not relaxed.with_suffix(".png").exists()
