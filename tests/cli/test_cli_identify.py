"""``springpot identify``: the same answer as text, JSON and figure."""

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("asked_once")

KEYS = {
    "schema",
    "model",
    "parameters",
    "search_parameters",
    "objective",
    "relative_rms",
    "evaluations",
    "seconds",
    "optimiser",
    "status",
    "notes",
}
TRUTH = {"k": 400.0, "c": 60.0, "alpha": 0.5}


def test_json_has_the_agreed_keys_and_the_right_answer(springpot, damper):
    answer = springpot("identify", damper, "--model", "fractional-maxwell", "--json").json
    assert set(answer) >= KEYS
    assert answer["schema"] == "springpot.identification/2"
    assert answer["model"] == "fractional-maxwell"
    assert set(answer["objective"]) == {"name", "value"}
    for name, value in TRUTH.items():
        entry = answer["parameters"][name]
        assert set(entry) >= {"value", "low", "high", "unit"}
        assert entry["value"] == pytest.approx(value, rel=1e-6)
    assert [answer["parameters"][name]["unit"] for name in TRUTH] == ["kN/m", "kN s^alpha/m", "-"]
    assert answer["relative_rms"] < 1e-8


def test_text_shows_parameters_units_and_the_network(springpot, damper):
    answer = springpot("identify", damper, "--model", "fractional-maxwell")
    assert (answer.code, answer.err) == (0, "")
    rows = {line.split()[0]: line for line in answer.out.splitlines() if line.split()}
    assert "fractional-maxwell fitted to damper (15 points, 0.500 to 50.0 Hz)" in answer.out
    assert rows["c"].endswith("kN s^alpha/m")
    assert "60.0" in rows["c"]
    assert "◇" in answer.out


def test_effects_are_found_in_their_own_units(springpot, write):
    frequency = np.geomspace(0.5, 50.0, 15)
    s = 2j * np.pi * frequency
    stiffness = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * s**0.5)) + 2.5e-3 * s**2
    rows = "\n".join(
        f"{f!r},{k.real!r},{k.imag!r}"
        for f, k in zip(frequency.tolist(), stiffness.tolist(), strict=True)
    )
    path = write(f"frequency [Hz],storage [kN/m],loss [kN/m]\n{rows}\n")
    answer = springpot("identify", path, "-m", "fractional-maxwell + inertia", "--json").json
    assert answer["model"] == "fractional-maxwell + inertia"
    assert answer["parameters"]["inertia.m"]["unit"] == "kg"
    assert answer["parameters"]["inertia.m"]["value"] == pytest.approx(2.5, rel=1e-6)


