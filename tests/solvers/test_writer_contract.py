"""The contract of writers: each fault of a format for solvers is named in its own words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from springpot.registry import plugins
from springpot.solvers import Writer
from springpot.testing import check_writer


def text(handoff) -> str:
    prony = handoff.prony
    lines = [f"# {line}" for line in handoff.heading()]
    terms = zip(prony.weights.tolist(), prony.times.tolist(), strict=True)
    lines += [f"{prony.equilibrium!r} {prony.viscosity!r}"]
    lines += [f"{w!r} {tau!r}" for w, tau in terms]
    return "\n".join(lines) + "\n"


def read(card: str, omega):
    rows = [line.split() for line in card.splitlines() if not line.startswith("#")]
    (spring, dashpot), *terms = [[float(word) for word in row] for row in rows]
    s = 1j * omega
    return spring + dashpot * s + sum(w * s * tau / (1 + s * tau) for w, tau in terms)


GOOD = Writer("mine", text, "a card of mine", ".card", several="".join)


def test_a_good_writer_has_no_complaints():
    assert check_writer(GOOD, read) == []
    assert check_writer(GOOD) == []


def without(position: int):
    """The same text without one of its numbers' lines."""
    return lambda handoff: "".join(
        line
        for i, line in enumerate(text(handoff).splitlines(True))
        if i != position + len(handoff.heading())
    )


def halved(card: str, omega):
    return 0.5 * read(card, omega)


def crash(handoff) -> str:
    if len(handoff.prony.times) > 20:
        raise IndexError("no room")
    return text(handoff)


drawn = np.random.default_rng(1)


@pytest.mark.parametrize(
    ("changes", "reader", "says"),
    [
        ({"name": "My Card"}, None, "words: 'My Card' must be lower-case"),
        ({"suffix": "card"}, None, "text: the suffix is 'card'"),
        ({"text": lambda h: text(h)[:-1]}, None, "text: the text does not end its last line"),
        ({"text": lambda h: text(h) + f"{drawn.normal()}\n"}, None, "two cards of one material"),
        ({"text": lambda h: "1 2\n"}, None, "text: a user is not told 'springpot: zener"),
        ({"text": without(0)}, None, "holds: the long-term stiffness changes nothing"),
        ({"text": without(0)}, None, "holds: a dashpot changes nothing"),
        ({"text": without(1)}, None, "holds: the time of a term changes nothing"),
        ({"text": without(1)}, None, "holds: the weight of a term changes nothing"),
        ({"text": crash}, None, "refuses: raises IndexError: no room"),
        ({"several": lambda texts: texts[0]}, None, "several: of two materials in one file that"),
        ({}, halved, "read-back: a series: K read back is 50 % off"),
    ],
)
def test_each_fault_is_named(changes, reader, says):
    found = check_writer(replace(GOOD, **changes), reader)
    assert any(says in sentence for sentence in found), found


def test_an_aspect_is_left_out_only_by_its_name():
    bad = replace(GOOD, suffix="card")
    assert check_writer(bad, skip=["text"]) == []
    assert "no aspect 'txt'" in check_writer(bad, skip=["txt"])[0]


def test_every_installed_writer_can_be_asked():
    for writer in plugins().items("writer"):
        assert check_writer(writer, skip=["holds", "refuses"]) == []


def test_a_card_is_asked_for_each_part_of_a_series(stays):
    asked = []

    def kept(handoff):
        prony = handoff.prony
        asked.append([prony.equilibrium, prony.viscosity, prony.weights, prony.times])
        return text(handoff)

    for aspect in replace(GOOD, text=kept).aspects(read).values():
        assert list(aspect()) == []
    # Sixty terms are only too many.
    stays([each for each in asked if len(each[2]) < 60])
