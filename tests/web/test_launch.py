"""How the workbench begins and ends."""

from __future__ import annotations

import base64
import json
import signal
import socket
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

import pytest
from client import ask, head, raw, token_of
from test_state import a_session

from springpot.errors import OptionError
from springpot.web import Workbench, serve
from springpot.web.server import page_files
from springpot.web.sessions import measured_in, text_of
from springpot.web.tasks import begin, perform, understand

STARTS = [sys.executable, "-c"]
BARE = "import numpy"
WHOLE = "from springpot.web import Workbench; import numpy; Workbench()"


@pytest.mark.soak
def test_the_command_prints_its_address_first_and_ends_with_ctrl_c(tmp_path: Path):
    command = [sys.executable, "-m", "springpot", "workbench", "--no-browser"]
    running = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert running.stdout is not None
    assert running.stdout.readline().startswith("springpot workbench: http://127.0.0.1:")
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=300)
    assert running.returncode in (0, 130)
    assert out == ""
    assert "Traceback" not in err


@pytest.mark.soak
def test_data_that_cannot_be_used_end_it_in_one_line(tmp_path: Path):
    (tmp_path / "bad.csv").write_text("hello\nworld\n", encoding="utf-8")
    command = [sys.executable, "-m", "springpot", "workbench", "bad.csv", "--no-browser"]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ended.returncode == 2
    assert ended.stdout == ""
    assert ended.stderr.startswith("springpot: bad.csv: ")
    assert ended.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("spec", "model", "says"),
    [
        (
            "dampr.csv",
            "",
            "'dampr.csv': there is no such file or data set: did you mean damper.csv?",
        ),
        ("no-such-set", "", "neither a file nor a registered data set"),
        (
            "damper.csv",
            "fractional-maxwel",
            "unknown model 'fractional-maxwel': did you mean fractional-maxwell",
        ),
        ("", "kelvin + nonsense", "unknown effect 'nonsense'"),
        ("broken.json", "", "this is no session"),
    ],
)
def test_what_cannot_be_used_is_said_as_by_any_command(
    tmp_path: Path, damper: bytes, monkeypatch: pytest.MonkeyPatch, spec: str, model: str, says: str
):
    monkeypatch.chdir(tmp_path)
    Path("damper.csv").write_bytes(damper)
    Path("broken.json").write_text('{"schema": "springpot.session/1"}', encoding="utf-8")
    told = perform("begin", {"spec": spec, "model": model}, print)
    assert says in told["error"]
    assert told["fault"] is False


def test_a_file_that_only_asks_is_asked_about_on_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    content = "frequency [Hz],storage,loss\n1,2,3\n2,3,4\n3,4,5\n4,5,6\n"
    (tmp_path / "mine.csv").write_text(content, encoding="utf-8")
    question = begin(print, "mine.csv")["question"]
    assert [asked["kind"] for asked in question["asked"]] == ["unit", "unit"]
    assert question["name"] == "mine.csv"
    said = ",".join(asked["answers"][0]["said"] for asked in question["asked"])
    answered = understand(print, question["name"], question["content"], f"?{said}")
    assert answered["scene"]["count"] == 4
    # No unit is an answer too, and is not asked for again.
    bare = "?storage=file units,loss=file units"
    assert understand(print, question["name"], question["content"], bare)["scene"]["count"] == 4


def test_ctrl_c_is_heard_even_where_python_would_swallow_it():
    """A KeyboardInterrupt in an interpreter callback is printed and lost, and the server ran on."""

    class Forgotten:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)

    def tell(bench: Workbench) -> None:
        rescue = threading.Timer(300.0, bench.close)
        rescue.daemon = True
        rescue.start()
        Forgotten()

    # A shell's background job ignores Ctrl-C, and so would this test.
    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            serve(None, None, 0, False, tell)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, usual)


