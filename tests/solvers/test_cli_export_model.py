"""``springpot export-model``: a fit in a solver's format, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from springpot import Measurement, identify
from springpot.registry import parse_model

pytestmark = pytest.mark.usefixtures("asked_once")

BAND = "1Hz:48Hz"


def test_a_fit_is_read_back_in_its_units(springpot, tmp_path):
    data = "nist-srm2491@temperature=20"
    fit = springpot("identify", data, "--model", "maxwell + parallel-dashpot", "--json").json
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit), encoding="utf-8")
    answer = springpot(
        "export-model", path, "--to", "csv", "--band", "1.0rad/s:1e2 rad/s", "--dashpot"
    )
    assert answer.code == 0, answer.err
    assert f"weight [{fit['parameters']['k']['unit']}]" in answer.out
    tau = fit["parameters"]["c"]["value"] / fit["parameters"]["k"]["value"]
    assert float(answer.out.splitlines()[-1].split(",")[2]) == pytest.approx(tau, rel=1e-6)


@pytest.mark.soak_cases("arguments10---dashpot")
@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["fractional-maxwell", "--to", "abaqsu", "--band", BAND], "did you mean abaqus"),
        (
            ["fractional-maxwell", "--to", "csv", "--band", BAND, "--set", "k=400"],
            "c, alpha missing",
        ),
        (["spring", "--to", "csv", "--band", "1:48", "--set", "k=1"], "such as 1Hz:48Hz"),
        (
            [
                "spring + inertia",
                "--to",
                "csv",
                "--band",
                BAND,
                "--set",
                "k=1",
                "--set",
                "inertia.m=1",
            ],
            "--without",
        ),
        (["spring", "--to", "csv", "--band", "48Hz:1Hz", "--set", "k=1"], "lower first"),
        (["spring", "--to", "csv", "--band", BAND, "--set", "k"], "NAME=VALUE"),
        (
            ["spring", "--to", "csv", "--band", BAND, "--set", "k=1", "--tolerance", "x"],
            "tolerance",
        ),
        (
            [
                "spring",
                "--to",
                "csv",
                "--band",
                BAND,
                "--set",
                "k=1",
                "--terms",
                "2",
                "--tolerance",
                "1%",
            ],
            "both",
        ),
        (["none.json", "--to", "csv", "--band", BAND], "none.json"),
        (["spring", "--to", "csv", "--band", BAND, "--set", "k=-1"], "k cannot be -1"),
        (["spring", "--to", "csv", "--band", BAND, "--set", "k=nan"], "k cannot be nan"),
        (["spring", "--to", "abaqus", "--band", BAND, "--set", "k=1", "--unit", "kN/m"], "modulus"),
        (["dashpot", "--to", "csv", "--band", BAND, "--set", "c=1"], "--dashpot"),
        (
            [
                "dashpot",
                "--to",
                "abaqus",
                "--band",
                BAND,
                "--set",
                "c=1",
                "--unit",
                "MPa",
                "--dashpot",
            ],
            "no place for",
        ),
    ],
)
def test_bad_input_is_one_line(springpot, arguments: list[str], word: str):
    assert springpot("export-model", *arguments).is_one_line(word)


MATERIAL = ("zener", {"k1": 2.0, "k2": 30.0, "c": 0.5})


def sweep_of(header: str, hertz=(1.0, 48.0), extra: str = "") -> str:
    """A sweep of `MATERIAL` with these titles of storage and loss."""
    model = parse_model(MATERIAL[0])
    f = np.geomspace(*hertz, 24)
    k = model.stiffness(model.theta(**MATERIAL[1]), 2 * np.pi * f)
    titles, cells = extra.partition("=")[::2]
    lines = [",".join(filter(None, ["frequency [Hz]", header, titles]))]
    for row in zip(f, k.real, k.imag, strict=True):
        lines.append(",".join(filter(None, [*map(repr, map(float, row)), cells])))
    return "\n".join(lines) + "\n"


@pytest.fixture
def fitted(springpot, write):
    def fit(header: str, *arguments: str, **changes) -> str:
        data = write(sweep_of(header, **changes), "sweep.csv")
        answer = springpot("identify", data, "--model", MATERIAL[0], "--json", *arguments)
        assert answer.code == 0, answer.err
        return write(answer.out, "fit.json")

    return fit


@pytest.mark.parametrize(
    ("header", "letter"),
    [
        ("G' [MPa],G'' [MPa]", "G"),
        ("E' [MPa],E'' [MPa]", "E"),
        ("Shear storage modulus [MPa],Shear loss modulus [MPa]", "G"),
        ("storage (bulk) [MPa],loss (bulk) [MPa]", "K"),
    ],
)
def test_the_card_has_the_modulus_that_was_measured(springpot, fitted, header: str, letter: str):
    """A shear modulus written as Young's would make a part 2.98 times too soft."""
    path = fitted(header)
    poisson = 0.49
    answer = springpot(
        "export-model", path, "--to", "abaqus", "--band", BAND, "--poisson", str(poisson)
    )
    assert answer.code == 0, answer.err
    whole = float(re.search(r"instantaneous ([\d.e+-]+)", answer.out)[1])
    young, nu = map(float, answer.out.partition("INSTANTANEOUS\n")[2].splitlines()[0].split(","))
    to_young = {"G": 2 * (1 + poisson), "E": 1.0, "K": 3 * (1 - 2 * poisson)}[letter]
    assert (young, nu) == (pytest.approx(to_young * whole, rel=1e-7), poisson)


