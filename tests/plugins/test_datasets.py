"""The built-in data sets: cheap to list, right when loaded, honest about what was measured."""

import os
from pathlib import Path

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import PROMISED, open_measurement, select
from springpot_plugins.datasets import folders, shipped, springpot_datasets
from springpot_plugins.datasets.shipped import TRUTH

SHARED = Path(
    os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0]
    or Path(__file__).parents[3] / "shared" / "data"
)
needs_shared = pytest.mark.skipif(
    not SHARED.is_dir(), reason="no shared data beside the checkout (SPRINGPOT_DATA)"
)


@pytest.fixture
def without_folders(monkeypatch):
    monkeypatch.delenv(folders.VARIABLE, raising=False)


def opened(spec):
    return open_measurement(spec, springpot_datasets(), ())


def test_names_are_unique_and_kinds_are_said(without_folders):
    sets = list(springpot_datasets())
    assert len({data.name for data in sets}) == len(sets)
    for data in sets:
        first = data.name.partition("-")[0]
        assert data.kind == (first if first in ("artificial", "reconstruction") else "measured")
        assert data.summary
        assert data.citation
        assert data.licence


def test_every_available_set_loads_with_the_size_that_is_listed(without_folders):
    for data in springpot_datasets():
        if data.where == "here":
            measured = data.open()
            assert len(measured) == data.size
            assert measured.name == data.name


def kelvin(omega):
    """Eq. (22) in real numbers, independent of the algebra."""
    k, c, a = 400.0, 150.0, 0.6
    power = c * omega**a
    return k + power * np.cos(a * np.pi / 2), power * np.sin(a * np.pi / 2)


def test_artificial_kelvin_data_are_those_of_eq_22():
    found = opened("artificial-fractional-kelvin")
    np.testing.assert_allclose(found.frequency, np.arange(0.5, 14, 1.0))
    storage, loss = kelvin(found.omega)
    np.testing.assert_allclose(found.storage, storage, rtol=1e-13)
    np.testing.assert_allclose(found.loss, loss, rtol=1e-13)
    assert found.units.stiffness == "kN/m"


@pytest.mark.parametrize("model", TRUTH)
def test_noise_has_its_seed_its_size_and_its_sides(model):
    exact = opened(f"artificial-{model}")
    one, again = opened(f"artificial-{model}-noise1"), shipped.artificial(model, 0.01)
    assert one.stiffness.tobytes() == again.stiffness.tobytes()
    assert one.stiffness.tobytes() != shipped.artificial(model, 0.01, seed=1).stiffness.tobytes()
    for name, bound in (
        ("noise1", 0.011),
        ("noise2", 0.022),
        ("symmetric1", 0.022),
        ("symmetric2", 0.045),
    ):
        error = np.abs(opened(f"artificial-{model}-{name}").stiffness / exact.stiffness - 1)
        assert 0.1 * bound < error.max() < bound
    with pytest.raises(DataError, match="no artificial data"):
        shipped.artificial("maxwell")


def test_makris_reconstruction_is_eq_54():
    found = opened("reconstruction-makris-1992")
    s = 1j * found.omega
    np.testing.assert_allclose(found.stiffness, 15.0 * s / (1 + 0.3 * s**0.6), rtol=1e-12)
    assert found.frequency.max() == pytest.approx(50.0)


def test_fluid_reconstructions_follow_eq_29_and_30():
    found = opened("reconstruction-pdms-table6-7")
    e, eta, a = 30474.4, 1781.8, 0.8937
    power = (eta / e) * found.omega**a
    below = 1 + 2 * power * np.cos(a * np.pi / 2) + power**2
    np.testing.assert_allclose(
        found.storage, e * power * (power + np.cos(a * np.pi / 2)) / below, rtol=1e-12
    )
    np.testing.assert_allclose(found.loss, e * power * np.sin(a * np.pi / 2) / below, rtol=1e-12)
    assert found.frequency.min() == pytest.approx(0.3)
    assert found.frequency.max() == pytest.approx(5.0)
    assert "not measured" in found.provenance["source"]


def test_an_absent_branch_in_table_4_is_its_limit():
    for name in ("standard", "zener"):
        found = opened(f"reconstruction-pdms-table4-{name}")
        assert np.isfinite(found.stiffness).all()
    assert len(shipped._reconstructions()) == 1 + 4 + 3 + 6 + 7


def test_nist_fluid_has_uncertainties_temperatures_and_the_printed_values():
    found = opened("nist-srm2491@temperature=20")
    assert len(found) == 16
    assert found.omega[0] == 0.1
    assert found.stiffness[0] == 1.124 + 96.363j
    assert found.sd[0] == 0.329 + 1.281j
    assert "10.6028/NIST.SP.260-147" in found.provenance["citation"]
    whole = shipped._of_nist()[0].open()
    assert np.unique(whole.conditions["temperature"]).tolist() == [0, 10, 20, 30, 40, 50]
    assert np.median(np.abs(whole.conditions["nist_storage"] / whole.storage - 1)) < 0.02


def test_rheodata_is_offered_or_said_to_be_missing(monkeypatch):
    monkeypatch.setattr(shipped, "find_spec", lambda name: None)
    for data in shipped._of_rheodata():
        assert "pip install" in data.unavailable
        with pytest.raises(DataError, match="pip install"):
            data.open()


def test_rheodata_frequency_sweep():
    pytest.importorskip("rheodata")
    found = opened("rheodata-linear-polymer-frequency-sweep")
    assert found.omega.min() == pytest.approx(0.1, rel=1e-3)
    assert found.units.amplitude == "%"


