"""Cards of solids: each solver's own equations give the measured modulus from what it reads."""

from __future__ import annotations

import numpy as np
import pytest
from test_writers import (
    OMEGA,
    SERIES,
    WRITERS,
    abaqus_materials,
    handoff,
    numbers,
    read_comsol,
    read_opensees,
)

from springpot.rheology import Complex

GIVEN = [
    ("G", "constant"),
    ("G", "relaxing"),
    ("E", "constant"),
    ("E", "relaxing"),
    ("K", "relaxing"),
]


def sum_of(inf: float, terms: list[tuple[float, float]]) -> Complex:
    s = 1j * OMEGA
    return inf + 0 * s + sum(weight * s * time / (1 + s * time) for weight, time in terms)


def from_shares(whole: float, shares: list[tuple[float, float]]) -> Complex:
    return sum_of(
        whole * (1 - sum(g for g, _ in shares)), [(whole * g, time) for g, time in shares]
    )


def elastic(young: float, poisson: float) -> tuple[float, float]:
    return young / (2 * (1 + poisson)), young / (3 * (1 - 2 * poisson))


def abaqus(text: str) -> tuple[Complex, Complex]:
    material = abaqus_materials(text)["SPRINGPOT"]
    [[young, poisson]] = material["*ELASTIC, MODULI=INSTANTANEOUS"]
    shear, bulk = elastic(young, poisson)
    rows = material["*VISCOELASTIC, TIME=PRONY"]
    g, k = [(g, tau) for g, _, tau in rows], [(k, tau) for _, k, tau in rows]
    return from_shares(shear, g), from_shares(bulk, k)


def abaqus_frequency(text: str) -> tuple[Complex, Complex]:
    material = abaqus_materials(text)["SPRINGPOT_FREQUENCY"]
    [[young, poisson]] = material["*ELASTIC, MODULI=LONG TERM"]
    rows = np.array(material["*VISCOELASTIC, FREQUENCY=TABULAR"])
    f = OMEGA / (2 * np.pi)
    real_g, imaginary_g, real_k, imaginary_k = (
        np.interp(f, rows[:, 4], rows[:, i]) for i in range(4)
    )
    shear, bulk = elastic(young, poisson)
    return shear * (1 - imaginary_g + 1j * real_g), bulk * (1 - imaginary_k + 1j * real_k)


def ansys(text: str) -> tuple[Complex, Complex]:
    found = {"SHEAR": [], "BULK": []}
    kind = ""
    constants = dict(line.rsplit(",", 1) for line in text.splitlines() if line.startswith("MP,"))
    for line in text.splitlines():
        if line.startswith("TB,PRONY"):
            kind = line.rpartition(",")[2]
        elif line.startswith("TBDATA"):
            found[kind] += numbers(line.split(",", 2)[2])
    shear, bulk = elastic(float(constants["MP,EX,1"]), float(constants["MP,PRXY,1"]))
    pairs = {kind: list(zip(flat[::2], flat[1::2], strict=True)) for kind, flat in found.items()}
    return from_shares(shear, pairs["SHEAR"]), from_shares(bulk, pairs["BULK"])


def ls_dyna(text: str) -> tuple[Complex, Complex]:
    """G, beta, K, beta in fields of ten signs.

    Without K the bulk modulus is that of the first card.
    """
    lines = text.splitlines()
    first = next(line for line in lines if line.startswith("         1       &RO"))
    card = lines.index("$#      gi     betai        ki    betaki")
    rows = [
        [float(line[i : i + 10]) for i in range(0, len(line), 10)] for line in lines[card + 1 : -1]
    ]
    bulk = float(first[20:30]) * np.ones(len(OMEGA), dtype=complex)
    if len(rows[0]) == 4:
        bulk = sum_of(rows[0][2], [(row[2], 1 / row[3]) for row in rows[1:]])
    return sum_of(rows[0][0], [(row[0], 1 / row[1]) for row in rows[1:]]), bulk


CARDS = {
    "abaqus": (abaqus, "abaqus", 1e-6),
    "abaqus at frequencies": (abaqus_frequency, "abaqus", 3e-3),
    "ansys": (ansys, "ansys", 1e-6),
    "ls-dyna": (ls_dyna, "ls-dyna", 2e-4),
}


@pytest.mark.parametrize(("measured", "way"), GIVEN)
@pytest.mark.parametrize("card", CARDS)
def test_the_measured_modulus_comes_back_from_the_card_of_a_solid(
    card: str, measured: str, way: str
):
    read, name, within = CARDS[card]
    for poisson in (0.3, 0.49):
        text = WRITERS[name].written(handoff(letter=measured, bulk=way, poisson=poisson))
        shear, bulk = read(text)
        back = {"G": shear, "E": 9 * bulk * shear / (3 * bulk + shear), "K": bulk}[measured]
        np.testing.assert_allclose(back, SERIES.stiffness(OMEGA), rtol=within)
        if way == "constant":
            np.testing.assert_allclose(bulk, bulk[0].real, rtol=within)
            assert "the bulk modulus is constant" in text
        else:
            np.testing.assert_allclose(
                bulk / shear, 2 * (1 + poisson) / (3 * (1 - 2 * poisson)), rtol=within
            )
            assert "the bulk modulus relaxes" in text


@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_a_bar_in_opensees_has_youngs_modulus_and_a_branch_in_comsol_the_shear_modulus(
    poisson: float,
):
    """1 / E = 1 / (3 G) + 1 / (9 K) with a constant K, which nu at once tells."""
    given = SERIES.stiffness(OMEGA)
    whole = SERIES.instantaneous
    bulk = whole * 2 * (1 + poisson) / (3 * (1 - 2 * poisson))
    text = WRITERS["opensees"].written(handoff(letter="G", bulk="constant", poisson=poisson))
    np.testing.assert_allclose(1 / read_opensees(text), 1 / (3 * given) + 1 / (9 * bulk), rtol=1e-6)
    text = WRITERS["comsol"].written(handoff(letter="E", bulk="constant", poisson=poisson))
    bulk = whole / (3 * (1 - 2 * poisson))
    np.testing.assert_allclose(1 / given, 1 / (3 * read_comsol(text)) + 1 / (9 * bulk), rtol=1e-6)


def test_a_format_of_any_modulus_says_which_it_is():
    for letter, word in (
        ("G", "shear modulus"),
        ("E", "Young's modulus"),
        ("K", "bulk modulus"),
        ("", "modulus"),
    ):
        for name in ("csv", "json", "python", "fmu"):
            assert f"{word} in MPa" in WRITERS[name].written(handoff(letter=letter))
