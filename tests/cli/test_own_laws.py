"""Laws that are typed at the command line, and which effects may be named."""

import pytest

import springpot as library
from springpot.cli.common import library_from

MASS = "my-mass = parallel: -m*omega^2"
HIDDEN = ("diagnose", "artificial-hidden", "--model", "fractional-maxwell")


@pytest.mark.soak
def test_a_typed_effect_is_named_with_its_formula_and_loaded_again(springpot, tmp_path):
    only = ("--effects", "my-mass,inertia,time-delay", "--without", "inertia")
    said = springpot(*HIDDEN, "--effect", MASS, *only, "--json")
    best = said.json["candidates"][0]
    assert (best["effect"], best["law"]) == ("my-mass", f"({MASS})")
    assert best["parameters"]["m"]["unit"] == "kg"
    assert {row["effect"] for row in said.json["candidates"]} <= {"my-mass", "time-delay"}
    path = tmp_path / "diagnosis.json"
    path.write_text(said.out, encoding="utf-8")
    assert library.load(path).best.physics.equation == "K + -m*omega^2"


@pytest.mark.soak
def test_an_accepted_law_is_a_rung_by_its_formula(springpot):
    asked = ("--effect", MASS, "--effects", "my-mass", "--accept", "my-mass")
    said = springpot("discover", *HIDDEN[1:], *asked, "--json").json
    assert said["steps"][-1]["model"] == f"fractional-maxwell + ({MASS})"


@pytest.mark.parametrize("kind", [("effects",), ("effects", "--json")])
def test_a_typed_law_is_listed_as_any_effect(springpot, kind):
    shown = springpot("list", kind[0], MASS, *kind[1:]).out
    for words in ("-m*omega^2", "kg", "causal and passive"):
        assert words in shown


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--effect", "parallel: k + c*X"), "never vanishes"),
        (("--effect", "parallel: k*open(1)"), "sign 3: 'open' is no function"),
        (("--without", "no-such"), "unknown effect 'no-such'"),
        (("--effects", "inertia,no-such"), "unknown effect 'no-such'"),
        (("--effects", "inertia", "--without", "inertia"), "no effect is left"),
    ],
)
def test_what_cannot_be_looked_for_is_refused_in_one_line(springpot, options, words):
    assert springpot(*HIDDEN, *options).is_one_line(words)


def test_laws_without_a_name_are_counted_from_one():
    options = {"effect": ["parallel: -m*omega^2", MASS], "effects": None, "without": ()}
    names = [effect.name for effect in library_from(options)["effects"]]
    assert names == ["law-1", "my-mass"]
