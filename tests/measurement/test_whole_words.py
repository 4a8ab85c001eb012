"""What is read out of names, answers and units, and how it is written."""

import numpy as np
import pytest

from springpot.errors import SpringpotError
from springpot.measurement import Measurement, Units
from springpot.measurement.conversion import joined
from springpot.measurement.opening import _below_remarks, _files_like
from springpot.measurement.reader import columns_of, temperature_offer, with_part
from springpot.measurement.timenoise import relative_scatter
from springpot.registry import plugins
from springpot.rheology.model import Family
from springpot.writing import guarded, guarded_line, unguarded

OMEGA = np.geomspace(0.5, 60.0, 9)
NAMES = (
    "gel_20C.csv gel-20C.csv T=-5degC.csv 293K.csv PS5K.csv run_68F.csv T25.csv temp_-3.5.csv"
    " gel.csv"
    " gel_20,5_C.csv 1000C.csv v2C3.csv 99.9K.csv 100K.csv a7.csv b130.csv b145.csv b160.csv"
    " c1.csv c2.csv c3.csv d10.csv d15.csv d20.csv d24.csv e10.csv e20.csv"
)


def answer(ask, *about, **how):
    """What is answered, or why nothing is."""
    try:
        return ask(*about, **how)
    except SpringpotError as error:
        return str(error)


@pytest.fixture
def here(tmp_path, monkeypatch):
    for name in NAMES.split():
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_temperatures_in_names(here, stays):
    told = {path.name: temperature_offer(path.relative_to(here)) for path in sorted(here.iterdir())}
    stays(told)


def test_files_of_nearly_the_name(here, stays):
    asked = ["gel", "gel_20", "c1.cvs", "b13.csv", "nothing-of-the-kind", "no/such/folder", "\0"]
    stays({name: _files_like(name) for name in asked})


def test_answers_about_columns(stays):
    said = ["frequency=Hz,3=loss[Pa]", "f=Hz,f=Hz", "f=", "=Hz", "f", "", " a = b , c=d "]
    texts = ["a.csv", "a.csv?b=c", "a.csv@x=1", "a.csv?b=c@x=1"]
    lines = ["", "# only", "\ufeff# a\n\n 1,2", "a\nb", "\t#x\r\n=1"]
    stays(
        {
            "columns": [answer(columns_of, each, "a.csv") for each in said],
            "part": [with_part(text, 2) for text in texts],
            "below": [_below_remarks([line.encode()]).decode() for line in lines],
        }
    )


CELLS = ["=1+1", "+a", "-1.5e3", "-a", "@x", "-", "+", "a", "", "\\tb", "'=1"]


def test_a_cell_is_guarded_where_a_spreadsheet_would_run_it_and_comes_back(stays):
    assert [unguarded(guarded(cell)) for cell in CELLS] == CELLS
    stays([[guarded(cell), guarded_line(f"x,{cell};7")] for cell in CELLS])


UNITS = {
    "damper in mm": Units("N/mm", "mm"),
    "damper in kN": Units("kN/m", "mm"),
    "damper in m": Units("N/m", "m"),
    "kPa": Units("kPa", "-"),
    "MPa of %": Units("MPa", "%"),
    "torsion": Units("N m/rad", "deg"),
}


@pytest.mark.parametrize("name", list(UNITS))
def test_units_of_all_parameters_of_models_and_effects(name, stays):
    units, found = UNITS[name], {}
    for kind in ("model", "effect"):
        for item in plugins().items(kind):
            known = item.build(2) if isinstance(item, Family) else item
            node = known.network if kind == "model" else known.element
            found[item.name] = [answer(units.of, each.unit) for each in node.parameters]
    stays(found)


def sweep(name, units=UNITS["kPa"], seed=1, by=1.0, **more):
    scatter = np.random.default_rng(seed).normal(size=(2, 9))
    k = by * (1j * OMEGA) ** 0.4 * np.exp(0.02 * (scatter[0] + 1j * scatter[1]))
    return Measurement(OMEGA, k, units=units, name=name, **more)


def some():
    sd = np.full(9, 0.1 + 0.2j)
    mm, strain = {"amplitude": np.linspace(1.0, 2.0, 9)}, {"amplitude": np.full(9, 0.01)}
    warm, pressed = {"temperature": np.full(9, 20.0)}, {"pressure": np.arange(9.0)}
    twice = np.repeat([4, 5, 6], 3)
    pa, damper = Units("Pa", "-"), Units("N/mm", "mm")
    return {
        "units": [sweep("a"), sweep("b", pa, by=1e3)],
        "deviations": [sweep("a", sd=sd), sweep("b", pa, sd=1e3 * sd)],
        "deviations of one": [sweep("a", sd=sd), sweep("b", seed=2)],
        "repeats": [
            *(sweep("a", repeat=twice), sweep("b", seed=2)),
            sweep("c", seed=3, repeat=twice),
        ],
        "copies": [sweep("a"), sweep("b", seed=2), sweep("c")],
        "amplitudes": [
            sweep("a", damper, conditions=mm),
            sweep("b", Units("kN/m", "m"), conditions={"amplitude": 1e-3 * mm["amplitude"]}),
        ],
        "strain and length": [
            sweep("a", Units("kPa", "mm"), conditions=mm),
            sweep("b", conditions=strain),
        ],
        "temperature of one": [sweep("a", conditions=warm), sweep("b")],
        "temperature of the other": [sweep("a"), sweep("b", conditions=warm | strain)],
        "pressure of one": [sweep("a", conditions=pressed | warm), sweep("b", conditions=warm)],
        "stiffness and modulus": [sweep("a"), sweep("b", damper)],
        "E and G": [
            sweep("a", Units("kPa", "-", letter="E")),
            sweep("b", Units("kPa", "-", letter="G")),
        ],
        "E and untold": [sweep("a"), sweep("b", Units("Pa", "-", letter="E"))],
    }


@pytest.mark.parametrize("case", list(some()))
def test_files_as_one(case, stays):
    found = answer(joined, some()[case])
    if isinstance(found, Measurement):
        found = {
            "K": found.stiffness,
            "sd": found.sd,
            "conditions": dict(found.conditions),
            "repeat": found.repeat,
            "units": found.units,
            "told": [found.name, dict(found.provenance)],
            "labels": {name: column.tolist() for name, column in found.labels.items()},
        }
    stays(found)


def test_scatter_of_neighbours(stays):
    warm = {"temperature": np.full(9, 20.0)}
    two = joined([sweep("a", seed=2, conditions=warm), sweep("b", seed=3, conditions=warm)])
    cases = {"one": sweep("a"), "two": two, "short": sweep("a").subset(np.arange(9) < 3)}
    stays({name: answer(relative_scatter, each) for name, each in cases.items()})
