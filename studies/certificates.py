"""Certificates of simulated tests: how often the expanded uncertainty covers, and what it decides.

    python studies/certificates.py [--draws 1000] [--out results/certificates]

Question: does what a certificate states come true, its expanded uncertainty, its decision and its
chance of lying outside? Measure: shares of simulated certificates in which the true value is held,
a pad at the limit passes or fails, and a result lies outside. What would answer it: 0.95 held,
within 0.02; 0.025 passing at the limit and as many failing; a share outside that is within 0.07 of
the stated chance.

Four pads, five cycles each, whose stiffness and loss scatter by 1 % from cycle to cycle, as they
are counted: from one crossing of the displacement to the next, each by itself. The load
cell is off by 1 % (standard, one error in all tests), the stroke by 0.5 % (each test has its own)
and the phase by 4 mrad in all tests. Records go through `springpot.certify` as a user's would: a
value is covered where the expanded uncertainty of the certificate holds the true one. Then pads are
made that lie at the limit, and what the decision says of them is counted.
"""

from __future__ import annotations

import argparse
import os
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from paper.asking import asking
from springpot.benchmark import Table, save_table
from springpot.benchmark.statistics import wilson
from springpot.testreport import LoopRecord
from springpot.testreport.certificate import certify
from springpot.testreport.code import TestCode, read_code
from springpot.testreport.deciding import CONFORMING, FAILING, DecidedRow

ROOT = Path(__file__).resolve().parent.parent
STORAGE, LOSS, STROKE, CYCLES, TESTS = 3.0, 1.0, 10.0, 5, 4
SCATTER, LIMIT = 0.01, 0.10
HEAD = """
[code]
name = "study"
source = "studies/certificates.py"
cycles = "2..6"

[nominal]
K_eff = "{stiffness} kN/mm"
W_d = "{work} kN mm"
"""
REQUIRE = """
[[require]]
name = "{name}"
quantity = "{quantity}"
of = "{of}"
to = "{to}"
within = "10 %"
"""
ASKED = (
    ("K_eff of a test over the nominal", "K_eff", "test", "nominal"),
    ("W_d of a test over the nominal", "W_d", "test", "nominal"),
    ("W_d of their mean over the nominal", "W_d", "mean", "nominal"),
    ("W_d of a test over their mean", "W_d", "test", "mean"),
)
ERRORS = """
[[error]]
name = "load cell"
acts = "force"
accuracy = "1 %"
means = "standard"
shared = true

[[error]]
name = "stroke"
acts = "displacement"
accuracy = "0.5 %"
means = "standard"
shared = false

[[error]]
name = "lag"
acts = "phase"
accuracy = "4 mrad"
means = "standard"
shared = true
"""


def code_at(folder: Path, over: float) -> TestCode:
    """What is asked, of a nominal that the true pads are so many times."""
    text = HEAD.format(stiffness=STORAGE / over, work=np.pi * LOSS * STROKE**2 / over)
    for name, quantity, of, to in ASKED:
        text += REQUIRE.format(name=name, quantity=quantity, of=of, to=to)
    path = folder / "study.toml"
    path.write_text(text + ERRORS, encoding="utf-8")
    return read_code(path)


def drawn(rng: np.random.Generator) -> list[LoopRecord]:
    """Records of pads that are alike but for the scatter of cycles, by instruments that are off."""
    force, phase = 0.01 * rng.standard_normal(), 0.004 * rng.standard_normal()
    angle = np.linspace(0.0, 2.0 * np.pi * (CYCLES + 2), 100 * (CYCLES + 2) + 1)
    tests = []
    for number in range(TESTS):
        # As cycles are counted. Changed at the peaks, each of them would be half of one and half of
        # the next: neighbours alike, whose mean scatters 1.5 times as much as independent ones do.
        cycle = np.floor(angle / (2.0 * np.pi)).astype(int)
        scale = 1.0 + SCATTER * rng.standard_normal(CYCLES + 3)[cycle]
        late = angle + phase
        felt = scale * STROKE * (STORAGE * np.sin(late) + LOSS * np.cos(late)) * (1.0 + force)
        way = STROKE * (1.0 + 0.005 * rng.standard_normal()) * np.sin(angle)
        felt = felt + 0.02 * rng.standard_normal(len(angle))
        name = f"pad-{number + 1}"
        tests.append(LoopRecord(angle / (2.0 * np.pi), way, felt, "mm", "kN", name))
    return tests


