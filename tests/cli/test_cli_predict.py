"""``springpot predict``: from the JSON of a fit to another test."""

import numpy as np
import pytest

import springpot as library
from springpot.cli.predict import table_text

pytestmark = pytest.mark.usefixtures("asked_once")


@pytest.fixture
def fit(springpot, damper, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(springpot("identify", damper, "-m", "fractional-maxwell", "--json").out)
    return path


def test_numbers_table_and_picture_agree(springpot, fit, tmp_path):
    pytest.importorskip("matplotlib")
    table, picture = tmp_path / "predicted.csv", tmp_path / "predicted.png"
    answer = springpot("predict", fit, "--frequency", "0,1,5", "--json").json
    assert answer["schema"] == "springpot.prediction/2"
    assert [row["storage"] > row["storage_low"] for row in answer["points"][1:]] == [True, True]
    assert answer["points"][0]["storage"] == 0.0
    told = springpot("predict", fit, "--frequency", "1..10", "-o", table, "--figure", picture)
    assert (told.code, told.err) == (0, "")
    assert "storage [kN/m]" in told.out
    again = library.read(table)
    assert len(again) == 25
    assert again.units.stiffness == "kN/m"
    assert again.storage[0] == pytest.approx(answer["points"][1]["storage"], rel=1e-12)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.soak_cases("--frequency-frequency [Hz]-2.0")
@pytest.mark.parametrize(
    ("asked", "title", "at"),
    [("--omega", "omega [rad/s]", 2.0), ("--frequency", "frequency [Hz]", 2.0)],
)
def test_an_answer_is_told_in_the_frequencies_that_were_asked(
    springpot, fit, tmp_path, asked, title, at
):
    table = tmp_path / "predicted.csv"
    told = springpot("predict", fit, asked, "2,3000", "-o", table)
    unit = title.partition("[")[2].rstrip("]")
    assert title in told.out
    other = {"rad/s": "Hz", "Hz": "rad/s"}[unit]
    assert f" {other}" not in told.out.replace(title, "")
    head, first, *_ = table.read_text().split("\n")
    ends = [f"{part}_{end} [kN/m]" for part in ("storage", "loss") for end in ("low", "high")]
    assert head.split(",") == [title, "storage [kN/m]", "loss [kN/m]", *ends, "measured [text]"]
    assert float(first.split(",")[0]) == pytest.approx(at)


@pytest.mark.soak_cases(
    "options0---frequency (hz) or --omega", "options3---frequency (hz) or --omega"
)
@pytest.mark.parametrize(
    ("options", "says"),
    [
        ((), "--frequency (hz) or --omega"),
        (("--frequency", "1..x"), "a range such as 0.1..100"),
        (("--frequency", "1", "--temperature", "20"), "does not know temperature"),
        (("--frequency", "1", "--omega", "1"), "--frequency (hz) or --omega"),
    ],
)
def test_what_cannot_be_asked_is_one_line(springpot, fit, options, says):
    assert springpot("predict", fit, *options).is_one_line(says)


def test_only_a_fit_predicts(springpot, damper, tmp_path):
    assert springpot("predict", damper, "--frequency", "1").is_one_line("no json")
    path = tmp_path / "comparison.json"
    path.write_text(springpot("compare", damper, "-m", "fractional-kelvin", "--json").out)
    assert springpot("predict", path, "--frequency", "1").is_one_line("is no fit")


def test_points_outside_of_what_was_measured_are_marked_and_told_once(springpot, fit, tmp_path):
    """The damper was measured from 0.5 to 100 Hz."""
    table = tmp_path / "predicted.csv"
    asked = ["predict", fit, "--frequency", "0.001,1,5000"]
    told = springpot(*asked, "-o", table)
    assert told.out.count("beyond the measured") == 1
    assert "2 of 3 points" in told.out
    rows = table.read_text().splitlines()
    assert [row.rpartition(",")[2] for row in rows] == [
        "measured [text]",
        "outside",
        "within",
        "outside",
    ]
    assert library.read(table).labels["measured"].tolist() == ["outside", "within", "outside"]
    answer = springpot(*asked, "--json").json
    assert [point["outside_measured"] for point in answer["points"]] == [True, False, True]
    assert answer["measured"]["omega"][0] < 2 * 3.1416
    inside = springpot("predict", fit, "--frequency", "1,2")
    assert "outside" not in inside.out
    assert "beyond" not in inside.out


def test_frequencies_and_moduli_are_told_as_the_data_came(tmp_path):
    pytest.importorskip("matplotlib")
    omega = np.geomspace(0.1, 10.0, 8)
    model = library.parse_model("zener")
    known = model.stiffness(model.theta(k1=1.0, k2=2.0, c=3.0), omega)
    units = library.Units("MPa", clock="rad/s", letter="E")
    fit = library.identify(library.Measurement(omega, known, units=units), model)
    axes = fit.predict(omega=[1.0, 2.0, 4.0]).plot().axes[0]
    assert axes.get_xlabel() == "angular frequency ω [rad/s]"
    assert axes.lines[0].get_xdata().tolist() == pytest.approx([1.0, 2.0, 4.0])
    assert axes.get_ylabel() == "E', E'' [MPa]"
    table = table_text(fit.predict(frequency=[1.0]))
    assert table.startswith("frequency [Hz],E' [MPa],E'' [MPa],storage_low [MPa]")
