"""Files as instruments write them: every layout and language, steps, and the header's facts."""

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import Budget
from springpot_plugins.readers import excel

from . import samples
from .samples import OMEGA, STIFFNESS, STRAIN, TEMPERATURE


def same(found, times=1):
    np.testing.assert_allclose(found.omega, np.tile(OMEGA, times), rtol=1e-9)
    np.testing.assert_allclose(found.stiffness, np.tile(STIFFNESS, times), rtol=1e-9)


SHEET = [
    ["ω [rad/s]", "G' [Pa]", "G'' [Pa]"],
    *np.stack([OMEGA, STIFFNESS.real, STIFFNESS.imag]).T.tolist(),
]
LAYOUTS = {
    "rheocompass": samples.rheocompass_short,
    "trios": samples.trios,
    "trios-json": lambda: samples.trios_json(official=False),
    "malvern": samples.malvern,
    "reptate": samples.reptate,
    "excel": lambda: samples.xlsx({"S": SHEET}),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_each_layout_is_recognised_and_read_without_options(folder, name):
    content = LAYOUTS[name]()
    assert folder.reader(content) == name
    same(folder.open(content))


# The suite has each language and each way of writing numbers, the soak all pairs.
@pytest.mark.soak_cases(
    *(
        f"{separators}-{language}"
        for separators in ("\\t-.", ";-,", ",-.")
        for language in samples.WORDS
        if language != "en"
    )
)
@pytest.mark.parametrize("language", samples.WORDS)
@pytest.mark.parametrize(
    ("separator", "decimal"), [("\t", ","), ("\t", "."), (";", ","), (",", ".")]
)
def test_full_rheocompass_exports_in_five_languages(folder, language, separator, decimal):
    content = samples.rheocompass_full(language, separator, decimal)
    assert folder.reader(content) == "rheocompass"
    found = folder.open(content, "#1")
    same(found)
    assert found.conditions["temperature"].tolist() == [TEMPERATURE] * 5
    assert found.conditions["amplitude"].tolist() == [STRAIN] * 5
    assert found.units.amplitude == "%"
    assert [part.name for part in folder.parts(content)] == ["FS 1 interval 1", "FS 1 interval 2"]
    # The instrument calls the first point of the second interval invalid.
    np.testing.assert_allclose(folder.open(content, "#2").omega, OMEGA[1:])
    assert len(folder.open(content)) == 9


def test_rheoplus(folder):
    content = samples.rheoplus()
    assert folder.reader(content) == "rheocompass"
    found = folder.open(content)
    same(found)
    assert found.conditions["temperature"].tolist() == [TEMPERATURE] * 5


def test_rheocompass_says_which_test(folder):
    found = folder.open(samples.rheocompass_short())
    assert found.provenance["result"] == "Frequency sweep 10C"
    assert found.provenance["test"] == "a gel(0,3%), x"


@pytest.mark.parametrize("separator", [",", "\t"])
def test_trios_lists_its_steps_and_reads_the_oscillatory_one(folder, separator):
    content = samples.trios(separator)
    parts = folder.parts(content)
    assert [(part.name, part.points, part.usable) for part in parts] == [
        ("Peak hold - 1", 2, False),
        ("Frequency sweep - 2", 5, True),
    ]
    found = folder.open(content)
    same(found)
    assert found.conditions["amplitude"].tolist() == [STRAIN] * 5
    with pytest.raises(
        DataError, match="part 'Peak hold - 1' is no dynamic test: found Stress, Shear rate"
    ):
        folder.open(content, "#1")


def test_what_a_header_says_of_inertia_compliance_and_friction(folder):
    said = folder.open(samples.trios()).provenance
    assert said["instrument.inertia"] == "22.5 µN.m.s²"
    assert said["geometry.inertia"] == "7.5 µN.m.s²"
    assert said["geometry.gap"] == "1000 µm"
    assert said["geometry.diameter"] == "40.0 mm"
    # (22.5 + 7.5) 1e-6 kg m^2 x 80000 Pa/(N m) / (20 1/rad), and so on.
    assert said["inertia as modulus"] == "0.12 Pa s^2"
    assert said["friction as viscosity"] == "0.0012 Pa s"
    assert said["compliance as modulus"] == "4e+06 Pa"


def test_lims_joins_its_steps_and_takes_the_measured_strain(folder):
    content = samples.trios_lims()
    assert folder.reader(content) == "trios-lims"
    found = folder.open(content)
    same(found, times=2)
    assert found.conditions["temperature"].tolist() == [20.0] * 5 + [30.0] * 5
    assert set(found.conditions["amplitude"]) == {STRAIN}
    assert set(found.labels["step"]) == {"Frequency sweep (20.0 °C)", "Frequency sweep (30.0 °C)"}
    assert found.provenance["compliance as modulus"] == "4e+06 Pa"
    assert found.provenance["note parts"].startswith("2 of 2 parts together")
    same(folder.open(content, "#2"))
    same(folder.open(content, "#30.0"))
    same(folder.open(content, "@temperature=30"))


def test_official_json_has_named_steps(folder):
    content = samples.trios_json()
    assert folder.reader(content) == "trios-json"
    same(folder.open(content), times=2)
    assert [part.name for part in folder.parts(content)] == ["first sweep", "second sweep"]
    found = folder.open(content, "#second")
    same(found)
    assert found.provenance["instrument.inertia"] == "20.5 µN.m.s²"
    assert found.provenance["sample"] == "gel"


def test_malvern_actions(folder):
    content = samples.malvern()
    assert [(part.name, part.usable) for part in folder.parts(content)] == [
        ("Pre Shear", False),
        ("Frequency Table", True),
    ]
    found = folder.open(content)
    assert found.conditions["amplitude"].tolist() == [0.5] * 5
    assert found.conditions["gap"].tolist() == [1.0] * 5
    assert found.provenance["unit gap"] == "mm"


@pytest.mark.parametrize("units", [False, True])
def test_reptate_with_and_without_a_row_of_units(folder, units):
    found = folder.open(samples.reptate(units))
    same(found)
    assert found.conditions["temperature"].tolist() == [-35.0] * 5
    assert found.provenance["reptate.Mw"] == "23.4"


def test_reptate_without_names_and_with_a_temperature_column(folder):
    same(folder.open("Mw=1;T=0;\n" + samples.moduli(" ")))
    columns = (OMEGA, STIFFNESS.real, STIFFNESS.imag, 0 * OMEGA + 21.5, 0 * OMEGA + 0.9)
    text = (
        "T=0;Mw=94.9;chem=PI;\nFreq\tG'\tG\"\tTemp\tStrain\nrad/s\tPa\tPa\t°C\t%\n"
        + samples.rows(columns, "\t")
    )
    found = folder.open(text.encode("latin-1"))
    assert found.conditions["temperature"].tolist() == [21.5] * 5
    assert found.conditions["amplitude"].tolist() == [0.9] * 5


def test_viscoanalysis_workbook(folder):
    found = folder.open(samples.xlsx())
    assert found.units.stiffness == "MPa"
    np.testing.assert_allclose(found.stiffness * 1e6, STIFFNESS, rtol=1e-9)
    assert found.conditions["temperature"].tolist() == [TEMPERATURE] * 5


def test_sheets_are_parts(folder):
    content = samples.xlsx(
        {"Notes": [["Sample", "a gel"]], "One": SHEET, "Two": [["a remark"], [], *SHEET]}
    )
    assert [part.name for part in folder.parts(content)] == ["One", "Two"]
    same(folder.open(content), times=2)
    same(folder.open(content, "#Two"))
    assert folder.open(content, "@step=One").provenance["format"] == "Excel"


def test_what_is_no_workbook(folder):
    for content, message in (
        (b"PK\x03\x04" + bytes(60), "no readable Excel file"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600), "export the results as .xlsx or CSV"),
        (samples.xlsx()[:3000], "no readable Excel file"),
    ):
        with pytest.raises(DataError, match=message):
            folder.open(content, name="data.xlsx")


