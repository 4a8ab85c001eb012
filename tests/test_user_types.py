"""A user's type checker sees what springpot returns: no `Any` at the top level."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = """
import springpot

data = springpot.read("damper.csv")
fit = springpot.identify(data, "fractional-maxwell", fix={"alpha": 0.5})
reveal_type(data)
reveal_type(fit)
reveal_type(fit["k"].value)
reveal_type(fit.predict(frequency=[1.0]).storage)
reveal_type(fit.covariance)
reveal_type(springpot.diagnose(data).best)
reveal_type(springpot.discover(data).steps)
reveal_type(springpot.compare(data).best.model)
reveal_type(springpot.load("fit.json"))
reveal_type(springpot.parse_model("zener"))
fit.parameters["k"].valu
springpot.identify(data)
"""


@pytest.mark.soak
def test_results_have_types_and_slips_are_seen(tmp_path: Path):
    pytest.importorskip("mypy")
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    # With the options of `make lint`, whatever it has checked is not checked once more, neither
    # here nor there.
    command = [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml"]
    command += ["--cache-dir", ROOT / ".mypy_cache"]
    paths = {"MYPYPATH": f"{ROOT / 'framework'}:{ROOT / 'plugins'}", "PATH": ""}
    done = subprocess.run(
        [*command, script], capture_output=True, text=True, env=paths, cwd=tmp_path, check=False
    )
    lines = done.stdout.splitlines()
    told = [line.partition('type is "')[2].rstrip('"') for line in lines if "Revealed type" in line]
    ends = [name.rpartition(".")[2] for name in told[:2]]
    assert ends == ["Measurement", "Identification"], done.stdout + done.stderr
    assert told[2] == "float"
    assert all("dtype[numpy.float64]" in name for name in told[3:5])
    assert len(told) == 10
    # An array of any shape is typed so by NumPy itself.
    assert not [
        name for name in told if name == "Any" or ", Any]" in name.replace("[Any, ...]", "")
    ]
    errors = [line for line in lines if ": error:" in line]
    assert len(errors) == 2, errors
    assert '"Value" has no attribute "valu"' in errors[0]
    assert "model" in errors[1]
