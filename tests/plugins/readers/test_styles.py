"""Styles in which people write numbers and tables, and what is asked where they are unclear."""

import numpy as np
import pytest

from springpot.errors import DataError

from .samples import OMEGA, STIFFNESS, number, rows

HERTZ = OMEGA / (2 * np.pi)
COLUMNS = (HERTZ, STIFFNESS.real, STIFFNESS.imag)
NUMBERS = rows(COLUMNS)


def same(found):
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-10)
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-10)


@pytest.mark.parametrize("blank", [" ", "\u00a0", "\u202f", "\u2009"])
def test_blanks_between_thousands(folder, blank):
    text = f"f [Hz];G' [Pa];G'' [Pa]\n0,5;1{blank}000,5;900,25\n1;12{blank}000;1{blank}900\n"
    found = folder.open(text)
    np.testing.assert_array_equal(found.stiffness, [1000.5 + 900.25j, 12000 + 1900j])


def test_two_numbers_in_one_cell_are_no_thousands(folder):
    assert "'1 00' is no number" in folder.complaint(
        "f [Hz];G' [Pa];G'' [Pa]\n0,5;1 00;900\n1;12;190\n"
    )


def test_exponents_of_fortran(folder):
    text = "\n".join(
        " ".join(f"{value:.12E}".replace("E", "D") for value in row)
        for row in zip(*COLUMNS, strict=True)
    )
    same(folder.open(f"f[Hz] G'[Pa] G''[Pa]\n{text}\n"))


def test_the_minus_of_typesetting(folder):
    lines = "\n".join(f"{line},−40" for line in NUMBERS.split("\n"))
    found = folder.open(f"f [Hz],G' [Pa],G'' [Pa],T [°C]\n{lines}\n")
    same(found)
    assert set(found.conditions["temperature"]) == {-40.0}


def test_names_in_two_rows(folder):
    same(folder.open(f"Test,Storage,Loss\nfrequency,modulus,modulus\n[Hz],[Pa],[Pa]\n{NUMBERS}\n"))


def test_a_table_on_its_side(folder):
    lines = [
        ",".join([name, *(number(v) for v in column)])
        for name, column in zip(("f [Hz]", "G' [Pa]", "G'' [Pa]"), COLUMNS, strict=True)
    ]
    same(folder.open("\n".join(lines) + "\n"))


def test_numbers_on_their_side_without_moduli_are_asked_for(folder):
    assert "say what they are" in folder.complaint("f [Hz],1,2,3\nx,4,5,6\ny,7,8,9\n")


def test_means_with_their_standard_deviations(folder):
    lines = "\n".join(f"{line},1,2" for line in NUMBERS.split("\n"))
    found = folder.open(f"f [Hz],G'_mean [Pa],G''_mean [Pa],G'_std [Pa],G''_std [Pa]\n{lines}\n")
    same(found)
    assert set(found.sd) == {1 + 2j}


def test_columns_of_repeats(folder):
    lines = rows((HERTZ, *(f(STIFFNESS * k) for k in (1.0, 1.01) for f in (np.real, np.imag))))
    text = f"f [Hz],G'_1 [Pa],G''_1 [Pa],G'_2 [Pa],G''_2 [Pa]\n{lines}\n"
    found = folder.open(text, "?curves=repeat")
    np.testing.assert_array_equal(found.repeat, np.repeat([1, 2], len(OMEGA)))
    np.testing.assert_allclose(
        found.stiffness, np.concatenate([STIFFNESS, 1.01 * STIFFNESS]), rtol=1e-10
    )


def test_a_page_is_no_table(folder):
    with pytest.raises(DataError, match="HTML or XML"):
        folder.open("<html><table><tr><td>f [Hz]</td></tr></table></html>", name="sweep.xls")
