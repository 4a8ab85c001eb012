"""Layouts that instruments and programs write, beside those of the other tests.

Made from what is known of them.
"""

import numpy as np
import pytest

from springpot.measurement import open_measurement
from springpot.registry import signals_to_measurement

from . import samples
from .conftest import READERS

OMEGA, STIFFNESS = samples.OMEGA, samples.STIFFNESS
HERTZ = OMEGA / (2 * np.pi)

RHEOCOMPASS = {
    "zh": (
        "项目",
        "测试",
        "结果",
        "区间和数据点",
        "区间数据",
        "点号",
        "时间",
        "角频率",
        "储能模量",
        "损耗模量",
        "剪切应变",
        "温度",
        "无效",
    ),
    "ja": (
        "プロジェクト",
        "テスト",
        "結果",
        "インターバルとデータポイント",
        "インターバルデータ",
        "測定点",
        "時間",
        "角周波数",
        "貯蔵弾性率",
        "損失弾性率",
        "せん断ひずみ",
        "温度",
        "無効",
    ),
    "ru": (
        "Проект",
        "Тест",
        "Результат",
        "Интервал и точки данных",
        "Данные интервала",
        "Точка",
        "Время",
        "Угловая частота",
        "Модуль накопления",
        "Модуль потерь",
        "Деформация сдвига",
        "Температура",
        "недействительно",
    ),
    "pl": (
        "Projekt",
        "Test",
        "Wynik",
        "Przedział i punkty danych",
        "Dane przedziału",
        "Punkt",
        "Czas",
        "Częstotliwość kątowa",
        "Moduł zachowawczy",
        "Moduł stratności",
        "Odkształcenie ścinające",
        "Temperatura",
        "nieprawidłowy",
    ),
    "nl": (
        "Project",
        "Test",
        "Resultaat",
        "Interval en datapunten",
        "Intervalgegevens",
        "Punt",
        "Tijd",
        "Hoekfrequentie",
        "Opslagmodulus",
        "Verliesmodulus",
        "Afschuifvervorming",
        "Temperatuur",
        "ongeldig",
    ),
    "ko": (
        "프로젝트",
        "테스트",
        "결과",
        "구간 및 데이터 포인트",
        "구간 데이터",
        "점",
        "시간",
        "각주파수",
        "저장 탄성률",
        "손실 탄성률",
        "전단 변형률",
        "온도",
        "무효",
    ),
    "cs": (
        "Projekt",
        "Test",
        "Výsledek",
        "Úsek a datové body",
        "Data úseku",
        "Bod",
        "Čas",
        "Úhlová frekvence",
        "Elastický modul",
        "Ztrátový modul",
        "Smyková deformace",
        "Teplota",
        "neplatný",
    ),
}


@pytest.mark.parametrize("language", RHEOCOMPASS)
def test_rheocompass_speaks_further_languages(folder, monkeypatch, language):
    monkeypatch.setitem(samples.WORDS, language, RHEOCOMPASS[language])
    content = samples.rheocompass_full(language)
    assert folder.reader(content) == "rheocompass"
    found = folder.open(content, "#1")
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)
    np.testing.assert_allclose(found.conditions["temperature"], samples.TEMPERATURE)
    np.testing.assert_allclose(found.conditions["amplitude"], samples.STRAIN)
    assert len(folder.open(content, "#2")) == len(OMEGA) - 1, "the point called invalid"


def written(header, *columns, separator=",", decimal="."):
    return header + "\n" + samples.rows(columns, separator, decimal) + "\n"


