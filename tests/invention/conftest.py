"""One law that is missing, found once for all tests of this room."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from lawful_data import lossy, swept

import springpot
from remembered import remember
from springpot import Invention
from springpot.cli.invent import command as invent


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with data and the law that the command line finds of them."""
    folder = tmp_path_factory.mktemp("invention")
    springpot.write_measurement(swept(lossy), folder / "made.csv")
    with pytest.MonkeyPatch.context() as patch:
        remember(patch)
        arguments = [str(folder / "made.csv"), "-o", str(folder / "law.json")]
        answer = CliRunner().invoke(invent, arguments, catch_exceptions=False)
    assert answer.exit_code == 0
    assert "next: springpot discover" in answer.output
    return folder


@pytest.fixture(scope="session")
def found(files: Path) -> Invention:
    """The same as Python finds it."""
    with pytest.MonkeyPatch.context() as patch:
        remember(patch)
        return springpot.invent(files / "made.csv")
