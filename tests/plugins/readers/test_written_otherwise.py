"""Numbers, titles and units as laboratories write them otherwise.

Complex, in decibel, as a period, exchanged.
"""

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import MODULUS_UNITS, Measurement, with_noise
from springpot.measurement.mixed_up import exchange_note, material_misfit

from .samples import OMEGA, STIFFNESS, number, rows, table

HERTZ = OMEGA / (2 * np.pi)
"""A fluid's and a solid's truth: a Maxwell element, and the same beside a spring."""
SOLID = STIFFNESS + 400.0


def in_pascal(found):
    return found.stiffness * MODULUS_UNITS[found.units.stiffness]


def assert_holds(found, stiffness=STIFFNESS, omega=OMEGA):
    np.testing.assert_allclose(found.omega, omega, rtol=1e-9)
    np.testing.assert_allclose(in_pascal(found), stiffness, rtol=1e-9)


COMPLEX = {
    "python": lambda k: f"({number(k.real)}+{number(k.imag)}j)",
    "octave": lambda k: f"{number(k.real)} + {number(k.imag)}i",
    "sympy": lambda k: f"{number(k.real)}+{number(k.imag)}*I",
    "i first": lambda k: f"{number(k.real)} + i {number(k.imag)}",
    "exponents": lambda k: f"{k.real:.12e}+{k.imag:.12e}J",
}


@pytest.mark.parametrize("style", COMPLEX)
@pytest.mark.parametrize("title", ["G* [Pa]", "complex modulus (Pa)", "modulus [Pa]"])
def test_a_column_of_complex_numbers_is_storage_and_loss(folder, style, title):
    lines = [f"{number(w)},{COMPLEX[style](k)}" for w, k in zip(OMEGA, STIFFNESS, strict=True)]
    assert_holds(folder.open("\n".join([f"omega [rad/s],{title}", *lines])))


def test_complex_numbers_have_decimal_commas_and_other_columns_beside_them(folder):
    lines = [
        f"{number(w, ',')};{COMPLEX['octave'](k).replace('.', ',')};23;0,5"
        for w, k in zip(OMEGA, STIFFNESS, strict=True)
    ]
    found = folder.open("\n".join(["omega [rad/s];G* [Pa];T [°C];Dehnung [%]", *lines]))
    assert_holds(found)
    assert found.conditions["temperature"][0] == 23
    assert found.conditions["amplitude"][0] == 0.5


@pytest.mark.parametrize(
    ("title", "values"),
    [
        ("J* [1/Pa]", 1 / STIFFNESS),
        ("eta* [Pa s]", STIFFNESS / (1j * OMEGA)),
        ("X/F [mm/N]", 1e3 / STIFFNESS),
    ],
)
def test_what_opposes_the_modulus_has_its_own_sign(folder, title, values):
    """J* = J' - i J'' and eta* = eta' - i eta'': a positive loss from a negative imaginary part."""
    lines = [
        f"{number(w)},{v.real:.12g}{v.imag:+.12g}j" for w, v in zip(OMEGA, values, strict=True)
    ]
    assert_holds(folder.open("\n".join([f"omega [rad/s],{title}", *lines])))


def test_a_complex_column_without_a_unit_says_how_to_tell_it(folder):
    lines = [f"{number(w)},{COMPLEX['python'](k)}" for w, k in zip(OMEGA, STIFFNESS, strict=True)]
    text = "\n".join(["omega [rad/s],G*", *lines])
    assert "?storage=Pa,loss=Pa'" in folder.open(text).provenance["note units"]
    assert_holds(folder.open(text, "?storage=Pa,loss=Pa"))


def test_a_cell_that_is_no_complex_number_is_left_out_with_a_note_or_told(folder):
    lines = [f"{number(w)},{COMPLEX['python'](k)}" for w, k in zip(OMEGA, STIFFNESS, strict=True)]
    text = "\n".join(["omega [rad/s],G* [Pa]", *lines[:2], f"{number(OMEGA[2])},n/a", *lines[3:]])
    found = folder.open(text)
    assert len(found) == 4
    assert "1 of 5 rows" in found.provenance["note rows"]
    assert "line 4" in folder.complaint(text.replace("n/a", "wet"))


