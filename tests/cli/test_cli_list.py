"""``springpot list``: names for people and JSON for programs, faulty plugins included."""

import pytest

from springpot.cli.listing import KINDS
from springpot.registry import Fault, plugins

KEY_NAMES = {
    "models": "name aliases summary citation parameters search_parameters needs drawing",
    "effects": (
        "name aliases summary equation plane layer tests needs parameters citation approximate "
        "signature"
    ),
    "optimisers": "name summary citation global gradient batched stochastic options",
    "datasets": (
        "name kind points licence where summary citation doi origin test columns model fit truth "
        "physics aliases unavailable"
    ),
    "suites": "name problems summary",
    "readers": "name summary holds signals writes",
    "objectives": "name summary citation",
    "writers": "name summary suffix",
}
KEYS = {kind: set(keys.split()) for kind, keys in KEY_NAMES.items()}


@pytest.mark.parametrize("kind", KINDS)
def test_json_has_the_agreed_keys(springpot, kind):
    answer = springpot("list", kind, "--json").json
    assert set(answer) == {"schema", "kind", "items", "unavailable"}
    assert answer["schema"] == "springpot.list/1"
    assert answer["items"]
    assert {frozenset(item) for item in answer["items"]} == {frozenset(KEYS[kind])}


def test_every_model_is_listed_by_name_and_can_be_drawn(springpot):
    listing = springpot("list", "models").out
    items = springpot("list", "models", "--json").json["items"]
    assert [item["name"] for item in items] == plugins().names("model")
    for item in items:
        assert item["name"] in listing
        assert item["drawing"]
        assert item["parameters"]


def test_an_unbounded_parameter_is_null_in_json(springpot):
    [item] = springpot("list", "models", "springpot", "--json").json["items"]
    assert item["parameters"][0] == {
        "name": "c",
        "symbol": "c",
        "unit": "N s^alpha/m",
        "lower": 0.0,
        "upper": None,
    }


def test_a_named_model_is_shown_whole(springpot):
    [item] = springpot("list", "models", "fractional-zener", "--json").json["items"]
    shown = springpot("list", "models", "fractional-zener").out
    for line in item["drawing"].splitlines():
        assert line.strip() in shown
    for word in ("k1", "N s^alpha/m", "0 to 1", *item["aliases"]):
        assert word in shown


def test_a_member_of_a_family_and_an_alias_can_be_named(springpot):
    answer = springpot("list", "models", "prony-3", "fractional-standard", "--json").json
    assert [len(item["parameters"]) for item in answer["items"]] == [7, 4]


def test_an_unavailable_plugin_is_listed_with_its_distribution_and_reason(springpot, monkeypatch):
    monkeypatch.setattr(
        plugins(), "_faults", [Fault("bad", "its-distribution", "ImportError: no module named q")]
    )
    assert (
        "plugin 'bad' of its-distribution: ImportError: no module named q"
        in springpot("list", "effects").out
    )
    assert springpot("list", "effects", "--json").json["unavailable"] == [
        {
            "plugin": "bad",
            "distribution": "its-distribution",
            "reason": "ImportError: no module named q",
        }
    ]


def test_readers_say_what_their_files_hold(springpot):
    """Those of tests in time stand apart from those of sweeps; each can be asked for by name."""
    listed = {
        item["name"]: item["holds"] for item in springpot("list", "readers", "--json").json["items"]
    }
    assert {"sweeps", "signals", "tests in time"} == set(listed.values())
    assert {name for name, holds in listed.items() if holds == "tests in time"} == set(
        plugins().names("time reader")
    )
    for name in plugins().names("time reader"):
        assert name in springpot("list", "readers").out
        assert "holds: tests in time" in springpot("list", "readers", name).out


def test_a_suite_lists_its_problems_and_a_problem_is_shown_whole(springpot):
    items = springpot("list", "suites", "springpot-60", "--json").json["items"]
    assert len(items) == 60
    assert {item["part"] for item in items} == {"easy", "hard", "deceptive"}
    shown = springpot("list", "suites", "springpot-60/shear-wave").out
    assert "specimen-inertia" in shown
    assert "part: deceptive" in shown
