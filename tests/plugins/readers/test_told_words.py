"""The words of a file for frequency and modulus are kept, also when it is written again."""

import pytest

import springpot

ROWS = "\n1,10,2\n2,11,3\n4,12,4\n"


@pytest.mark.parametrize(
    ("header", "clock", "letter"),
    [
        ("frequency [Hz],storage [kN/m],loss [kN/m]", "Hz", ""),
        ("omega [rad/s],storage [Pa],loss [Pa]", "rad/s", ""),
        (
            "Angular frequency [rad/s],Storage modulus (G') [Pa],Loss modulus (G'') [Pa]",
            "rad/s",
            "G",
        ),
        ("Frequency [Hz],E' [MPa],E'' [MPa]", "Hz", "E"),
        ("f in Hz,G' in Pa,G'' in Pa", "Hz", "G"),
        ("f [mHz],K' [N/mm],K'' [N/mm]", "Hz", "K"),
        ("Frequency [1/min],|E*| [MPa],phase [deg]", "Hz", "E"),
        ("omega [rad/s],Gp_Pa,Gpp_Pa", "rad/s", "G"),
        ("omega [rad/s],K' [Pa],K'' [Pa]", "rad/s", ""),
    ],
)
def test_the_words_of_a_header(tmp_path, header, clock, letter):
    path = tmp_path / "table.csv"
    path.write_text(header + ROWS)
    units = springpot.read(path).units
    assert (units.clock, units.letter) == (clock, letter)


@pytest.mark.parametrize(
    "header", ["frequency [Hz],E' [MPa],E'' [MPa]", "omega [rad/s],storage [Pa],loss [Pa]"]
)
def test_data_written_again_keep_their_words(tmp_path, header):
    """The file springpot writes is in rad/s to the last bit; nobody is told so who gave hertz."""
    path = tmp_path / "table.csv"
    path.write_text(header + ROWS)
    first = springpot.read(path)
    second = springpot.read(springpot.write_measurement(first, tmp_path / "again.csv"))
    assert (second.units.clock, second.units.letter) == (first.units.clock, first.units.letter)
    assert (second.omega == first.omega).all()
    third = springpot.read(springpot.write_measurement(second, tmp_path / "third.csv"))
    assert (third.units.clock, third.units.letter) == (first.units.clock, first.units.letter)


def test_words_are_no_units():
    """Data that differ in words alone are in the same units."""
    assert springpot.Units("Pa", "%") == springpot.Units("Pa", "%", "rad/s", "G")
    with pytest.raises(springpot.errors.DataError, match="Hz or rad/s"):
        springpot.Units("Pa", "%", "kHz")
    with pytest.raises(springpot.errors.DataError, match="G, E or K"):
        springpot.Units("Pa", "%", letter="J")


def test_signals_are_told_in_hertz(tmp_path):
    from springpot.measurement import Measurement

    path = tmp_path / "again.csv"
    springpot.write_measurement(Measurement([1.0, 2.0], [1 + 1j, 2 + 1j]), path)
    assert "# told in: Hz" in path.read_text()
    path.write_text(path.read_text().replace("told in: Hz", "told in: furlongs"))
    assert springpot.read(path).units.clock == "rad/s"  # what is not understood changes nothing
