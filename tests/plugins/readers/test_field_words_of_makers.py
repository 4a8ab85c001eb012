"""Words, codes and layouts of laboratories in many countries.

Recognised by structure and the words of the field.
"""

import numpy as np
import pytest

from springpot.errors import DataError

from .samples import OMEGA, STIFFNESS, ta_thermal

HERTZ = OMEGA / (2 * np.pi)
SIZE, TANGENT = abs(STIFFNESS), STIFFNESS.imag / STIFFNESS.real
PHASE = np.degrees(np.angle(STIFFNESS))
G = (HERTZ, STIFFNESS.real, STIFFNESS.imag)


def table(head, columns, separator=";", encoding="utf-8", decimal=","):
    """A sweep below its names, as bytes."""
    columns = [np.broadcast_to(column, OMEGA.shape) for column in columns]
    rows = [
        separator.join(f"{v:.10g}".replace(".", decimal) for v in row)
        for row in zip(*columns, strict=True)
    ]
    return "\r\n".join([head, *rows, ""]).encode(encoding)


SHEETS = {
    "japanese isolator": (
        "振動数(Hz);等価剛性(Pa);等価減衰定数(%)",
        (*G[:2], 50 * TANGENT),
        "cp932",
    ),
    "japanese spring": ("周波数[Hz];動的ばね定数[Pa];損失係数", (HERTZ, SIZE, TANGENT), "cp932"),
    "chinese": ("频率(Hz);储能模量(Pa);损耗模量(Pa)", G, "gb18030"),
    "russian": ("Частота, Гц;Модуль накопления, Па;Модуль потерь, Па", G, "cp1251"),
    "polish": ("Częstotliwość [Hz];Moduł zachowawczy [Pa];Moduł stratności [Pa]", G, "cp1250"),
    "german damping": (
        "f [Hz];Effektive Steifigkeit [N/m];Äquivalentes Dämpfungsmaß [-]",
        (*G[:2], TANGENT / 2),
        "latin-1",
    ),
    "german C_dyn": (
        "Frequenz [Hz];C_dyn [N/m];Verlustwinkel [°];Vorlast [N]",
        (HERTZ, SIZE, PHASE, 5),
        "latin-1",
    ),
    "units in brackets behind a stroke": ("f / Hz;K' / (N/m);K'' / (N/m)", G, "utf-8"),
    "set and actual": (
        "Temp. Kammer [°C];Frequenz Soll [Hz];Frequenz Ist [Hz];E' [Pa];E'' [Pa];Verlustf.",
        (23, 99, *G, TANGENT),
        "latin-1",
    ),
    "symbols behind words": ("Frequency (Hz);Stiffness K' (N/m);Stiffness K\" (N/m)", G, "utf-8"),
    "primes of Windows": ("f [Hz];G\u2019 [Pa];G\u2019\u2019 [Pa];T [°C]", (*G, 20), "cp1252"),
    "loss and tan delta": (
        "Frequency/Hz;Modulus/Pa;Tan Delta;Loss Modulus/Pa",
        (*G[:2], TANGENT, G[2]),
        "utf-8",
    ),
    "damping coefficient": (
        "Frequency (Hz);Kdyn (N/m);Damping C (N.s/m)",
        (HERTZ, SIZE, G[2] / OMEGA),
        "utf-8",
    ),
    "letters": ("f (Hz);K' (N/m);d (Ns/m)", (*G[:2], G[2] / OMEGA), "utf-8"),
    "effective modulus": (
        "f (Hz);gamma (%);Geff (Pa);heq (%)",
        (HERTZ, 100, G[1], 50 * TANGENT),
        "utf-8",
    ),
    "amplitudes": (
        "Frequency [Hz];Force amplitude [N];Displacement amplitude [m];Phase [deg]",
        (HERTZ, SIZE / 4, 0.25, PHASE),
        "utf-8",
    ),
    "work of a cycle": (
        "Frequency [Hz];Effective stiffness [N/m];Energy dissipated per cycle [N m];Amplitude [m]",
        (*G[:2], np.pi * G[2] / 16, 0.25),
        "utf-8",
    ),
}


