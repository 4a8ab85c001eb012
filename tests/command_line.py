"""What tests of the command line share, wherever the command is.

Those of a guest lie in its own room.
"""

import json
from dataclasses import dataclass

import numpy as np
import pytest

from springpot.cli.group import exit_code, run


@dataclass(frozen=True)
class Answer:
    """What one command said."""

    code: int
    out: str
    err: str

    @property
    def json(self):
        """Stdout, which must be strict JSON and nothing else."""
        assert self.code == 0, self.err
        return json.loads(self.out, parse_constant=_refuse)

    def is_one_line(self, *words):
        """Bad input: nothing on stdout, one line on stderr with these words, exit code 2."""
        assert self.code == 2, (self.code, self.out, self.err)
        assert self.out == ""
        assert self.err.count("\n") == 1, self.err
        assert self.err.startswith("springpot: ")
        assert "Traceback" not in self.err
        for word in words:
            assert word.lower() in self.err.lower(), self.err
        return True


def _refuse(constant):
    raise AssertionError(f"{constant} is not JSON")


@pytest.fixture
def springpot(capsys):
    """Run the command line in this process."""

    def call(*arguments):
        capsys.readouterr()
        code = exit_code(lambda: run([str(argument) for argument in arguments]))
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return call


@pytest.fixture
def write(tmp_path):
    """Put text or bytes into a file and return its path."""

    def put(content, name="data.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return put


TRUTH = {"k": 400.0, "c": 60.0, "alpha": 0.5}


@pytest.fixture
def damper(write):
    """A fractional Maxwell damper, measured without noise."""
    frequency = np.geomspace(0.5, 50.0, 15)
    springpot = TRUTH["c"] * (2j * np.pi * frequency) ** TRUTH["alpha"]
    stiffness = 1.0 / (1.0 / TRUTH["k"] + 1.0 / springpot)
    rows = [
        f"{f!r},{k.real!r},{k.imag!r}"
        for f, k in zip(frequency.tolist(), stiffness.tolist(), strict=True)
    ]
    return write(
        "\n".join(["frequency [Hz],storage [kN/m],loss [kN/m]", *rows]) + "\n", "damper.csv"
    )