@pytest.mark.soak
def test_it_starts_little_later_than_numpy_alone():
    def least(program: str) -> float:
        took = []
        for _ in range(2):
            begun = time.perf_counter()
            subprocess.run([*STARTS, program], check=True)
            took.append(time.perf_counter() - begun)
        return min(took)

    assert least(WHOLE) < 5 * least(BARE)


def test_python_opens_it_on_a_measurement_and_goes_on(named: Workbench, damper: bytes):
    begun = ask(named, "/api/start", method="GET")
    assert begun["model"] == "fractional-maxwell"
    assert begun["data"]["result"]["text"] == text_of(measured_in("damper.csv", damper)[0])
    assert named.address in named._repr_html_().replace("&amp;", "&")


def test_every_run_has_a_token_of_its_own(bench: Workbench):
    other = Workbench()
    assert token_of(other) != token_of(bench)
    assert raw(bench, head(bench, path="/api/start", X_Springpot_Token=token_of(other)))[0] == 401
    other.close()


def test_every_file_of_the_page_is_in_the_wheel():
    root = Path(__file__).resolve().parents[2]
    told = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = told["tool"]["setuptools"]["package-data"]["springpot"]
    package = root / "framework" / "springpot"
    packed = {path.name for pattern in patterns for path in package.glob(pattern)}
    assert set(page_files()) <= packed
    assert {"main.js", "compare.js", "panels.css", "index.html"} <= set(page_files())


def test_small_answers_are_sent_at_once(bench: Workbench):
    """asyncio turns Nagle's algorithm off only for sockets whose protocol is named.

    A slider waited 40 ms for it.
    """
    assert bench._socket.proto == socket.IPPROTO_TCP


def test_a_port_that_is_taken_is_told(bench: Workbench):
    with pytest.raises(OptionError, match="leave --port out"):
        Workbench(port=bench.port)


def test_what_the_command_line_names_is_opened(
    tmp_path: Path, damper: bytes, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "damper.csv").write_bytes(damper)
    found = begin(print, str(tmp_path / "damper.csv"))
    assert found["source"] == "damper.csv"  # no folder that only this machine has
    session = json.dumps(a_session(measured_in("damper.csv", damper)[0])).encode()
    (tmp_path / "damper.json").write_bytes(session)
    opened = begin(print, "damper.json")
    assert (
        opened["session"]
        == understand(print, "x.json", base64.b64encode(session).decode())["session"]
    )
    assert opened["text"] == found["text"]


def test_a_record_is_a_test_in_time(tmp_path: Path):
    lines = "".join(f"{i / 200},{i % 100 - 50},{(i + 5) % 100 - 50}\n" for i in range(1000))
    content = base64.b64encode(f"time [s],displacement [mm],force [kN]\n{lines}".encode()).decode()
    found = understand(print, "signals.csv", content)
    assert found["scene"]["count"] == 1000
    assert found["scene"]["axis"]["column"] == "time"


def test_an_answer_is_no_data_and_says_what_is():
    content = base64.b64encode(json.dumps({"schema": "springpot.diagnosis/2"}).encode()).decode()
    told = perform("understand", {"name": "mine.json", "content": content}, lambda _: None)
    assert told["error"].startswith("mine.json is an answer of springpot (springpot.diagnosis/2)")
    assert "session" in told["error"]


def test_the_browser_is_called_without_the_token(monkeypatch: pytest.MonkeyPatch):
    """All users of a machine see what a process is called with.

    Only its owner reads the file that is named.
    """
    called: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: called.append(address))
    running = Workbench().start()
    running.open()
    while not called:
        time.sleep(0.01)
    door = Path(url2pathname(urlparse(called[0]).path))
    try:
        assert token_of(running) not in called[0]
        assert running.address in door.read_text(encoding="utf-8")
        assert door.stat().st_mode & 0o777 == 0o600
        assert door.parent.stat().st_mode & 0o777 == 0o700
    finally:
        running.close()
    assert not door.parent.exists()