ANGLE = np.angle(STIFFNESS, deg=True)
J = 1 / STIFFNESS
TABLES = {
    "primes as lone quotes": (
        written("f in Hz;G' in Pa;G\" in Pa", HERTZ, STIFFNESS.real, STIFFNESS.imag, separator=";"),
        1,
    ),
    "a prime at the end of a quoted line": (
        written(
            '"ω [rad/s]"\t"G\'"\tG"\n[rad/s]\t[kPa]\t[kPa]',
            OMEGA,
            STIFFNESS.real,
            STIFFNESS.imag,
            separator="\t",
        ),
        1e3,
    ),
    "LaTeX": (
        written(
            r"$\omega$ [rad/s],$G^{\prime}$ [Pa],$G^{\prime\prime}$ [Pa]",
            OMEGA,
            STIFFNESS.real,
            STIFFNESS.imag,
        ),
        1,
    ),
    "compliances": (
        written("ω [rad/s],J' [1/MPa],J'' [1/MPa]", OMEGA, J.real * 1e6, -J.imag * 1e6),
        1,
    ),
    "parts of the viscosity": (
        written(
            "ω [rad/s],η' [mPa s],η'' [mPa s]",
            OMEGA,
            STIFFNESS.imag / OMEGA * 1e3,
            STIFFNESS.real / OMEGA * 1e3,
        ),
        1,
    ),
    "names in two lines": (
        written(
            '"ω\n[rad/s]","Storage modulus\n[Pa]","Loss modulus\n[Pa]"',
            OMEGA,
            STIFFNESS.real,
            STIFFNESS.imag,
        ),
        1,
    ),
    "stiffness and damping": (
        written(
            "f [Hz],K' [N/mm],Damping coefficient [Ns/mm]",
            HERTZ,
            STIFFNESS.real,
            STIFFNESS.imag / OMEGA,
        ),
        1e3,
    ),
    "dynamic stiffness": (
        written(
            "Frequenz [Hz];Dyn. Steifigkeit [N/mm];Verlustwinkel [°]",
            HERTZ,
            abs(STIFFNESS),
            ANGLE,
            separator=";",
            decimal=",",
        ),
        1e3,
    ),
    "an index before the names": (
        written(",ω [rad/s],G' [Pa],G'' [Pa]", range(5), OMEGA, STIFFNESS.real, STIFFNESS.imag),
        1,
    ),
    "names and units in columns of blanks": (
        written(
            "  omega    G'    G\"    T\n  rad/s    Pa    Pa    °C",
            OMEGA,
            STIFFNESS.real,
            STIFFNESS.imag,
            0 * OMEGA + 25,
            separator="   ",
        ),
        1,
    ),
}


@pytest.mark.parametrize("case", TABLES)
def test_tables_as_programs_write_them(folder, case):
    content, scale = TABLES[case]
    found = folder.open(content)
    np.testing.assert_allclose(found.omega, OMEGA, rtol=1e-9)
    np.testing.assert_allclose(found.stiffness, STIFFNESS, rtol=1e-9)
    assert found.units.stiffness in {1: ("Pa",), 1e3: ("kPa", "N/mm")}[scale]


STATED = {
    "Test 1, T = 25 °C": ("temperature", 25.0),
    "# temperature [K]: 298.15": ("temperature", 25.0),
    "Temperatur: 25,0 °C; Bediener: x": ("temperature", 25.0),
    "Strain amplitude (%) = 0.5": ("amplitude", 0.5),
    "Comment, T = 25": (None, 0.0),
    "Temperature tolerance: 1 °C": (None, 0.0),
    "sample 3, T = 25 min": (None, 0.0),
}


@pytest.mark.parametrize("line", STATED)
def test_a_condition_that_a_line_states(folder, line):
    """With a known unit it is a condition; without one, or of another thing, it is not."""
    name, value = STATED[line]
    found = folder.open(f"{line}\nf [Hz];G' [Pa];G'' [Pa]\n1;2;3\n2;3;4\n")
    assert set(found.conditions) == ({name} if name else set())
    if name:
        np.testing.assert_allclose(found.conditions[name], value)


def test_an_amplitude_sweep_at_a_stated_frequency(folder):
    found = folder.open("Frequency: 2 Hz\n\nStrain [%];G' [Pa];G'' [Pa]\n1;2;3\n2;3;4\n")
    np.testing.assert_allclose(found.frequency, 2.0)
    both = "T = {} °C\nf [Hz];G' [Pa];G'' [Pa]\n1;2;3\n2;3;4\n\n"
    assert folder.open(both.format(25) + both.format(35)).conditions["temperature"].tolist() == [
        25,
        25,
        35,
        35,
    ]


def test_parts_in_other_units_are_converted_to_those_of_the_first(folder):
    first = "f [Hz];G' [Pa];G'' [Pa];Strain [%];Torque [mN m]\n1;2;3;1;1\n2;3;4;1;1\n\n"
    second = "f [Hz];G' [kPa];G'' [kPa];Strain [-];Torque [uN m]\n1;2;3;0,02;1\n2;3;4;0,02;1\n\n"
    found = folder.open(first + second)
    np.testing.assert_allclose(found.storage, [2, 3, 2000, 3000])
    np.testing.assert_allclose(found.conditions["amplitude"], [1, 1, 2, 2])
    assert (found.units.stiffness, found.units.amplitude) == ("Pa", "%")
    assert "torque" not in found.conditions
    assert "torque" in found.provenance["note columns"]
    said = folder.complaint(first + second.replace("kPa", "N/mm"))
    assert "parts come in Pa and N/mm; choose one" in said


