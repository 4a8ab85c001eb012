"""Every measured file that is at hand.

One command opens it, or says in one line exactly what it needs.
"""

import os
import re
from pathlib import Path

import pytest

from springpot.cli.group import exit_code, run

SHARED = Path(
    os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0]
    or Path(__file__).parents[3] / "shared" / "data"
)
SIGNALS = 4
"""Records of one rig that are tried; the others are like them."""


def files():
    found = sorted(
        path for path in SHARED.rglob("*") if path.is_file() and path.name != "PROVENANCE.md"
    )
    records = [path for path in found if path.parent.name == "signals"]
    return [path for path in found if path not in records[SIGNALS:]]


@pytest.fixture(
    params=files() or [None], ids=lambda path: path and f"{path.parent.name}/{path.name}"
)
def measured(request):
    if request.param is None:
        pytest.skip("no shared data (SPRINGPOT_DATA)")
    return request.param


def said(capsys, *arguments):
    code = exit_code(lambda: run([str(argument) for argument in arguments]))
    return code, *capsys.readouterr()


@pytest.mark.soak_cases(
    "fhwa-ptf-binder-dsr/normalized.csv",
    "instrument-files/malvern.csv",
    "instrument-files/trios_lims.txt",
    "polystyrene-three-tests/creep_ps130_data.csv",
)
def test_inspect_opens_it_or_says_what_it_needs(measured, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = said(capsys, "inspect", measured)
    assert "Traceback" not in err
    if code == 0:
        assert re.search(r"^next.*: springpot ", out, re.MULTILINE)
        assert (
            max(len(line) for line in out.splitlines() if str(measured) not in line) <= 92
        )  # one long name
        return
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    hint = re.search(r"'([^']*\?[^']*)'$", err.strip()) or re.search(r"open '([^']*\?[^']*)'", err)
    assert hint, err
    assert said(capsys, "inspect", hint[1])[0] == 0, f"what it asks for does not open it: {hint[1]}"
