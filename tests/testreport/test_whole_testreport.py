"""What small tests are told of their cycles and codes, as numbers, words, files and pictures."""

import csv
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from known_loops import STROKE, noisy

from springpot.testreport import LoopRecord, certify
from springpot.testreport.certificate import certificate_page
from springpot.testreport.commands.cycles import law_text, table_of
from springpot.testreport.report import report_of
from springpot.testreport.summary import evaluate

CODES = Path(__file__).resolve().parents[2] / "docs" / "codes"
NOISE = 5e-3
SMALL = {"per_cycle": 40, "cycles": 5}


def run(kind, seed=1, **given):
    return noisy(kind, np.random.default_rng(seed), NOISE, **(SMALL | given))[0]


def resting():
    """Rest, five cycles, rest."""
    t, noise = np.arange(-40, 241) / 40.0, np.random.default_rng(2).standard_normal((2, 281))
    x = np.where((t > 0.0) & (t < 5.0), STROKE * np.sin(2.0 * np.pi * t), 0.0)
    return LoopRecord(t, x + 0.02 * noise[0], 0.8 * x + 0.02 * noise[1], "mm", "kN", "resting")


def clipped():
    record = run("linear")
    most = 0.8 * record.force.max()
    return replace(record, force=np.clip(record.force, -most, most))


def warming():
    """Softer by 2 % a cycle, and unequal in its last stroke, while it warms."""
    record = run("coulomb", cycles=6)
    cycle = record.time * 1.3
    force = record.force * (1.0 - 0.02 * np.floor(cycle))
    moved = record.displacement * np.where(cycle > 5.0, 0.9, 1.0)
    return replace(record, displacement=moved, force=force, temperature=20.0 + 0.5 * cycle)


RECORDS = {
    "linear": lambda: run("linear"),
    "coulomb": lambda: run("coulomb"),
    "power": lambda: run("power", drift=0.03),
    "bilinear": lambda: run("bilinear"),
    "backwards": lambda: replace(run("linear"), force=-run("linear").force),
    "begins within": lambda: replace(
        run("linear"),
        displacement=run("linear").displacement[15:-7],
        time=run("linear").time[15:-7],
        force=run("linear").force[15:-7],
    ),
    "resting": resting,
    "clipped": clipped,
    "warming": warming,
    "without time": lambda: replace(run("coulomb"), time=np.arange(201.0), timed=False),
    "strain": lambda: replace(run("linear"), displacement_unit="-", force_unit="kPa"),
}


@cache
def evaluated(case):
    return evaluate(RECORDS[case]())


@pytest.mark.parametrize("case", list(RECORDS))
def test_cycles_of_a_record(case, stays):
    test = evaluated(case)
    found = test.found
    stays(
        {
            **test.to_dict(),
            "sds": {name: told.sd for name, told in test.means.items()},
            "freedom": {name: told.freedom for name, told in test.means.items()},
            "found": [found.bounds, found.middles, found.speeds, found.period, found.amplitude],
            "table": table_of(test).plain(),
        }
    )


@pytest.mark.parametrize("noise", [0.0, NOISE])
def test_a_law_of_speeds(noise, stays):
    """Three speeds; without noise it is what the law leaves that scatters."""
    tests = []
    for i, frequency in enumerate((0.2, 0.5, 1.2, 3.0)):
        t = np.arange(161) / (40.0 * frequency)
        v = 20.0 * np.pi * frequency * np.cos(2.0 * np.pi * frequency * t)
        force = (2.0 + 0.1 * (i == 1)) * np.sign(v) * np.abs(v) ** 0.4
        force += noise * force.max() * np.random.default_rng(i).standard_normal(len(t))
        x = 10.0 * np.sin(2.0 * np.pi * frequency * t)
        tests.append(evaluate(LoopRecord(t, x, force, "mm", "kN", f"test {i}")))
    report = report_of(tests)
    stays({"law": report.law.to_dict(), "text": law_text(report.law), "figure": report.figure()})


def test_tables_and_pictures_of_several_records(stays, tmp_path):
    report = report_of([evaluated("warming"), evaluated("without time"), evaluated("strain")])
    rows = csv.reader(report.write(tmp_path / "cycles.csv").open(encoding="utf-8"))
    # Of each long table its head and its mean.
    stays({"rows": [row[:8] for row in rows], "figure": report.figure()})


CODE = """[code]
name = "isolator"
source = "none"
cycles = "2..4"
[nominal]
K_eff = "0.5 kN/mm"
[decision]
guard = "{guard}"
[[test]]
name = "design"
records = "design*"
count = 3
cycles = 4
amplitude = "9..11 mm"
frequency = "1..2 Hz"
T = "10..30 degC"
[[require]]
name = "each cycle"
quantity = "W_d"
of = "cycle"
to = "{to}"
{limit}
[[require]]
name = "all"
quantity = "K_eff"
of = "mean"
to = "nominal"
within = "2 %"
[[require]]
name = "one"
quantity = "K_eff"
of = "test"
to = "mean"
within = "1 %"
records = "design*"
[[require]]
name = "damping"
quantity = "xi_eff"
of = "test"
to = "value"
low = 0.45
high = 0.52
[[factor]]
name = "temperature"
quantity = "K_eff"
records = "cold*"
reference = "design*"
[[factor]]
name = "ageing"
low = 0.9
high = 1.1
[factors]
system = 0.75
low = 0.9
high = 1.14
[[error]]
name = "load cell"
acts = "force"
accuracy = "1 %"
[[error]]
name = "gauge"
acts = "displacement"
accuracy = "0.5 %"
shared = false
[[error]]
name = "lag"
acts = "phase"
accuracy = "0.3 deg"
means = "limits"
[[error]]
name = "warmth"
acts = "temperature"
accuracy = "1 K"
coefficient = {{K_eff = "-0.3 %/K"}}
"""


def named(name, by, seed):
    record = replace(run("coulomb", seed), name=name)
    warm = np.full(len(record.time), 20.0)
    return replace(record, force=by * record.force, temperature=warm)


def specimens():
    return [named("design-1", 1.0, 1), named("design-2", 1.03, 2), named("cold-1", 1.2, 3)]


LIMITS = {
    "expanded": {"guard": "expanded", "to": "mean", "limit": 'within = "2 %"'},
    "none": {"guard": "none", "to": "value", "limit": 'low = "75 kN mm"'},
}


@pytest.fixture
def answered(tmp_path):
    def answer(guard):
        path = tmp_path / "code.toml"
        path.write_text(CODE.format(**LIMITS[guard]), encoding="utf-8")
        return certify(specimens(), path, why=False)

    return answer


@pytest.mark.soak_cases("expanded")
@pytest.mark.parametrize("guard", list(LIMITS))
def test_a_code_is_answered(guard, answered, stays):
    answer = answered(guard).to_dict()
    del answer["tests"]
    stays(answer)


def test_a_certificate_as_a_page(answered, stays, unpainted):
    page = certificate_page(answered("none")).partition("Made by")[0]
    rows = re.sub(r"<style.*?</style>", "", page, flags=re.DOTALL).split("</tr>")
    stays([re.sub(r"(<[^>]*>)+", "|", row) for row in rows])
