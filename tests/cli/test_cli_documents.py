"""Documents of a user other than data.

One file rule, and whatever stands in them, an answer or one line.
"""

import base64
import json
import os
from pathlib import Path

import numpy as np
import pytest

import documents
from springpot.benchmark.gate.baseline import read_baseline
from springpot.errors import DataError
from springpot.files import FILES, json_of, toml_in, toml_of
from springpot.web.sessions import session_of
from springpot.web.tasks import perform

pytestmark = pytest.mark.usefixtures("asked_once")

CASES = 25
"""Of each kind of document."""
SEED = 7
FRAME = {
    "structure": {"storeys": 2, "mass": 1e5, "stiffness": [8e7, 7e7], "damping": 0.02},
    "damper": [
        {"fit": "fit.json", "storey": 1, "count": 40, "slope": 30},
        {
            "model": "kelvin",
            "parameters": {"k": 1e5, "c": 2e4},
            "unit": "N/m",
            "storey": 2,
        },
    ],
}
RECORD = [
    ["time [s]", "acceleration [g]"],
    *([f"{0.02 * i:.2f}", f"{0.1 * (-1) ** i}"] for i in range(12)),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A fit of a sweep and one of a test in time, and what they were fitted to."""
    from springpot import identify, open_in_time
    from springpot.registry import parse_model
    from springpot.report.text import to_json
    from springpot.timetests import identify as identify_in_time

    folder = tmp_path_factory.mktemp("documents")
    omega = np.geomspace(3.0, 300.0, 12)
    stiffness = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * (1j * omega) ** 0.5))
    rows = zip(omega.tolist(), stiffness.real.tolist(), stiffness.imag.tolist(), strict=True)
    table = "omega [rad/s],storage [kN/m],loss [kN/m]\n" + "".join(
        f"{w!r},{a!r},{b!r}\n" for w, a, b in rows
    )
    (folder / "damper.csv").write_text(table, encoding="utf-8")
    fit = identify(str(folder / "damper.csv"), "fractional-maxwell")
    (folder / "fit.json").write_text(to_json(fit), encoding="utf-8")
    pad = "".join(f"{0.1 * 1.5**i!r},{400.0 * 1.5 ** (-0.3 * i)!r}\n" for i in range(18))
    (folder / "pad.csv").write_text(f"time [s],relaxation [kPa]\n{pad}", encoding="utf-8")
    in_time = identify_in_time(open_in_time(folder / "pad.csv"), parse_model("springpot"))
    (folder / "pad.json").write_text(to_json(in_time), encoding="utf-8")
    return folder


def fuzzed(document, write_as, path, answer):
    """Every changed document gives an answer, or one line with exit code 2.

    The document itself an answer.
    """
    path.write_text(write_as(document), encoding="utf-8")
    assert answer().code == 0, answer().err
    codes = set()
    for name, made in documents.some_changes(document, np.random.default_rng(SEED), CASES):
        path.write_text(write_as(made), encoding="utf-8")
        told = answer()
        codes.add(told.code)
        assert told.code in (0, 2), (name, told.err)
        assert told.code == 0 or told.err.count("\n") == 1, (name, told.err)
        assert "Traceback" not in told.err
        assert told.code or "nan" not in told.out.lower(), (name, told.out)
    assert codes == {0, 2}


@pytest.mark.soak_cases("fit")
@pytest.mark.parametrize("kind", ["fit", "pad"])
def test_a_fit_that_was_changed_is_used_or_refused(springpot, folder, kind):
    path = folder / "changed.json"
    fit = json.loads((folder / f"{kind}.json").read_text(encoding="utf-8"))
    fuzzed(fit, json.dumps, path, lambda: springpot("predict", path, "--frequency", "1,2"))


def test_a_structure_that_was_changed_is_used_or_refused(springpot, folder):
    path, record = folder / "frame.toml", folder / "record.csv"
    record.write_text(csv_text(RECORD), encoding="utf-8")
    fuzzed(
        FRAME,
        documents.toml_text,
        path,
        lambda: springpot("simulate", path, "--record", record, "--draws", "0"),
    )


def test_a_record_that_was_changed_is_used_or_refused(springpot, folder):
    path, frame = folder / "changed.csv", folder / "plain.toml"
    frame.write_text(documents.toml_text({"structure": FRAME["structure"]}), encoding="utf-8")
    fuzzed(
        RECORD,
        csv_text,
        path,
        lambda: springpot("simulate", frame, "--record", path, "--draws", "0"),
    )


def csv_text(rows):
    """Rows of cells, of which one may have become anything else."""
    return "".join(
        ",".join(map(str, row if isinstance(row, list) else [row])) + "\n" for row in rows
    )


def test_a_session_that_was_changed_opens_or_is_refused(folder):
    state = {
        "data": "0" * 64,
        "model": "fractional-maxwell",
        "accepted": ["inertia"],
        "excluded": [1],
        "seed": 0,
    }
    session = {
        "schema": "springpot.session/1",
        "data": {
            "source": "d.csv",
            "joined": False,
            "text": (folder / "damper.csv").read_text(encoding="utf-8"),
        },
        "branches": [{"name": "A", "states": [state], "at": 0}],
        "branch": 0,
        "view": {"view": "phase", "size": 1.0},
    }
    for name, made in documents.some_changes(session, np.random.default_rng(SEED), CASES):
        content = base64.b64encode(json.dumps(made).encode()).decode()
        answer = perform("understand", {"name": "s.json", "content": content}, lambda stage: None)
        assert not answer.get("fault"), (name, answer["error"])
        assert "\n" not in answer.get("error", ""), name


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            {"storeys": 20_000},
            "storeys: 20000 is no number that it can be; give a whole one from 1 to 300",
        ),
        ({"storeys": 2.7}, "storeys: 2.7"),
        ({"mass": documents.HUGE}, "mass: 1000"),
        ({"mass": float("nan")}, "nan is no finite number"),
        ({"damping": True}, "damping: True"),
    ],
)
def test_a_number_that_cannot_be_is_told(springpot, folder, change, says):
    path = folder / "wrong.toml"
    path.write_text(
        documents.toml_text(FRAME | {"structure": FRAME["structure"] | change}), encoding="utf-8"
    )
    assert springpot("simulate", path, "--frequency", "1").is_one_line("wrong.toml", says)


@pytest.mark.parametrize(
    "wrong", [{"count": -4}, {"count": 0}, {"slope": 90}, {"temperature": -300}, {"storey": 0}]
)
def test_a_damper_that_cannot_be_is_told(springpot, folder, wrong):
    path, [name] = folder / "wrong.toml", wrong
    path.write_text(
        documents.toml_text(FRAME | {"damper": [FRAME["damper"][0] | wrong]}), encoding="utf-8"
    )
    assert springpot("simulate", path, "--frequency", "1").is_one_line(
        "wrong.toml", f"damper 1: {name}"
    )


def test_friction_in_a_frame_far_too_stiff_is_no_endless_work(springpot, folder):
    slides = {
        "model": "kelvin + friction",
        "unit": "N/m",
        "parameters": {"k": 1e5, "c": 2e4, "friction": {"F": 1.0}},
    }
    stiff = {"mass": 1e-6, "stiffness": 1e12}
    (folder / "stiff.toml").write_text(
        documents.toml_text({"structure": stiff, "damper": [slides]}), encoding="utf-8"
    )
    (folder / "record.csv").write_text(csv_text(RECORD), encoding="utf-8")
    answer = springpot("simulate", folder / "stiff.toml", "--record", folder / "record.csv")
    assert answer.is_one_line("shortest period", "steps of the record")


@pytest.mark.parametrize("kind", ["pipe", "device", "link"])
def test_the_file_rule_holds_for_every_document(springpot, folder, tmp_path, kind):
    path = tmp_path / "endless"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "link":
        path.symlink_to("/dev/zero")
    else:
        path = Path("/dev/zero")
    plain = folder / "plain.toml"
    plain.write_text(documents.toml_text({"structure": FRAME["structure"]}), encoding="utf-8")
    for command in (
        ("predict", path, "--frequency", "1"),
        ("predict", folder / "fit.json", "--history", path),
        ("simulate", path, "--frequency", "1"),
        ("simulate", plain, "--record", path),
        ("signals", path),
        ("inspect", path),
    ):
        assert springpot(*command).is_one_line("pipe or device", path.name), command
    with pytest.raises(Exception, match="pipe or device"):
        read_baseline(path)


@pytest.mark.parametrize(
    "text", ["[" + "[]," * 1_000_001 + "1]", "[" * 100_000, '{"a": ' * 100_000]
)
def test_json_of_a_million_brackets_is_refused_before_it_is_read(text, tmp_path, springpot):
    with pytest.raises(ValueError, match=r"more than|nested"):
        json_of(text)
    with pytest.raises(DataError):
        session_of(text.encode())
    path = tmp_path / "brackets.json"
    path.write_text(text, encoding="utf-8")
    assert springpot("predict", path, "--frequency", "1").is_one_line("brackets.json", "no JSON")


@pytest.mark.parametrize("word", ["NaN", "Infinity", "1e400", "1" + "0" * 400, "-1e999"])
def test_a_number_of_an_answer_is_one_that_a_float_holds(word):
    with pytest.raises(ValueError, match="number"):
        json_of(f"[{word}]", finite=True)


@pytest.mark.parametrize(
    "text", ["a." * 100_000 + "a = 1", '"a" . ' * 30_000, "a = " + "[" * 50_000, "a = nan"]
)
def test_toml_takes_no_more_memory_than_it_is_worth(text):
    """Of a dotted name Python's reader keeps every beginning."""
    with pytest.raises(ValueError, match=r"nested too deeply|no finite number"):
        toml_of(text)


def test_a_file_beyond_its_size_is_told_before_it_is_read_whole(tmp_path, springpot):
    path = tmp_path / "large.json"
    with path.open("wb") as stream:
        os.truncate(stream.fileno(), FILES.largest + 1)
    assert springpot("predict", path, "--frequency", "1").is_one_line("large.json", "64 MiB")
    with pytest.raises(DataError, match=r"large\.json is too large: at most 256 KiB"):
        toml_in(path)
