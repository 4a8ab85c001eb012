"""The command line and the workers of the page are springpot's own processes.

What takes too long there is ended.
"""

import base64
import json
import subprocess
import sys

import hostile
import pytest

SHORT = "from springpot import files; files.FILES = files.FILES._replace(seconds=0.2); "
TOLD = "more than 0.2 s of processor time"


def python(program, **options):
    command = [sys.executable, "-c", SHORT + program]
    return subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=False, **options
    )


@pytest.fixture(scope="module")
def dense(tmp_path_factory):
    """A workbook that takes ten times as long, and is within all sizes."""
    return hostile.dense_workbook(tmp_path_factory.mktemp("dense"), 0.08)


@pytest.mark.soak
def test_a_command_ends_what_takes_too_long(dense):
    done = python(f"from springpot.cli import main; main(['inspect', {str(dense)!r}])")
    assert (done.returncode, done.stdout) == (2, "")
    assert TOLD in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.soak
def test_a_worker_of_the_page_ends_what_takes_too_long(dense):
    content = base64.b64encode(dense.read_bytes()).decode()
    asked = {"task": "understand", "arguments": {"name": "dense.xlsx", "content": content}}
    done = python("from springpot.web.worker import main; main()", input=json.dumps(asked) + "\n")
    answer = json.loads(done.stdout.splitlines()[-1])
    assert TOLD in answer["error"]
    assert not answer["fault"]