def test_values_with_deviations(folder):
    lines = [
        f"{number(w)},{number(k.real)} ± {number(k.real / 50)},"
        f"{number(k.imag)} +/- {number(k.imag / 20)}"
        for w, k in zip(OMEGA, STIFFNESS, strict=True)
    ]
    found = folder.open("\n".join(["omega [rad/s],G' [Pa],G'' [Pa]", *lines]))
    assert_holds(found)
    np.testing.assert_allclose(found.sd, STIFFNESS.real / 50 + 1j * STIFFNESS.imag / 20, rtol=1e-9)


@pytest.mark.parametrize(
    "words", [("±", "±"), ("SD", "SD.1"), ("Std. Dev. [Pa]", "Std. Dev. [Pa]")]
)
def test_a_column_called_deviation_belongs_to_the_one_before(folder, words):
    columns = (OMEGA, STIFFNESS.real, STIFFNESS.real / 50, STIFFNESS.imag, STIFFNESS.imag / 20)
    found = folder.open(f"omega [rad/s],G' [Pa],{words[0]},G'' [Pa],{words[1]}\n{rows(columns)}\n")
    assert_holds(found)
    np.testing.assert_allclose(found.sd, STIFFNESS.real / 50 + 1j * STIFFNESS.imag / 20, rtol=1e-9)


def test_a_deviation_in_per_cent_is_no_deviation_in_pascal(folder):
    columns = (OMEGA, STIFFNESS.real, OMEGA, STIFFNESS.imag, OMEGA)
    found = folder.open(f"omega [rad/s],G' [Pa],SD [%],G'' [Pa],SD [%]\n{rows(columns)}\n")
    assert_holds(found)
    assert found.sd is None


@pytest.mark.parametrize("unit", ["dB re 1 N/m", "dB re. 1 N/m", "dB (re 1 N/m)", "dB ref N/m"])
def test_a_level_of_dynamic_stiffness(folder, unit):
    columns = (OMEGA / (2 * np.pi), 20 * np.log10(abs(STIFFNESS)), np.degrees(np.angle(STIFFNESS)))
    assert_holds(
        folder.open(f"Frequency [Hz],Dynamic stiffness [{unit}],Phase [deg]\n{rows(columns)}\n")
    )


@pytest.mark.parametrize(
    ("title", "per_second"), [("Period [s]", 1.0), ("Periodendauer [ms]", 1e3)]
)
def test_a_period_is_one_over_a_frequency(folder, title, per_second):
    columns = (per_second / HERTZ, STIFFNESS.real, STIFFNESS.imag)
    assert_holds(folder.open(f"{title},G' [Pa],G'' [Pa]\n{rows(columns)}\n"))


def test_a_number_of_periods_is_no_period(folder):
    columns = (np.arange(5.0), OMEGA, STIFFNESS.real, STIFFNESS.imag)
    assert_holds(folder.open(f"Period,omega [rad/s],G' [Pa],G'' [Pa]\n{rows(columns)}\n"))


@pytest.mark.parametrize(
    "header",
    [
        "AngularFrequency_rad_s_,StorageModulus_Pa_,LossModulus_Pa_",
        "Angular.frequency..rad.s.,Storage.modulus..Pa.,Loss.modulus..Pa.",
        "omega_rad_s,G_storage_Pa,G_loss_Pa",
    ],
)
def test_titles_that_a_program_made_names_of(folder, header):
    assert_holds(folder.open(table(header)))


def test_a_dot_within_a_name_is_no_unit(folder):
    said = folder.complaint(table("time.s.,Storage.modulus..Pa.,Loss.modulus..Pa."))
    assert "missing frequency" in said


@pytest.mark.parametrize("unit", ["10^3 Pa", "×10³ Pa", "1e3 Pa", "Pa x 10^3", "10^3·Pa", "kPa"])
def test_powers_of_ten_in_units(folder, unit):
    assert_holds(folder.open(table(f"omega [rad/s],G' [{unit}],G'' [{unit}]", scale=1e-3)))


def test_real_and_imaginary_receptance_and_stiffness(folder):
    receptance = 1e3 / STIFFNESS
    columns = (HERTZ, receptance.real, receptance.imag)
    assert_holds(folder.open(f"Frequency [Hz],Re(X/F) [mm/N],Im(X/F) [mm/N]\n{rows(columns)}\n"))
    columns = (HERTZ, STIFFNESS.real / 1e3, STIFFNESS.imag / 1e3)
    assert_holds(folder.open(f"Frequency [Hz],Re(F/X) [N/mm],Im(F/X) [N/mm]\n{rows(columns)}\n"))


