"""Where what a command writes goes.

Never over what it reads, and never a fault where it cannot be kept.
"""

import os
import subprocess
import sys

import pytest

from springpot.errors import OutputError
from springpot.files import one_run, require_writable
from springpot.registry import open_measurement

TRIVIAL = "frequency [Hz],storage [kN/m],loss [kN/m]\n"


@pytest.mark.parametrize(
    "arguments",
    [
        "signals {f} -o {f}",
        "signals {f}?force=N -o {f}",
        "mastercurve {f} -o {f}",
        "mastercurve {f}#1 --figure {f}",
        "predict {f} --frequency 1 -o {f}",
        "predict other.json --history {f} -o {f}",
        "predict {f} --frequency 1 --figure {f}",
        "export-model {f} --to opensees --band 1Hz:2Hz -o {f}",
        "identify {f} other.csv --joint --model maxwell --figure {f}",
        "compare {f}@temperature=20 --figure {f}",
        "discover {f} --auto --figure {f}",
        "discover {f} --auto --report {f}",
        "simulate {f} --record artificial --figure {f}",
        "simulate other.toml --record {f} --figure {f}",
        "regression update {f} --baseline {f}",
    ],
)
def test_no_output_replaces_what_the_command_reads(springpot, write, arguments):
    suffix = ".html" if "--report" in arguments else ".svg"
    path = write(TRIVIAL, f"d{suffix}")
    answer = springpot(*arguments.format(f=path).split())
    assert answer.is_one_line("cannot write", "read by this very command")
    assert path.read_text() == TRIVIAL


@pytest.mark.parametrize(
    "arguments",
    [
        "discover {data} --auto --figure d.svg --report d.svg",
        "predict {data} --frequency 1 -o d.svg --figure ./d.svg",
        "predict {data} --frequency 1 -o link.svg --figure d.svg",
        "mastercurve {data} -o d.svg --figure sub/../d.svg",
    ],
)
def test_no_two_outputs_go_to_one_file(springpot, write, monkeypatch, arguments):
    data = write(TRIVIAL)
    monkeypatch.chdir(data.parent)
    os.mkdir("sub")
    os.symlink("d.svg", "link.svg")
    answer = springpot(*arguments.format(data=data).split())
    assert answer.is_one_line("cannot write", "another output of this command goes there")
    assert not os.path.exists("d.svg")


def test_several_outputs_may_go_to_one_device(springpot, damper):
    to_null = ["-o", "/dev/null", "--figure", "/dev/null"]
    answer = springpot("predict", damper, "--frequency", "1", *to_null)
    assert answer.is_one_line("a figure's name must end in")


def test_a_fit_named_within_a_structure_is_an_input_too(springpot, write):
    inside = '[structure]\nmass = 1\nstiffness = 1\n[[damper]]\nfit = "fit.svg"\n'
    structure, fit = write(inside, "frame.toml"), write("{}", "fit.svg")
    answer = springpot("simulate", structure, "--record", "artificial", "--figure", fit)
    assert answer.is_one_line("cannot write", "read by this very command")
    assert fit.read_text() == "{}"


def test_what_a_data_set_was_read_from_is_an_input_too(damper):
    with one_run():
        open_measurement(damper)
        with pytest.raises(OutputError, match="read by this very command"):
            require_writable(damper)


@pytest.mark.soak_cases("list models --json", "list models")
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
@pytest.mark.parametrize("arguments", ["list models", "list models --json", "list --help"])
def test_a_full_disk_behind_standard_output_is_no_fault(arguments):
    with open("/dev/full", "w") as full:
        program = [sys.executable, "-m", "springpot", *arguments.split()]
        ended = subprocess.run(program, stdout=full, stderr=subprocess.PIPE, text=True)
    said = "springpot: cannot write what is printed: No space left on device\n"
    assert (ended.returncode, ended.stderr) == (2, said)


@pytest.mark.soak
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_full_disk_behind_standard_error_costs_no_answer():
    with open("/dev/full", "w") as full:
        program = [sys.executable, "-m", "springpot", "list", "writers"]
        ended = subprocess.run(program, stdout=subprocess.PIPE, stderr=full, text=True)
        refused = subprocess.run([*program[:-1], "nothing"], stderr=full)
    assert ended.returncode == 0
    assert "abaqus" in ended.stdout
    assert refused.returncode == 2
