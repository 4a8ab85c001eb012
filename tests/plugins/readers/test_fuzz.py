"""Every reader against broken, cut and mixed files.

A measurement or a one-line DataError, nothing else.
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from springpot.errors import DataError
from springpot.measurement import Choice

from . import samples
from .conftest import READERS

SEEDS = {
    "springpot-csv": samples.table("frequency [Hz],storage [kN/m],loss [kN/m]").encode(),
    "signals-csv": (
        b"time [s],displacement [mm],force [N]\n"
        + samples.laos("").split(b"\n", 1)[1].replace(b"\t", b",")
    ),
    "rheocompass": samples.rheocompass_full(),
    "trios": samples.trios(),
    "trios-lims": samples.trios_lims(),
    "trios-json": samples.trios_json(),
    "ta-thermal": samples.ta_thermal(),
    "malvern": samples.malvern(),
    "reptate": samples.reptate(True),
    "reptate-laos": samples.laos(),
    "excel": samples.xlsx(),
    "signals-mat": samples.mat(compressed=False),
    "signals-tdms": samples.tdms(),
    "table": samples.table("f, E_stor, E_loss\nHz, MPa, MPa").encode(),
}
SAID = st.sampled_from(
    [
        Choice(),
        Choice("1"),
        Choice("2-9", {"frequency": "Hz"}),
        Choice("", {"1": "omega[rad/s]", "2": "storage[Pa]", "3": "loss[Pa]"}),
        Choice("x", {"G'": "1e999 [Pa]"}),
        Choice("", {"1": "time[s]", "2": "displacement[mm]", "3": "force[N]"}),
    ]
)
WORDS = (
    *(
        b"Interval:",
        b"[step]",
        b"[Step]",
        b"Variables\t",
        b"Units\t",
        b"Data point\t",
        b"Mw=1;T=x;",
        b"omega=;",
    ),
    *(
        b"frequency",
        b"[Hz]",
        b"(MPa)",
        b"G'",
        b"G''",
        b'"',
        b";",
        b",",
        b"\t",
        b"\n",
        b"\r",
        b"\0",
        b"1e999",
        b"-1",
    ),
    *(
        b"nan",
        b"1,5",
        b"1.5",
        b"#",
        b"{",
        b"}",
        b"[",
        b"]",
        b":",
        b"TDSm",
        b"MATLAB ",
        b"PK\x03\x04",
        b"\xff\xfe",
    ),
    *("²µ°ω′Δ".encode(), "ω".encode("utf-16"), b"\x92", b"e", b"_", b" / ", b" in "),
)
EDITS = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 30), st.sampled_from(WORDS) | st.binary(max_size=6)),
    max_size=6,
)


def edited(content, edits):
    """The content with a few places cut out or replaced."""
    for place, cut, put in edits:
        start = int(place * len(content))
        content = content[:start] + put + content[start + cut :]
    return content


def complaints(reader, path, choice):
    """What the reader says against a file; any error but a DataError is a crash."""
    said = []
    for action in (lambda: reader.read(path, choice), lambda: reader.parts and reader.parts(path)):
        try:
            action()
        except DataError as error:
            said.append(str(error))
    return said


def test_there_is_a_seed_for_every_reader():
    assert set(SEEDS) == {reader.name for reader in READERS}


@pytest.mark.soak_cases(
    "springpot-csv",
    "rheocompass",
    "trios-lims",
    "trios-json",
    "ta-thermal",
    "malvern",
    "reptate",
    "reptate-laos",
    "excel",
    "signals-mat",
    "signals-tdms",
    "table",
)
@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_edited_files_never_crash(reader, tmp_path):
    path = tmp_path / "data"

    @given(EDITS, SAID)
    @settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
    def check(edits, choice):
        content = edited(SEEDS[reader.name], edits)
        assert 0.0 <= reader.recognises(content[: 1 << 16]) <= 1.0
        path.write_bytes(content)
        assert not any("\n" in said for said in complaints(reader, path, choice))

    check()


@pytest.mark.soak_cases("rheocompass", "malvern", "table")
@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_foreign_files_never_crash(reader, tmp_path):
    path = tmp_path / "data"
    for name, content in SEEDS.items():
        path.write_bytes(content[:20_000])
        assert 0.0 <= reader.recognises(content[: 1 << 16]) <= 1.0
        assert not any("\n" in said for said in complaints(reader, path, Choice())), name


@given(st.lists(st.sampled_from(WORDS), max_size=60).map(b"".join), SAID)
@settings(max_examples=80, deadline=None)
def test_any_mixture_of_words(tmp_path_factory, content, choice):
    path = tmp_path_factory.getbasetemp() / "mixture"
    path.write_bytes(content)
    for reader in READERS:
        assert 0.0 <= reader.recognises(content) <= 1.0
        assert not any("\n" in said for said in complaints(reader, path, choice))


def test_recognition_is_certain(tmp_path):
    """Each format is claimed by its own reader more surely than by any other."""
    for name, content in SEEDS.items():
        scores = {reader.name: reader.recognises(content[: 1 << 16]) for reader in READERS}
        assert max(scores, key=scores.__getitem__) == name, scores
        assert np.isfinite(list(scores.values())).all()


MAT = samples.mat(compressed=False)
FOUND = {
    "a size of seven bytes": ("signals-mat", MAT[:156] + b"\x07" + MAT[157:]),
    "a comment of numbers alone": (
        "reptate-laos",
        b"ome5?\n%.04400026\xb257\x0c\x0c\x0c3923\t2.13",
    ),
    "a name of two lines": ("signals-tdms", samples.tdms().replace(b"/'Time'", b"/'T\nme'")),
    "the same of a sweep": ("reptate", b"Mw=1;\n%1 2 3\n"),
}
"""What the fuzzers found, so that it stays found."""


@pytest.mark.parametrize("case", FOUND)
def test_what_was_found_before(tmp_path, case):
    name, content = FOUND[case]
    path = tmp_path / "data"
    path.write_bytes(content)
    reader = next(reader for reader in READERS if reader.name == name)
    said = complaints(reader, path, Choice())
    assert said
    assert not any("\n" in line for line in said)
