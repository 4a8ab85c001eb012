"""Progress: plain lines without a terminal, a bar in one, and both end with the truth."""

import io
import os
import pty
import re
import subprocess
import sys

import pytest
from benchmark_fakes import small_study

from springpot.benchmark import run_study
from springpot.benchmark.runner import ProgressLines


def test_lines_are_few_and_the_last_one_is_complete():
    stream = io.StringIO()
    lines = ProgressLines("small", 1000, stream)
    for done in range(1001):
        lines.update(done, done // 500)
    lines.close()
    told = stream.getvalue().splitlines()
    assert len(told) == 2
    assert told[0].startswith("small: 0 of 1000 trials, ")
    assert told[-1].startswith("small: 1000 of 1000 trials, 2 failed, ")


@pytest.mark.soak
def test_a_run_that_resumes_starts_from_what_is_there(tmp_path, capsys):
    run_study(small_study(repetitions=2), engine="serial", out=tmp_path)
    run_study(small_study(repetitions=3), engine="serial", out=tmp_path)
    told = capsys.readouterr().err.splitlines()
    assert [re.sub(r", \d+ s$", "", line) for line in told] == [
        "small: 0 of 16 trials",
        "small: 16 of 16 trials",
        "small: 16 of 24 trials",
        "small: 24 of 24 trials",
    ]


@pytest.mark.soak
def test_a_terminal_gets_a_bar():
    ours, theirs = pty.openpty()
    code = (
        "from springpot.benchmark.runner import *; p = make_progress('small', 40); "
        "p.update(40, 3); p.close()"
    )
    environment = {**os.environ, "TERM": "xterm-256color"}
    subprocess.run([sys.executable, "-c", code], stderr=theirs, check=True, env=environment)
    os.close(theirs)
    shown = os.read(ours, 65536).decode()
    os.close(ours)
    assert "40/40" in shown
    assert "3 failed" in shown
    assert "\x1b[" in shown