def test_springs_called_c_and_damping_ratios_called_beta(folder):
    """German drawings call a stiffness c.

    Codes for isolators call the equivalent damping ratio beta.
    """
    columns = (HERTZ, STIFFNESS.real / 1e3, STIFFNESS.imag / 1e3)
    assert_holds(folder.open(f"Frequenz [Hz],c' [N/mm],c'' [N/mm]\n{rows(columns)}\n"))
    columns = (HERTZ, STIFFNESS.real / 1e3, 50 * STIFFNESS.imag / STIFFNESS.real)
    assert_holds(folder.open(f"Frequency [Hz],Keff [kN/m],βeff [%]\n{rows(columns)}\n"))


def test_thousands_as_in_switzerland(folder):
    lines = [
        f"{w:.10g};{k.real:_.9f};{k.imag:_.9f}".replace("_", "'")
        for w, k in zip(OMEGA, 1e4 * SOLID, strict=True)
    ]
    assert_holds(folder.open("\n".join(["omega [rad/s];G' [Pa];G'' [Pa]", *lines])), 1e4 * SOLID)


def test_units_in_the_cells_of_a_column(folder):
    lines = [
        f"23 °C,{number(w)},{number(k.real)},{number(k.imag)}"
        for w, k in zip(OMEGA, STIFFNESS, strict=True)
    ]
    found = folder.open("\n".join(["Temperature,omega [rad/s],G' [Pa],G'' [Pa]", *lines]))
    assert_holds(found)
    np.testing.assert_array_equal(found.conditions["temperature"], 23.0)


def test_a_name_in_the_row_of_units(folder):
    """As pandas writes columns of two levels: the index is named below them."""
    assert_holds(folder.open(table(",G',G''\nomega,Pa,Pa")))


def test_a_temperature_in_two_cells_above_the_table(folder):
    found = folder.open(
        "Auftrag;4711\nTemperatur;23 °C\n\n" + table("omega [rad/s];G' [Pa];G'' [Pa]", ";")
    )
    np.testing.assert_array_equal(found.conditions["temperature"], 23.0)


@pytest.mark.parametrize("mark", ["n/a", "#N/A", "---", "#DIV/0!"])
def test_marks_of_what_was_not_measured_in_an_own_table(folder, mark):
    found = folder.open(table("omega [rad/s],storage [Pa],loss [Pa]") + f"99,{mark},{mark}\n")
    assert_holds(found)
    assert "1 of 6 rows" in found.provenance["note rows"]


def test_an_unknown_column_may_be_the_frequency_before_any_constant(folder):
    """A hint typed as it stands must not give all rows of a frequency sweep one frequency."""
    text = table("Speed [rpm],storage [Pa],loss [Pa]")
    assert folder.complaint(text).endswith(
        "if Speed [rpm] is it, open '" + str(folder.path / "data.txt") + "?1=frequency[1/min]'"
    )
    assert_holds(folder.open(text, "?1=frequency[1/min]"), omega=OMEGA * 2 * np.pi / 60)
    text = table("Setting,storage [Pa],loss [Pa]")
    assert "if Setting is it, in Hz, open" in folder.complaint(text)
    assert_holds(folder.open(text, "?1=frequency[Hz]"), omega=OMEGA * 2 * np.pi)


class TestExchange:
    """Storage and loss in each other's place."""

    WIDE = np.logspace(-2, 2, 21)

    def materials(self):
        w = self.WIDE
        return {
            "solid": 1.0 + (1j * w) ** 0.3,
            "fluid": 3j * w / (1 + 1j * w) + 0.1j * w,
            "polymer": 10 * 1j * w / (10 + 1j * w) + 2 * 1j * w / (0.1 + 1j * w),
        }

    def test_told_where_they_are_exchanged_only(self):
        rng = np.random.default_rng(5)
        for name, stiffness in self.materials().items():
            right = with_noise(Measurement(self.WIDE, stiffness), 0.03, rng, symmetric=True)
            exchanged = Measurement(self.WIDE, right.stiffness.imag + 1j * right.stiffness.real)
            assert not exchange_note(right), name
            assert exchange_note(exchanged), name

    @pytest.mark.parametrize("loss_over_storage", [1e-3, 1e3])
    def test_a_fluid_is_not_told_for_its_large_loss_nor_a_spring_for_its_small_one(
        self, loss_over_storage
    ):
        stiffness = 1.0 + 1j * loss_over_storage * self.WIDE
        assert not exchange_note(Measurement(self.WIDE, stiffness))

    def test_a_mass_or_a_delay_is_no_exchange(self):
        """Both take a sweep far from every material; exchanging its columns brings it no nearer."""
        solid = self.materials()["solid"]
        for other in (
            solid - 0.001 * self.WIDE**2,
            solid * np.exp(-0.01j * self.WIDE),
            solid.conj(),
        ):
            measured = Measurement(self.WIDE, other)
            assert material_misfit(measured.omega, measured.stiffness) > 0.05
            assert not exchange_note(measured)

    def test_few_points_or_a_narrow_range_tell_nothing(self):
        exchanged = self.materials()["polymer"]
        exchanged = exchanged.imag + 1j * exchanged.real
        assert exchange_note(Measurement(self.WIDE, exchanged))
        assert not exchange_note(Measurement(self.WIDE[::6], exchanged[::6]))
        assert not exchange_note(Measurement(self.WIDE[:3], exchanged[:3]))

    def test_the_note_leads_to_the_right_data(self, folder):
        solid = self.materials()["solid"]
        text = (
            f"omega [rad/s],storage [Pa],loss [Pa]\n{rows((self.WIDE, solid.imag, solid.real))}\n"
        )
        note = folder.open(text).provenance["note exchange"]
        path = folder.path / "data.txt"
        assert note.endswith(f"open '{path}?storage=loss,loss=storage'")
        found = folder.open(text, "?storage=loss,loss=storage")
        assert_holds(found, solid, self.WIDE)
        assert "note exchange" not in found.provenance


