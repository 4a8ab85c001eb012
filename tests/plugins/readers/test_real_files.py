"""Real files, where there are any: each opens with one command and no options."""

import os
from pathlib import Path

import numpy as np
import pytest

from springpot.measurement import open_measurement, parts_of

from .conftest import READERS

FOLDERS = [
    *os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep),
    Path(__file__).parents[4] / "shared" / "data",
]


def found(name):
    path = next((Path(f) / name for f in FOLDERS if str(f) and (Path(f) / name).exists()), None)
    if path is None:
        pytest.skip(f"{name} is not here; name its folder by SPRINGPOT_DATA")
    return path


FILES = {
    "instrument-files/rheocompass_saos.csv": (21, "Pa"),
    "instrument-files/trios.csv": (51, "Pa"),
    "instrument-files/malvern.csv": (221, "Pa"),
    "instrument-files/trios_lims.txt": (340, "Pa"),
    "3m-468mp-acrylic-tts/normalized.csv": (340, "Pa"),
    "elastomer-epdm-70-dma-payne/normalized.csv": (240, "Pa"),
    "fhwa-ptf-binder-dsr/normalized.csv": (4030, "Pa"),
    "friction-damper-brfd-lehigh/normalized_harmonics.csv": (53, "N/mm"),
    "hermes-multi-technique/normalized.csv": (58, "Pa"),
    "mitmaps-saos/normalized.csv": (16, "Pa"),
    "mr-damper-utfsm-sinusoid/normalized_harmonics.csv": (30, "N/mm"),
    "nist-srm2491-pdms/normalized.csv": (96, "Pa"),
    "nist-srm2491-pdms/nist-srm-2491-dma-table-9-v1.csv": (96, "Pa"),
    "reptate-polyisoprene-osc/normalized.csv": (1280, "Pa"),
}


@pytest.mark.soak_cases(
    "fhwa-ptf-binder-dsr/normalized.csv",
    "instrument-files/malvern.csv",
    "instrument-files/trios_lims.txt",
)
@pytest.mark.parametrize("name", FILES)
def test_it_opens_without_options(name):
    measured = open_measurement(found(name), (), READERS)
    points, unit = FILES[name]
    assert (len(measured), measured.units.stiffness) == (points, unit)


def test_every_signal_file_opens():
    paths = sorted(found("friction-damper-brfd-lehigh/signals").glob("*.csv"))
    assert paths
    for path in paths[::8]:
        assert open_measurement(path, (), READERS).units.stiffness == "N/mm"


@pytest.mark.soak
def test_the_export_and_the_table_made_of_it_agree():
    export = open_measurement(found("instrument-files/trios_lims.txt"), (), READERS)
    table = open_measurement(found("3m-468mp-acrylic-tts/normalized.csv"), (), READERS)
    np.testing.assert_allclose(export.omega, table.omega, rtol=1e-9)
    np.testing.assert_allclose(export.stiffness, table.stiffness, rtol=1e-6)
    np.testing.assert_allclose(
        export.conditions["amplitude"] / 100, table.conditions["amplitude"], rtol=1e-6
    )


def test_steps_and_header_of_the_exports():
    path = found("instrument-files/trios.csv")
    assert [part.usable for part in parts_of(path, READERS)] == [False] * 6 + [True]
    said = open_measurement(path, (), READERS).provenance
    assert said["instrument.inertia"] == "20.7204 µN.m.s²"
    assert said["geometry.compliance"] == "1.03 mrad/N.m"
    malvern = parts_of(found("instrument-files/malvern.csv"), READERS)
    assert len(malvern) == 17
    assert sum(part.usable for part in malvern) == 8