@pytest.mark.parametrize("name", SHEETS)
def test_a_sweep_opens_by_the_words_of_its_field(folder, name):
    head, columns, encoding = SHEETS[name]
    found = folder.open(table(head, columns, encoding=encoding))
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-7)
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-7)


def test_the_unit_of_the_answer_is_that_of_the_amplitudes(folder):
    head = "Frequency [Hz];Max Force (kN);Dyn. Amplitude [mm];Phase [deg]"
    assert folder.open(table(head, (HERTZ, SIZE, 0.5, PHASE))).units.stiffness == "kN/mm"


@pytest.mark.parametrize(
    ("title", "amplitude"),
    [
        ("Amplitude [mm]", 2.0),
        ("Amplitude (mm 0-pk)", 2.0),
        ("Dynamic Displ [mm pk-pk]", 1.0),
        ("Amplitude crête à crête [mm]", 1.0),
        ("両振幅 [mm]", 1.0),
    ],
)
def test_an_amplitude_from_trough_to_crest_is_halved_and_told(folder, title, amplitude):
    found = folder.open(table(f"f [Hz];K' [N/mm];K'' [N/mm];{title}", (*G, 2.0)))
    np.testing.assert_allclose(found.conditions["amplitude"], amplitude)
    assert found.units.amplitude == "mm"
    assert ("note amplitude" in found.provenance) == (amplitude == 1.0)


def test_a_modulus_that_may_be_the_whole_or_a_part_is_asked_for(folder):
    content = table(
        "Fréquence (Hz);Raideur (N/m);Tan delta", (HERTZ, SIZE, TANGENT), encoding="latin-1"
    )
    with pytest.raises(DataError, match=r"open '.*\?2=magnitude\[N/m\]'.*'.*\?2=storage\[N/m\]'"):
        folder.open(content)
    np.testing.assert_allclose(
        folder.open(content, "?2=magnitude[N/m]").stiffness, STIFFNESS, rtol=1e-7
    )


def test_a_clock_that_is_there_is_no_constant(folder):
    with pytest.raises(
        DataError, match=r"if Frequenz Soll \[Hz\] is it, open '.*\?1=frequency\[Hz\]'"
    ):
        folder.open(table("Frequenz Soll [Hz];E' [MPa];E'' [MPa]", G))


def test_a_force_without_its_displacement_asks_for_that(folder):
    content = table(
        "Test No;Freq (Hz);Stroke (mm);Max Force (kN);Phase lag (deg)", (1, HERTZ, 2, SIZE, PHASE)
    )
    with pytest.raises(
        DataError, match=r"missing amplitude .* if Stroke \(mm\) is it.*\?3=amplitude\[mm\]'"
    ):
        folder.open(content)


def test_words_where_nothing_was_measured_are_gaps(folder):
    content = table("f [Hz];G' [Pa];G'' [Pa]", G) + b"200;OL;OL\r\n"
    assert len(folder.open(content)) == len(OMEGA)


def test_signals_that_are_listed_above_the_numbers_are_its_columns(folder):
    found = folder.open(ta_thermal())
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-8)
    np.testing.assert_array_equal(found.conditions["temperature"], 30.5)
    assert found.units.stiffness == "MPa"
    assert [(part.points, part.usable) for part in folder.parts(ta_thermal())] == [
        (2, True),
        (3, True),
    ]


def test_a_japanese_rheometer_is_no_other_table(folder):
    names = "ポイント番号\t角周波数\t貯蔵弾性率\t損失弾性率\t温度"
    lines = [
        "プロジェクト:\tゲル",
        "試験:\tスイープ",
        "",
        "結果:\tスイープ 1",
        "",
        "区間とデータポイント:\t1\t5",
    ]
    lines += [f"区間データ:\t{names}", "\t\t\t\t\t", "\t\t[rad/s]\t[Pa]\t[Pa]\t[°C]"]
    points = zip(OMEGA, STIFFNESS, strict=True)
    lines += [
        f"\t{i}\t{w:.10g}\t{k.real:.10g}\t{k.imag:.10g}\t23" for i, (w, k) in enumerate(points)
    ]
    content = "\n".join(lines).encode("utf-16")
    assert folder.reader(content) == "rheocompass"
    found = folder.open(content)
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-8)
    assert set(found.conditions) == {"temperature"}