def first_rows(rng: np.random.Generator, code: TestCode) -> list[DecidedRow]:
    """One result of each requirement: those of other pads share its errors, and are no draws."""
    rows: dict[str, DecidedRow] = {}
    for row in certify(drawn(rng), code, why=False).rows:
        rows.setdefault(row.name, row)
    return list(rows.values())


def covered(draws: int, seed: int, folder: Path) -> Table:
    """How often the expanded uncertainty holds the true value."""
    code, inside = code_at(folder, 1.0), {name: 0 for name, *_ in ASKED}
    for i in range(draws):
        for row in first_rows(np.random.default_rng([seed, i]), code):
            inside[row.name] += abs(row.budget.value - 1.0) <= row.budget.expanded
    rows = [[name, wilson(count, draws)] for name, count in inside.items()]
    note = f"{draws} certificates of {TESTS} pads; 0.95 is stated."
    return Table("Expanded uncertainty of certificates", ("result", "covers"), rows, note)


def decided(draws: int, seed: int, folder: Path) -> Table:
    """What is decided of pads that lie at the limit."""
    code, told = code_at(folder, 1.0 + LIMIT), {name: [0, 0] for name, *_ in ASKED[:3]}
    for i in range(draws):
        for row in first_rows(np.random.default_rng([seed, 1, i]), code):
            if row.name in told:
                told[row.name][0] += row.verdict == CONFORMING
                told[row.name][1] += row.verdict == FAILING
    rows = [[name, *(wilson(count, draws) for count in told[name])] for name in told]
    note = (
        f"{draws} certificates; the guard band is the expanded uncertainty, so that 0.025 of the"
        " pads at the upper limit pass and 0.025 fail where all is as stated. Most errors are"
        " shares, so that the band is narrower below the limit than above: it is 0.027 and 0.023."
    )
    heads = ("result", "taken for conforming", "taken for not conforming")
    return Table("Decisions about pads at the limit", heads, rows, note)


def risked(draws: int, seed: int, folder: Path) -> Table:
    """How often pads about the limit are outside, by the chance of it that is stated."""
    steps = np.linspace(1.0, 1.0 + 2.0 * LIMIT, 40)
    codes, told = [code_at(folder, over) for over in steps], []
    for i in range(draws):
        rng = np.random.default_rng([seed, 2, i])
        number = int(rng.integers(len(steps)))
        names = {name for name, *_ in ASKED[:3]}
        outside = steps[number] > 1.0 + LIMIT + 1e-9
        told += [(row.risk, outside) for row in first_rows(rng, codes[number]) if row.name in names]
    risks, outside = np.array(told, dtype=float).T
    rows = []
    for low, high in pairwise((0.0, 0.05, 0.25, 0.75, 0.95, 1.0)):
        these = (risks >= low) & (risks < high) if high < 1.0 else risks >= low
        share = wilson(int(outside[these].sum()), int(these.sum()))
        rows.append([f"{low:g} to {high:g}", int(these.sum()), float(risks[these].mean()), share])
    heads = ("stated chance", "results", "its mean", "are outside")
    note = (
        f"{draws} certificates of pads from the nominal to 20 % above it; the limit is 10 %. Three"
        " results of a certificate share errors: intervals for independent ones are too narrow."
    )
    return Table("The chance that a result lies outside of its limits", heads, rows, note)


def main() -> None:
    """All three tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--draws", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=28)
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "certificates")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as folder:
        for name, table in (("covered", covered), ("decided", decided), ("risked", risked)):
            made = table(asked.draws, asked.seed, Path(folder))
            save_table(asking(__doc__, made), asked.out, name, ("md", "csv"))


if __name__ == "__main__":
    main()