def test_standard_deviations_of_several_parts_are_kept(folder):
    part = "f in Hz;G' in Pa;G'' in Pa;storage_sd;loss_sd\n1;2;3;0,1;0,2\n2;3;4;0,1;0,2\n\n"
    assert folder.open(part + part).sd.tolist() == [0.1 + 0.2j] * 4


def test_thousands(folder):
    found = folder.open('f [Hz],"G\' [Pa]","G\'\' [Pa]"\n1,"1,234.5",3.5\n2,"12,345.5","2,000.0"\n')
    np.testing.assert_array_equal(found.stiffness, [1234.5 + 3.5j, 12345.5 + 2000j])
    found = folder.open("f [Hz];G' [Pa];G'' [Pa]\n1;1.234,5;3,5\n2;12.345,5;4,5\n")
    np.testing.assert_array_equal(found.storage, [1234.5, 12345.5])
    assert "write one decimal sign" in folder.complaint(
        "f [Hz];G' [Pa];G'' [Pa]\n1;1.23;3\n2;1,23;3\n"
    )


def test_a_strain_without_unit_beside_names_with_units_is_a_number(folder):
    columns = (HERTZ, STIFFNESS.real, STIFFNESS.imag, 0 * OMEGA + 0.01)
    found = folder.open(
        written("Frequency (Hz),Elastic Modulus (Pa),Viscous Modulus (Pa),Strain", *columns)
    )
    assert found.units.amplitude == "-"
    found = folder.open(written("Frequency (Hz),G' (Pa),G'' (Pa),% strain", *columns))
    assert found.units.amplitude == "%"


def test_logarithms_are_not_taken_for_values(folder):
    found = folder.open(written("log10(ω),log10(G'),log10(G'')", OMEGA, OMEGA, OMEGA))
    assert "'log10(G')', 'log10(G'')' have no unit" in found.provenance["note units"]
    np.testing.assert_allclose(found.omega, 10.0**OMEGA)
    np.testing.assert_allclose(found.storage, 10.0**OMEGA)


def test_a_sweep_at_a_strain_is_no_time_signal(folder):
    content = f"T=25;gamma=0.05;chem=PI;\n{samples.moduli(' ')}\n"
    assert folder.reader(content) == "reptate"
    assert len(folder.open(content)) == len(OMEGA)


SIGNALS = {
    "Instron": (
        '"Total Time (s)","Cycle","Position(Linear:Position) (mm)","Load(Linear:Load) (kN)"\n',
        ",",
    ),
    "MTS": (
        (
            "MTS793|MPT|ENU|1|2\n\nData Header:\tx\n\n"
            "Time\tN\tAxial Displacement\tAxial Force\nSec\t\tmm\tkN\n"
        ),
        "\t",
    ),
    "units in parentheses": ("Running Time,N,Crosshead,Load\n(s),(),(mm),(kN)\n", ","),
    "a report above": (
        "Test report\nOperator: me\n\ntime [s];n;displacement [mm];force [kN]\n",
        ";",
    ),
    "blanks": ("   time[s]  n  disp[mm]   force[kN]\n", "  "),
    "a comment": ("# time [s]  n  displacement [mm]  force [kN]\n", " "),
}


@pytest.mark.parametrize("case", SIGNALS)
def test_signals_as_test_machines_write_them(tmp_path, case):
    head, separator = SIGNALS[case]
    path = tmp_path / "test.txt"
    columns = (samples.TIME, 0 * samples.TIME + 1, samples.MOVED, samples.PULLED)
    path.write_text(head + samples.rows(columns, separator) + "\n")
    plain = tmp_path / "plain.csv"
    plain.write_text(
        "time [s],displacement [mm],force [kN]\n"
        + samples.rows((samples.TIME, samples.MOVED, samples.PULLED))
    )
    found, wanted = (signals_to_measurement([file]) for file in (path, plain))
    assert found.units == wanted.units
    np.testing.assert_array_equal(found.stiffness, wanted.stiffness)
    assert len(open_measurement(path, (), READERS)) == 1