def test_a_hint_that_is_no_complete_sentence_is_never_taken_for_data(folder):
    with pytest.raises(DataError, match="says nothing of a column"):
        folder.open(table("omega [rad/s],G' [Pa],G'' [Pa]"), "?storage")


class TestRepeats:
    """The same frequencies again and again, in a table that does not say why."""

    def text(self, second=(), title=""):
        twice = np.tile(OMEGA, 2), np.tile(STIFFNESS.real, 2), np.tile(STIFFNESS.imag, 2)
        return f"omega [rad/s],G' [Pa],G'' [Pa]{title}\n{rows((*twice, *second))}\n"

    @pytest.mark.parametrize("title", ["", ",Point", ",Time [s]"])
    def test_are_told(self, folder, title):
        counted = [np.arange(10.0)] * bool(title)
        note = folder.open(self.text(counted, title)).provenance["note repeats"]
        assert "each of 5 frequencies stands 2 times" in note

    @pytest.mark.parametrize("title", ["T [°C]", "Strain [%]", "repeat", "run"])
    def test_are_not_told_where_the_table_says_what_differs(self, folder, title):
        level = np.repeat([20.0, 40.0], 5)
        if title == "repeat":
            level = np.repeat([1.0, 2.0], 5)
        assert "note repeats" not in folder.open(self.text([level], f",{title}")).provenance

    def test_a_setting_in_time_at_one_frequency_is_none(self, folder):
        columns = (
            np.arange(20.0),
            np.full(20, 6.28),
            np.geomspace(1, 500, 20),
            np.geomspace(5, 50, 20),
        )
        found = folder.open(f"time [s],omega [rad/s],G' [Pa],G'' [Pa]\n{rows(columns)}\n")
        assert "note repeats" not in found.provenance


@pytest.mark.parametrize("part", ["omega", "stiffness"])
def test_nobody_looks_for_exchanged_columns_over_hundreds_of_decades(part):
    """Numbers that no instrument gives: a spectrum over them would take seconds, and overflow."""
    far = np.geomspace(1e-290, 1e290, 12)
    omega = far if part == "omega" else np.geomspace(1.0, 100.0, 12)
    size = far if part == "stiffness" else np.ones(12)
    assert exchange_note(Measurement(omega, size * (1.0 - 2.0j))) == {}


@pytest.mark.parametrize("size", [1e-290, 1e290])
def test_the_size_of_numbers_changes_nothing_of_what_was_exchanged(size):
    omega = np.geomspace(1.0, 100.0, 12)
    maxwell = 1j * omega / (10.0 + 1j * omega)
    swapped = size * (maxwell.imag + 1j * maxwell.real)
    assert (
        exchange_note(Measurement(omega * size, swapped))
        == exchange_note(Measurement(omega, swapped / size))
        != {}
    )


def test_thousands_in_the_first_row_lose_no_row(folder):
    """A row of which most numbers part their thousands is one of the table."""
    found = folder.open("f [Hz];G' [Pa];G'' [Pa]\n1;1,234.5;2,345.6\n2;1,300.5;2,400.5\n")
    assert found.storage.tolist() == [1234.5, 1300.5]
