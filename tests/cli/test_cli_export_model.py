"""``springpot export-model``: a fit in a solver's format, and what is refused."""

from __future__ import annotations

import json

import pytest

BAND = "1Hz:48Hz"


def test_a_fit_is_read_back_in_its_units(springpot, tmp_path):
    data = "nist-srm2491@temperature=20"
    fit = springpot("identify", data, "--model", "maxwell + parallel-dashpot", "--json").json
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit), encoding="utf-8")
    answer = springpot("export-model", path, "--to", "csv", "--band", "1.0rad/s:1e2 rad/s", "--dashpot")
    assert answer.code == 0, answer.err
    assert f"weight [{fit['parameters']['k']['unit']}]" in answer.out
    tau = fit["parameters"]["c"]["value"] / fit["parameters"]["k"]["value"]
    assert float(answer.out.splitlines()[-1].split(",")[2]) == pytest.approx(tau, rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["fractional-maxwell", "--to", "abaqsu", "--band", BAND], "did you mean abaqus"),
        (["fractional-maxwell", "--to", "csv", "--band", BAND, "--set", "k=400"], "c, alpha missing"),
        (["spring", "--to", "csv", "--band", "1:48", "--set", "k=1"], "such as 1Hz:48Hz"),
        (
            ["spring + inertia", "--to", "csv", "--band", BAND, "--set", "k=1", "--set", "inertia.m=1"],
            "--without",
        ),
        (["spring", "--to", "csv", "--band", "48Hz:1Hz", "--set", "k=1"], "lower first"),
        (["spring", "--to", "csv", "--band", BAND, "--set", "k"], "NAME=VALUE"),
        (["spring", "--to", "csv", "--band", BAND, "--set", "k=1", "--tolerance", "x"], "tolerance"),
        (
            ["spring", "--to", "csv", "--band", BAND, "--set", "k=1", "--terms", "2", "--tolerance", "1%"],
            "both",
        ),
        (["none.json", "--to", "csv", "--band", BAND], "none.json"),
        (["spring", "--to", "abaqus", "--band", BAND, "--set", "k=1", "--unit", "kN/m"], "modulus"),
        (["dashpot", "--to", "csv", "--band", BAND, "--set", "c=1"], "--dashpot"),
        (["dashpot", "--to", "abaqus", "--band", BAND, "--set", "c=1", "--unit", "MPa", "--dashpot"], "no place for"),
    ],
)
def test_bad_input_is_one_line(springpot, arguments: list[str], word: str):
    assert springpot("export-model", *arguments).is_one_line(word)


def test_what_is_no_fit_is_refused(springpot, write):
    for content in ("{}", "[1]", "{", '{"model": "spring", "parameters": {"k": 1}}'):
        answer = springpot("export-model", write(content, "fit.json"), "--to", "csv", "--band", "1Hz:2Hz")
        assert answer.is_one_line("with --json")


def test_a_fit_is_handed_over_at_its_own_reference_temperature(springpot, tmp_path):
    """Where shifts are one is where the data were, not 20 degC; without a temperature that is meant."""
    fit = springpot("identify", "nist-srm2491", "--model", "maxwell + arrhenius-shift", "--json").json
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit), encoding="utf-8")

    def handed(*temperature):
        arguments = ["--to", "json", "--band", "1rad/s:100rad/s", "--dashpot", *temperature]
        return springpot("export-model", path, *arguments).out

    reference = json.loads(handed())["parameters"]["temperature"].removesuffix(" degC")
    assert handed("--temperature", reference) == handed()
    [term] = json.loads(handed())["terms"]
    tau = fit["parameters"]["c"]["value"] / fit["parameters"]["k"]["value"]
    assert term["time_s"] == pytest.approx(tau, rel=1e-6)
    assert handed("--temperature", "50") != handed()
