"""The runner of long tests: it finds its parts, writes their tables, tells a broken promise."""

import subprocess
import sys
from types import SimpleNamespace

import pytest
import soak
from soak import Row


@pytest.fixture
def part(monkeypatch):
    """A part that is not in the folder, with the rows that a test gives it."""

    def add(name, *rows):
        monkeypatch.setitem(
            sys.modules, soak.PREFIX + name, SimpleNamespace(rows=lambda rng, scale: iter(rows))
        )
        known = soak.parts()
        monkeypatch.setattr(soak, "parts", lambda: [*known, name])

    return add


def test_a_broken_promise_is_told_by_the_exit_code_and_kept_in_the_table(part, tmp_path, capsys):
    part("good", Row("kills", 5, 5, "nothing lost"))
    part("bad", Row("flips", 3, 2))
    assert soak.main(["good", "--out", str(tmp_path)]) == 0
    assert soak.main(["bad", "--out", str(tmp_path)]) == 1
    assert "BROKEN" in capsys.readouterr().out
    page = (tmp_path / "README.md").read_text()
    assert "| kills | 5 | 5 | nothing lost |" in page, (
        "a part that was run before stays on the page"
    )
    assert "| flips | 3 | 2 |  |" in page
    assert soak.main(["bad", "--out", str(tmp_path), "--scale", "0.5", "--seed", "7"]) == 1
    page = (tmp_path / "README.md").read_text()
    assert "scale 1, seed 1" in page.partition("## good")[2], "each part says how it was made"
    assert "scale 0.5, seed 7" in page.partition("## good")[0]


def test_an_unknown_part_is_refused(capsys):
    with pytest.raises(SystemExit):
        soak.main(["nothing-of-that-kind"])
    assert "no part nothing-of-that-kind" in capsys.readouterr().err


@pytest.mark.soak
def test_every_part_can_be_called_where_no_test_runs():
    """As `make soak` does: pytest would find more modules."""
    parts = [soak.PREFIX + name for name in soak.parts()]
    program = f"import sys; sys.path[:0] = {soak.PATHS}\nfor name in {parts}: "
    program += "assert callable(__import__(name).rows), name"
    subprocess.run([sys.executable, "-c", program], check=True, cwd="/")
