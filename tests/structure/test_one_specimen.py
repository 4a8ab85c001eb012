"""A damper that is one specimen of a fit in which each has parameters of its own."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.structure.reading import read_structure

OMEGA = 2.0 * np.pi * np.geomspace(0.5, 20.0, 10)
FRAME = '[structure]\nmass = 1e5\nstiffness = 8e7\n[[damper]]\nfit = "fit.json"\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dampers")
    model, rng = springpot.parse_model("kelvin"), np.random.default_rng(1)
    sweeps = []
    for number, k in enumerate((100.0, 120.0), 1):
        exact = model.stiffness(model.vector({"k": k, "c": 2.0}), OMEGA)
        noise = 1.0 + 0.01 * rng.normal(size=(10, 2)) @ [1.0, 1.0j]
        units = springpot.Units("kN/m", "mm")
        sweeps.append(springpot.Measurement(OMEGA, exact * noise, units=units, name=f"S{number}"))
    fit = springpot.identify(sweeps, "kelvin", own={"k": "file"})
    (folder / "fit.json").write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    return folder


def damper(folder, at):
    path = folder / "frame.toml"
    path.write_text(FRAME + at, encoding="utf-8")
    return read_structure(path).dampers[0]


@pytest.mark.parametrize(("name", "k"), [("S1", 100.0), ("S2", 120.0)])
def test_a_specimen_is_chosen_by_its_name(folder, name, k):
    found = damper(folder, f'at = {{ file = "{name}" }}')
    assert found.model.names == ("k", "c")
    assert found.theta[0] == pytest.approx(k, rel=0.02)
    # What is not known of it is that of this specimen and what all share.
    assert found.covariance.shape == (2, 2)
    assert 0.0 < np.sqrt(found.covariance[0, 0]) < 0.02 * k


@pytest.mark.parametrize(
    ("at", "says"),
    [
        ("", "damper 1.* each file has parameters of its own: say which, file=S1"),
        ('at = { file = "S9" }', r"file has no 'S9': there are (S\d, )*S\d$"),
        ("at = 3", "at says which specimen of several"),
    ],
)
def test_a_specimen_that_is_none_is_refused_in_one_line(folder, at, says):
    with pytest.raises(DataError, match=says):
        damper(folder, at)
