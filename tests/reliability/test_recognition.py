"""Recognition sees a bounded head of a file, in time proportional to it, whatever is there."""

from itertools import product
from time import process_time

import pytest

from soaked import soaked
from springpot.errors import DataError
from springpot.measurement import open_measurement, pick_reader
from springpot.measurement.opening import HEAD, read_head
from springpot_plugins.readers import springpot_readers

READERS = tuple(springpot_readers())
UNITS = (
    *(
        b" ",
        b"\n",
        b"\r\n",
        b"\t",
        b"\t\n",
        b" \n",
        b'"',
        b'"\n',
        b"(",
        b"[",
        b"[(",
        b"a ",
        b"a(",
        b"a [",
        b"#",
        b"# ",
    ),
    *(
        b",",
        b", ",
        b";",
        b"; ",
        b"=",
        b"a=1;",
        b"_",
        b"a_",
        b"1",
        b"1d",
        b"1,",
        b"1 C ",
        b"-",
        b"G' ",
        b"f [Hz],",
    ),
    *(
        b"Storage modulus ",
        b"Interval",
        b"[",
        b"]",
        b"{",
        b'{"Procedure":',
        b"\xc2\xb0",
        b"/",
        b" / ",
        b"in ",
        b"'",
    ),
    b"time [s],",
)
"""What is said again and again."""
FRAMES = (
    (b"", b""),
    (b"x", b'x"'),
    (b'"', b'"y"\n1,2\n1,2'),
    (b"a [Hz],b", b",c [Pa]\n1 2 3\n"),
    (b"log ", b" 1"),
)
"""What stands before and behind it."""
FACTOR = 4
SLACK = 2.5
"""Of the time of a head four times as long.

A quadratic recogniser takes sixteen times as long, rather than four.
"""
LITTLE = 0.1
"""Seconds that no one waits for, and that a clock cannot tell apart."""


def seconds(reader, head):
    """Processor time of one recognition, the shorter of two."""
    times = []
    for _ in range(2):
        start = process_time()
        assert 0.0 <= reader.recognises(head) <= 1.0
        times.append(process_time() - start)
        if times[0] < LITTLE:
            break
    return min(times)


IN_TURN = [(unit, FRAMES[i % len(FRAMES)]) for i, unit in enumerate(UNITS)]


@pytest.mark.soak_cases(
    "rheocompass-in turn", "table-in turn", "signals-csv-in turn", "springpot-csv-in turn"
)
@pytest.mark.parametrize(
    "cases", [IN_TURN, soaked(list(product(UNITS, FRAMES)))], ids=["in turn", "all"]
)
@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_recognition_is_linear(reader, cases):
    slow = []
    for unit, (before, behind) in cases:
        long = before + unit * (HEAD // len(unit)) + behind
        whole = seconds(reader, long[-HEAD:])
        if whole > LITTLE:
            part = seconds(
                reader, (before + unit * (HEAD // FACTOR // len(unit)) + behind)[-HEAD // FACTOR :]
            )
            if whole > FACTOR * SLACK * part + LITTLE:
                slow.append((before, unit, behind, part, whole))
    assert not slow


def test_the_head_is_bounded(tmp_path):
    path = tmp_path / "large.csv"
    path.write_bytes(b"x" * (3 * HEAD))
    assert len(read_head(path)) == HEAD


def test_a_table_below_many_blank_lines_is_found(tmp_path):
    path = tmp_path / "blank.csv"
    path.write_text("\n" * 30_000 + "frequency [Hz],storage [Pa],loss [Pa]\n1,2,3\n2,3,4\n")
    assert pick_reader(path, READERS).name == "springpot-csv"
    assert len(open_measurement(path, (), READERS)) == 2


def test_what_is_nothing_but_blank_is_refused(tmp_path):
    path = tmp_path / "blank.csv"
    path.write_text("\n" * 200_000)
    with pytest.raises(DataError, match="the file is empty"):
        open_measurement(path, (), READERS)


@pytest.mark.parametrize("remark", ["# key: value\n", "\n", "# " + "x" * 100_000 + "\n"])
def test_a_table_below_more_remarks_than_the_head_holds_is_found(tmp_path, remark):
    path = tmp_path / "remarks.csv"
    remarks = remark * (3 * HEAD // len(remark) + 1)
    path.write_text("\ufeff" + remarks + "frequency [Hz],storage [Pa],loss [Pa]\n1,2,3\n2,3,4\n")
    assert len(open_measurement(path, (), READERS)) == 2