def test_a_workbook_that_unpacks_to_far_too_much(folder, tmp_path, monkeypatch):
    import zipfile

    monkeypatch.setattr(excel, "budget_of", lambda path: Budget(1.0, 1_000_000))
    path = tmp_path / "bomb.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("[Content_Types].xml", "x")
        book.writestr("xl/worksheets/sheet1.xml", bytes(5_000_000))
    with pytest.raises(DataError, match="unpacks to 5000001 bytes"):
        folder.open(path.read_bytes(), name="copy.xlsx")


def test_a_binary_file_is_refused_in_one_line(folder):
    with pytest.raises(DataError, match="no reader recognises"):
        folder.open(bytes(range(256)) * 10)


@pytest.mark.parametrize("cut", [0.2, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("name", [*LAYOUTS, "lims", "json", "full"])
def test_files_that_are_cut_off(folder, name, cut):
    others = {
        "lims": samples.trios_lims,
        "json": samples.trios_json,
        "full": samples.rheocompass_full,
    }
    content = (LAYOUTS | others)[name]()
    assert "\n" not in folder.complaint(content[: int(len(content) * cut)])


@pytest.mark.parametrize("name", [*LAYOUTS, "lims", "json", "full"])
def test_what_an_instrument_wrote_survives_writing_and_reading(folder, tmp_path, name):
    from springpot.registry import write_measurement

    others = {
        "lims": samples.trios_lims,
        "json": samples.trios_json,
        "full": samples.rheocompass_full,
    }
    first = folder.open((LAYOUTS | others)[name]())
    again = folder.open(
        write_measurement(first, tmp_path / "out.csv").read_bytes(), name="again.csv"
    )
    assert again.omega.tobytes() == first.omega.tobytes()
    assert again.stiffness.tobytes() == first.stiffness.tobytes()
    assert {key: column.tolist() for key, column in again.conditions.items()} == {
        key: column.tolist() for key, column in first.conditions.items()
    }
    assert dict(again.provenance) == dict(first.provenance)
    assert (again.name, again.units) == (first.name, first.units)
