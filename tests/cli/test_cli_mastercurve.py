"""``springpot mastercurve``."""

import numpy as np
import pytest

import springpot as package

pytestmark = pytest.mark.usefixtures("asked_once")


@pytest.mark.soak
def test_the_text_has_factors_laws_and_a_verdict(springpot):
    answer = springpot("mastercurve", "nist-srm2491", "--reference", "20degC")
    assert answer.code == 0
    for words in (
        "master curve of nist-srm2491 at 20 degC",
        "Arrhenius",
        "WLF",
        "VFT",
        "superposition   one curve",
    ):
        assert words in answer.out


@pytest.mark.soak
def test_json_is_the_same_as_in_python(springpot):
    told = springpot("mastercurve", "nist-srm2491", "--json").json
    found = package.mastercurve("nist-srm2491")
    assert told["schema"] == "springpot.mastercurve/1"
    assert [level["a"] for level in told["levels"]] == [level.a for level in found.levels]


@pytest.mark.soak
def test_the_reduced_data_open_again(springpot, tmp_path):
    path = tmp_path / "curve.csv"
    assert springpot("mastercurve", "nist-srm2491", "-o", str(path)).code == 0
    again = package.read(path)
    assert len(again) == 96
    assert springpot("identify", str(path), "--model", "maxwell-3").code == 0


@pytest.mark.soak
def test_a_picture(springpot, tmp_path):
    path = tmp_path / "curve.png"
    answer = springpot("mastercurve", "nist-srm2491", "--no-vertical", "--figure", str(path))
    assert answer.code == 0
    assert path.stat().st_size > 10_000


@pytest.mark.soak
def test_the_picture_tells_frequencies_and_moduli_as_the_data_came():
    pytest.importorskip("matplotlib")
    omega = np.tile(2.0 * np.pi * np.geomspace(0.1, 10.0, 6), 2)
    warm = np.repeat([20.0, 30.0], 6)
    zener = package.parse_model("zener")
    known = zener.stiffness(zener.theta(k1=1.0, k2=2.0, c=3.0), omega * 0.5 ** (warm == 30.0))
    units = package.Units("MPa", letter="E")
    heated = package.Measurement(omega, known, conditions={"temperature": warm}, units=units)
    axes = package.mastercurve(heated).plot().axes
    assert [one.get_ylabel() for one in axes[:2]] == ["E' / b [MPa]", "E'' / b [MPa]"]
    assert axes[0].get_xlabel() == "a f [Hz]"
    assert axes[0].collections[0].get_offsets()[:, 0].max() == pytest.approx(10.0, rel=0.01)
    assert "factors b of modulus" in [one.get_title(loc="left") for one in axes]


def test_bad_input_is_one_line(springpot):
    assert springpot("mastercurve", "nist-srm2491", "--column", "water").is_one_line(
        "water", "temperature"
    )
    assert springpot("mastercurve", "nist-srm2491", "--reference", "hot").is_one_line("25degC")