def test_a_geometry_tells_the_modulus_and_a_stiffness_has_none(springpot, fitted):
    geometry = ["--geometry", "shear-pads area=200cm^2 gap=10mm"]
    path = fitted("storage [kN/m],loss [kN/m]", *geometry)
    told = springpot("export-model", path, "--to", "json", "--band", BAND, "--json").json
    assert told["modulus"] == "G"
    path = fitted("storage [kN/m],loss [kN/m]")
    told = springpot("export-model", path, "--to", "json", "--band", BAND, "--json").json
    assert told["modulus"] is None
    assert springpot(
        "export-model", path, "--to", "json", "--band", BAND, "--modulus", "shear"
    ).is_one_line("leave out --modulus")


def test_a_modulus_that_nobody_told_is_asked_for_in_one_line(springpot, fitted):
    path = fitted("storage [MPa],loss [MPa]")
    asked = ["export-model", path, "--to", "ansys", "--band", BAND, "--poisson", "0.49"]
    assert springpot(*asked).is_one_line("give --modulus shear, young or bulk")
    assert "told by the shear modulus" in springpot(*asked, "--modulus", "shear").out
    assert springpot(*asked, "--modulus", "soft").is_one_line("shear, young, bulk")
    assert springpot(*asked, "--modulus", "shear", "--bulk", "soft").is_one_line(
        "constant or relaxing"
    )


def test_what_a_user_says_of_the_modulus_must_agree_with_the_data(springpot, fitted):
    path = fitted("G' [MPa],G'' [MPa]")
    asked = ["export-model", path, "--to", "ansys", "--band", BAND, "--poisson", "0.49"]
    assert springpot(*asked, "--modulus", "young").is_one_line("is a shear modulus")


def test_a_card_states_what_was_measured_and_marks_what_lies_outside(springpot, fitted, tmp_path):
    """Twelve unmeasured decades were "largest error 0.474 %" without a word."""
    path = fitted("G' [MPa],G'' [MPa]", extra="temperature [degC]=25")
    inside = springpot("export-model", path, "--to", "csv", "--band", BAND)
    assert "measured: 1 to 48 Hz, temperature of 25 [degC]" in inside.out
    assert "outside" not in inside.out + inside.err
    far = springpot("export-model", path, "--to", "json", "--band", "1e-6Hz:1e6Hz")
    assert far.err.count("outside of what was measured") == 1
    assert "10 of 12 decades of the band" in far.err
    card = json.loads(far.out)
    assert any("10 of 12 decades" in line for line in card["heading"])
    low, high = card["measured_rad_per_s"]
    for term in card["terms"]:
        assert term["outside_measured"] == (not low <= 1.0 / term["time_s"] <= high)
    for name in ("abaqus", "ansys", "ls-dyna", "python", "comsol", "fmu"):
        wide = ["--to", name, "--band", "0.1Hz:480Hz", "--poisson", "0.49"]
        out = {"fmu": ["-o", tmp_path / "unit.fmu"]}.get(name, [])
        answer = springpot("export-model", path, *wide, *out)
        assert "outside of what was measured (1 to 48 Hz)" in answer.err
        assert out or "outside of what was measured (1 to 48 Hz)" in answer.out