@pytest.mark.soak
def test_the_figure_is_written_whole(springpot, damper, tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "fit.svg"
    answer = springpot("identify", damper, "--model", "fractional-maxwell", "--figure", path)
    assert (answer.code, answer.err) == (0, "")
    assert str(path) in answer.out
    assert path.read_bytes().endswith(b"</svg>\n")


@pytest.mark.soak
def test_of_a_material_the_spectrum_is_told_in_words_json_and_picture(springpot, damper, tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "spectrum.png"
    answer = springpot("identify", damper, "--model", "material", "--figure", path)
    assert (answer.code, answer.err) == (0, "")
    rows = {line.split()[0]: line for line in answer.out.splitlines() if line.split()}
    assert {"K_e", "c", "error"} <= set(rows)
    assert rows["spectrum"].startswith("spectrum    half of the relaxing ")
    assert "[spectrum]" in answer.out
    assert path.read_bytes().startswith(b"\x89PNG")
    spectrum = springpot("identify", damper, "--model", "material", "--json").json["spectrum"]
    assert (
        len(spectrum["rates"])
        == len(spectrum["weights"])
        == len(spectrum["low"])
        == len(spectrum["high"])
    )
    assert spectrum["unit"] == "kN/m"
    # The relaxing stiffness of a fractional Maxwell element is its spring's, and is not all seen.
    assert 200.0 < spectrum["equilibrium"]["value"] + sum(spectrum["weights"]) < 500.0


def test_the_error_stands_beside_both_floors(springpot, write):
    rng = np.random.default_rng(5)
    frequency = np.geomspace(0.5, 50.0, 15)
    s = 2j * np.pi * frequency
    stiffness = (100.0 + 30.0 * s**0.4 + 5e-3 * s**2) * (
        1.0 + 0.01 * (rng.normal(size=15) + 1j * rng.normal(size=15))
    )
    rows = "\n".join(
        f"{f!r},{k.real!r},{k.imag!r}"
        for f, k in zip(frequency.tolist(), stiffness.tolist(), strict=True)
    )
    answer = springpot(
        "identify",
        write(f"frequency [Hz],storage [Pa],loss [Pa]\n{rows}\n"),
        "-m",
        "fractional-kelvin",
    )
    [error] = [line for line in answer.out.splitlines() if line.startswith("error ")]
    assert " x the noise floor of " in error
    assert error.partition("; material floor ")[2].endswith(" %")


def test_no_optimiser_searches_a_spectrum(springpot, damper):
    springpot("identify", damper, "-m", "material", "--optimiser", "pso-paper").is_one_line(
        "spectrum", "optimiser"
    )


@pytest.mark.suite_cases("native")
@pytest.mark.parametrize("optimiser", ["pso-paper", "least-squares", "native"])
def test_an_optimiser_can_be_chosen_and_keeps_its_budget(springpot, damper, optimiser):
    options = ("--optimiser", optimiser, "--objective", "paper", "--budget", "300", "--seed", "4")
    answer = springpot("identify", damper, "--model", "fractional-maxwell", *options, "--json").json
    assert answer["optimiser"] == optimiser
    assert answer["objective"]["name"] == "paper"
    assert answer["evaluations"] <= 300 or optimiser == "native"
    again = springpot("identify", damper, "--model", "fractional-maxwell", *options, "--json").json
    assert again["parameters"] == answer["parameters"]


@pytest.mark.soak_cases("profile")
@pytest.mark.parametrize("intervals", ["jacobian", "profile", "bootstrap"])
def test_intervals_hold_the_value(springpot, write, intervals):
    rng = np.random.default_rng(5)
    frequency = np.geomspace(0.5, 50.0, 15)
    stiffness = 100.0 + 30.0 * (2j * np.pi * frequency) ** 0.4
    stiffness *= 1.0 + 0.01 * (rng.normal(size=15) + 1j * rng.normal(size=15))
    rows = "\n".join(
        f"{f!r},{k.real!r},{k.imag!r}"
        for f, k in zip(frequency.tolist(), stiffness.tolist(), strict=True)
    )
    path = write(f"frequency [Hz],storage [Pa],loss [Pa]\n{rows}\n")
    answer = springpot(
        "identify", path, "-m", "fractional-kelvin", "--intervals", intervals, "--json"
    ).json
    for name, truth in {"k": 100.0, "c": 30.0, "alpha": 0.4}.items():
        entry = answer["parameters"][name]
        assert entry["low"] < entry["value"] < entry["high"]
        assert abs(entry["value"] - truth) < 2 * (entry["high"] - entry["low"])


@pytest.mark.soak
def test_shift_constants_come_with_their_reference_temperature(springpot, write):
    frequency, celsius = np.tile(np.geomspace(0.5, 50.0, 12), 3), np.repeat([5.0, 25.0, 45.0], 12)
    s = 2j * np.pi * frequency * np.exp(50.0 / 8.314e-3 * (1.0 / (celsius + 273.15) - 1.0 / 298.15))
    stiffness = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * s**0.5))
    columns = zip(
        frequency.tolist(),
        stiffness.real.tolist(),
        stiffness.imag.tolist(),
        celsius.tolist(),
        strict=True,
    )
    rows = "\n".join(",".join(map(repr, row)) for row in columns)
    path = write(f"frequency [Hz],storage [Pa],loss [Pa],temperature [degC]\n{rows}\n")
    told = "shift constants refer to T_ref = 25 °C"
    assert told in springpot("identify", path, "-m", "fractional-maxwell + arrhenius-shift").out
    assert told in springpot("diagnose", path, "-m", "fractional-maxwell").out
    assert told not in springpot("identify", path, "-m", "fractional-maxwell").out
