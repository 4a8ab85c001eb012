"""What the workers of the page answer to small cases, as the page hears it."""

import base64

import numpy as np
import pytest

import springpot
from springpot.errors import DataError, ModelError
from springpot.web import leaving, tasks
from springpot.web.sessions import State, digest_of, text_of
from springpot.web.trying import hand_of, theta_of

OMEGA = np.geomspace(0.5, 30.0, 6)


def silent(stage):
    """Who hears nothing of the stages."""


def swept():
    """A material at two temperatures, each measured twice."""
    model, rng = springpot.parse_model("fractional-maxwell"), np.random.default_rng(1)
    exact = np.concatenate([by * model.stiffness(np.array([9.0, 3.0, 0.5]), OMEGA)
                            for by in (1.0, 1.0, 0.7, 0.7)])  # fmt: skip
    noise = 1.0 + 0.01 * (rng.normal(size=24) + 1j * rng.normal(size=24))
    return springpot.Measurement(
        np.tile(OMEGA, 4),
        exact * noise,
        conditions={"temperature": np.repeat([20.0, 35.0], 12)},
        repeat=np.repeat([1, 2, 1, 2], 6),
        units=springpot.Units("kN/m", "mm"),
        name="swept",
    )


TEXT = text_of(swept())
STATE = State(digest_of(TEXT), "fractional-maxwell", (), (3, 4, 20)).to_dict()


def without_data(told):
    return {name: part for name, part in told.items() if name not in ("text", "digest")}


def sent(content):
    return base64.b64encode(content.encode()).decode()


def test_data_that_are_dropped(stays):
    stays(without_data(tasks.understand(silent, "swept.csv", sent(TEXT))))


def test_data_that_join(stays):
    more = TEXT.splitlines()
    head = [line for line in more if line.startswith("#") or "[" in line]
    row = more[-1].split(",")
    more = "\n".join([*head, ",".join([row[0], "7.0", *row[2:]])])
    assert more.count("\n") < TEXT.count("\n")
    told = tasks.understand(silent, "more.csv", sent(more), onto=TEXT, onto_name="swept.csv")
    stays(without_data(told))


def test_a_data_set_by_its_name():
    told = tasks.dataset(silent, "nist-srm2491@temperature=20")
    assert told["source"] == "nist-srm2491@temperature=20"
    assert not told["joined"]
    for name in ("none", __file__):
        with pytest.raises(DataError, match="no registered data set"):
            tasks.dataset(silent, name)


def test_what_is_asked_of_a_state(stays):
    at = {"k": 8.0, "c": 3.0, "alpha": 0.6}
    hands = {name: {"value": value} for name, value in at.items()}
    stays(
        {
            "first": tasks.first(silent, STATE, TEXT),
            "curve": tasks.curve(silent, STATE, TEXT, hands),
        }
    )


@pytest.mark.parametrize("kind", ["command", "script", "data"])
@pytest.mark.parametrize("joined", [False, True])
def test_what_one_leaves_with(kind, joined, stays):
    state = {**STATE, "accepted": ["inertia"], "seed": 3}
    stays(tasks.leave(silent, kind, state, TEXT, "my sweep.csv", joined))


def test_more_than_twenty_ranges_of_rows_leave_as_a_file_of_their_own():
    twenty, more = (State("0" * 64, "", (), tuple(range(0, 2 * n, 2))) for n in (20, 21))
    assert leaving.source_of("a.csv", twenty, joined=False) == "a.csv"
    assert leaving.source_of("a.csv", more, joined=False) == "a-used.csv"
    assert (len(leaving.rows_to_exclude(twenty)), leaving.rows_to_exclude(more)) == (20, [])


@pytest.mark.parametrize(
    ("hand", "told"),
    [
        ({"value": True}, "not within"),
        ({"value": 5.0, "lower": 6.0}, "not within"),
        ({"value": 5.0, "lower": 6.0, "upper": 4.0}, "swap them"),
        (None, "has no value"),
    ],
)
def test_a_hand_outside_of_its_ends_is_told(hand, told):
    model = springpot.parse_model("kelvin")
    with pytest.raises(ModelError, match=told):
        hand_of(model, {"c": {"value": 1.0}, "k": hand})
    with pytest.raises(ModelError, match="has no value"):
        hand_of(model, [hand])


def test_a_hand_keeps_ends_that_there_are_and_what_stays():
    model = springpot.parse_model("kelvin")
    hands = {"k": {"value": 5.0, "lower": 4.0}, "c": {"value": 1, "fixed": True, "upper": 2.0}}
    hand = hand_of(model, hands)
    assert hand.values == {"k": 5.0, "c": 1.0}
    assert (hand.fix, hand.bounds) == ({"c": 1.0}, {"k": (4.0, np.inf)})
    alone = hand_of(model, {name: {"value": 5.0, "lower": 5.0, "upper": 5.0} for name in "kc"})
    assert alone.bounds == {"k": (5.0, 5.0), "c": (5.0, 5.0)}
    assert hand_of(model, {name: {"value": 5.0} for name in "kc"}).bounds == {}
    units = springpot.Units("kN/m", "mm")
    assert theta_of(model, units, hand).tolist() == [
        value / units.of(parameter.unit)[0]
        for value, parameter in zip((5.0, 1.0), model.parameters, strict=True)
    ]


def test_a_library_is_told_once_with_all_that_is_installed():
    told = tasks.TASKS["library"](silent)
    assert {"models", "effects", "datasets", "faults"} == set(told)
    names = {each["name"] for each in told["effects"]}
    assert "inertia" in names
    assert all(each["name"] and each["kind"] for each in told["datasets"])