def test_a_temperature_that_the_model_does_not_know_is_refused(springpot, fitted):
    path = fitted("G' [MPa],G'' [MPa]", extra="temperature [degC]=25")
    asked = ["export-model", path, "--to", "csv", "--band", BAND, "--temperature"]
    assert springpot(*asked, "25").code == 0
    assert springpot(*asked, "80").is_one_line("does not know temperature")


def test_what_is_no_fit_is_refused(springpot, write):
    for content in ("{}", "[1]", "{", '{"model": "spring", "parameters": {"k": 1}}'):
        answer = springpot(
            "export-model", write(content, "fit.json"), "--to", "csv", "--band", "1Hz:2Hz"
        )
        assert answer.is_one_line("with --json")


@pytest.mark.soak
def test_a_file_is_a_file_whatever_its_name_and_a_device_is_none(springpot, fitted, tmp_path):
    """It read: '/dev/zero', sign 1: this is no formula."""
    path = Path(fitted("G' [MPa],G'' [MPa]"))
    other = tmp_path / "kept"
    other.write_bytes(path.read_bytes())
    cards = [
        springpot("export-model", each, "--to", "csv", "--band", BAND) for each in (path, other)
    ]
    assert cards[0].code == cards[1].code == 0
    assert cards[0].out == cards[1].out
    springpot("export-model", "/dev/zero", "--to", "csv", "--band", BAND).is_one_line("device")


@pytest.mark.parametrize("given", [("--set", "k=1"), ("--unit", "kPa")])
def test_a_fit_has_parameters_and_units_of_its_own(springpot, fitted, given):
    """They were ignored: a card in MPa for whoever had asked for kPa."""
    path = fitted("G' [MPa],G'' [MPa]")
    refused = springpot("export-model", path, "--to", "csv", "--band", BAND, *given)
    refused.is_one_line(f"leave out {given[0]}")


@pytest.mark.soak
def test_a_fit_is_handed_over_at_its_own_reference_temperature(springpot, tmp_path):
    """Where shifts are one is where the data were, not 20 degC.

    Without a temperature that is meant.
    """
    fit = springpot(
        "identify", "nist-srm2491", "--model", "maxwell + arrhenius-shift", "--json"
    ).json
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit), encoding="utf-8")

    def handed(*temperature):
        arguments = ["--to", "json", "--band", "1rad/s:100rad/s", "--dashpot", *temperature]
        return springpot("export-model", path, *arguments).out

    reference = json.loads(handed())["parameters"]["temperature"].removesuffix(" degC")
    terms = json.loads(handed("--temperature", reference))["terms"]
    assert terms == json.loads(handed())["terms"]
    [term] = terms
    tau = fit["parameters"]["c"]["value"] / fit["parameters"]["k"]["value"]
    assert term["time_s"] == pytest.approx(tau, rel=1e-6)
    assert handed("--temperature", "50") != handed()
    assert "outside of what was measured" not in handed("--temperature", "20")
    assert "the temperature of 120 degC" in handed("--temperature", "120")


def test_a_card_is_of_one_material(springpot, tmp_path):
    omega, lot = np.tile([1.0, 3.0, 10.0], 2), np.repeat([1.0, 2.0], 3)
    data = Measurement(omega, lot * (5.0 + 1j * omega), conditions={"lot": lot})
    fit = identify(data, "kelvin", own={"k": "lot"})
    path = tmp_path / "lots.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    asked = "export-model", path, "--to", "csv", "--band", "1Hz:2Hz", "--dashpot"
    springpot(*asked).is_one_line("each lot has k of its own", "lot=1")