def test_choosing_rows():
    whole = shipped._of_nist()[0].open()
    assert len(select(whole, {"temperature": "20.3"})) == 16
    with pytest.raises(
        DataError, match=r"no temperature near 25 \(there are: 0, 10, 20, 30, 40, 50\)"
    ):
        select(whole, {"temperature": "25"})
    with pytest.raises(DataError, match="no condition 'colour'"):
        select(whole, {"colour": "red"})
    with pytest.raises(DataError, match="is no number"):
        select(whole, {"temperature": "warm"})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A data directory with one set."""
    place = tmp_path / "my-damper"
    place.mkdir()
    (place / "raw.csv").write_text(
        'f;Ks;Kl;bath;what\n1;2;3;20;"Lane 1 (new)"\n2;3;4;20;"Lane 10 (new)"\n'
    )
    monkeypatch.setenv(folders.VARIABLE, str(tmp_path))
    return place


MANIFEST = """
summary = "a damper"
file = "raw.csv"
licence = "CC0"
accuracy = "1%,3mrad"
physics = ["friction"]
[columns]
frequency = { from = "f", unit = "Hz" }
storage = { from = "Ks", unit = "kN/m" }
loss = { from = "Kl", unit = "kN/m" }
temperature = { from = "bath", unit = "degC" }
lane = { from = "what", extract = 'Lane (\\d+)' }
what = "what"
[conditions]
"amplitude [mm]" = 2
"""


def test_a_folder_with_a_manifest_is_a_data_set(folder):
    (folder / "dataset.toml").write_text(MANIFEST)
    found = opened("my-damper")
    np.testing.assert_array_equal(found.stiffness, [2 + 3j, 3 + 4j])
    np.testing.assert_array_equal(found.conditions["lane"], [1, 10])
    np.testing.assert_array_equal(found.conditions["amplitude"], [2, 2])
    assert found.units.amplitude == "mm"
    assert found.provenance["licence"] == "CC0"
    assert found.provenance[PROMISED] == "1%,3mrad"
    assert len(opened("my-damper@what=Lane 1")) == 1
    assert len(opened("my-damper@lane=10,temperature=20")) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("file = ", "dataset.toml"),
        ('file = "raw.csv"', "missing storage .* among the columns f, Ks, Kl"),
        ('file = "raw.csv"\n[columns]\nomega = 3', "column 'omega' needs"),
        (MANIFEST.replace("Ks", "Kx"), "no column 'Kx'"),
        (MANIFEST.replace("raw.csv", "gone.csv"), "missing"),
        (MANIFEST.replace("(\\d+)", "(\\d+"), "pattern"),
        (MANIFEST.replace("licence", "license"), "check license"),
    ],
)
def test_a_faulty_manifest_is_named_and_spoils_nothing_else(folder, text, message):
    (folder / "dataset.toml").write_text(text)
    assert len(opened("artificial-springpot")) == 14
    with pytest.raises(DataError, match=message):
        opened("my-damper")


def test_directories_that_are_not_there_hold_nothing(monkeypatch):
    monkeypatch.setenv(folders.VARIABLE, os.pathsep.join(["/nowhere/at/all", "", "~nobody"]))
    assert {data.where for data in folders.datasets()} <= {"missing", "download"}


@needs_shared
def test_every_shipped_manifest_opens_its_folder(monkeypatch):
    monkeypatch.setenv(folders.VARIABLE, str(SHARED))
    found = {data.name: data for data in folders.datasets()}
    shipped = {path.stem for path in (Path(folders.__file__).parent / "manifests").glob("*.toml")}
    assert shipped & {path.name for path in SHARED.iterdir()} == set(found)
    for data in found.values():
        measured = data.open()
        assert len(measured) == data.size
        assert np.isfinite(measured.stiffness).all()
        assert data.licence
        assert data.physics


@needs_shared
@pytest.mark.parametrize(
    ("spec", "rows"),
    [
        ("fhwa-ptf-binder-dsr@lane=1,temperature=46,repeat=1", 31),
        ("friction-damper-brfd-lehigh@band_tension=36", 10),
        ("mr-damper-utfsm-sinusoid@current=0.5", 6),
        ("elastomer-epdm-70-dma-payne@run=sd_10hz", 15),
        ("hermes-multi-technique@step=frequency", 29),
        ("reptate-polyisoprene-osc@molar_mass=94.9", 170),
    ],
)
def test_conditions_of_the_shared_sets(monkeypatch, spec, rows):
    monkeypatch.setenv(folders.VARIABLE, str(SHARED))
    assert len(opened(spec)) == rows


@pytest.mark.soak
@needs_shared
def test_friction_signals_agree_with_the_table_of_their_harmonics(monkeypatch):
    """43 records: first harmonics within a few per cent of an independent fit.

    Their frequencies are nearer to the nominal ones.
    """
    from springpot.registry import signals_to_measurement

    place = SHARED / "friction-damper-brfd-lehigh" / "signals"
    if not place.is_dir():
        pytest.skip("no signals in the shared data")
    monkeypatch.setenv(folders.VARIABLE, str(SHARED))
    table = opened("friction-damper-brfd-lehigh")
    row = {
        name.replace("/", "_").removesuffix(".json"): i
        for i, name in enumerate(table.labels["file"].tolist())
    }
    found = signals_to_measurement(sorted(place.glob("*.csv")))
    where = [row[name] for name in found.labels["file"].tolist()]
    error = np.abs(found.stiffness / table.stiffness[where] - 1)
    assert np.median(error) < 0.03
    assert error.max() < 0.08
    nominal = table.conditions["nominal_frequency"][where]
    assert np.median(np.abs(found.frequency / nominal - 1)) < 5e-4
