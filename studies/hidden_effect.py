"""The hidden-effect test.

Thousands of measurements with a known hidden effect go through the diagnosis.

    python studies/hidden_effect.py --cases 2000 --workers 2

Answers are appended to ``results/hidden_effect/answers.jsonl`` and a second run resumes; tables and
pictures are a pure function of that file (``--report-only`` makes them again). ``--auto N`` also
runs discovery on every N-th case, ``--signals N`` sends N cases through time signals,
``--experiments`` carries out the suggested experiments.

    python studies/hidden_effect.py --strata notch,ripple --cases 100 --seeds 20

runs 100 cases of each of these strata instead, and asks each case again with other seeds of the
simulated noise.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from hidden_effects.cases import Case, draw_case
from hidden_effects.experiments import remeasure
from hidden_effects.figures import first_class
from hidden_effects.oracle import oracle, true_ratio
from hidden_effects.report import write
from hidden_effects.rivals import rivals, sizes
from hidden_effects.signals import SignalCase, draw_signal_case
from hidden_effects.strata import STRATA, draw
from hidden_effects.strata.drawn import Drawn

ROOT = Path(__file__).resolve().parent.parent
PATIENCE = 300  # seconds until an answer counts as failed


# --- the tool under test: the only functions that know springpot
def seen(case: Case | Drawn) -> Any:
    """Return the case as the tool reads it from its file."""
    import springpot

    with tempfile.TemporaryDirectory() as folder:
        return springpot.read(case.to_csv(Path(folder) / "case.csv"))


def answer(case: Case | Drawn, model: str | None = None) -> dict[str, Any]:
    """Return the diagnosis of a case as the dictionary of schema springpot.diagnosis/2."""
    import springpot

    return dict(springpot.diagnose(seen(case), model or case.model).to_dict())


def ladder(case: Case | Drawn) -> dict[str, Any]:
    """Return automatic discovery of a case as the dictionary of schema springpot.discovery/2."""
    import springpot

    return dict(springpot.discover(seen(case), case.model).to_dict())


def verdicts(case: Case | Drawn, seeds: int) -> list[str]:
    """Return the verdicts that as many seeds of the tool's simulated noise lead to."""
    import springpot

    measurement = seen(case)
    return [
        str(springpot.diagnose(measurement, case.model, seed=seed).verdict) for seed in range(seeds)
    ]


def answer_signals(case: SignalCase) -> dict[str, Any]:
    """Return the diagnosis of records that first went through ``springpot signals``."""
    command = [sys.executable, "-m", "springpot"]
    with tempfile.TemporaryDirectory() as folder:
        files = [str(p) for p in case.to_csvs(Path(folder) / "records")]
        out = str(Path(folder) / "measurement.csv")
        subprocess.run([*command, "signals", *files, "-o", out], check=True, capture_output=True)
        shown = [*command, "diagnose", out, "--model", case.model, "--json"]
        return dict(
            json.loads(subprocess.run(shown, check=True, capture_output=True, text=True).stdout)
        )


# --- one case
def warm_up() -> None:
    """Import and compile everything once per worker, so that times are those of an answer."""
    signal.signal(signal.SIGALRM, _too_late)
    try:
        answer(draw_case(1))
    except Exception:  # the cases will report it
        return


def _too_late(*_: object) -> None:
    raise TimeoutError(f"no answer in {PATIENCE} s")


def run_case(
    seed: int, auto: bool, with_rivals: bool, experiments: bool, reference: bool, seeds: int
) -> dict[str, Any]:
    """Draw, diagnose and describe one case.

    With ``reference`` the oracle answers instead of the tool.
    """
    case = draw_case(seed)
    row = case.summary()
    row |= _timed(lambda: oracle(case) if reference else answer(case), "answer", "seconds")
    if case.kind in ("one", "two"):
        row["true_ratio"] = true_ratio(case)
    if auto:
        row |= _timed(lambda: ladder(case), "ladder", "ladder_seconds")
    if case.kind == "outside" or (with_rivals and case.kind == "one"):
        row |= {"rivals": rivals(case), "rival_sizes": sizes()}
        row["unexplained"] = (
            min(case.chi2, *row["rivals"].values()) if case.kind == "outside" else None
        )
    if experiments and row["answer"]:
        row |= _timed(lambda: tie_broken(case, row), "tie_broken", "experiment_seconds")
    if seeds > 1:
        row |= _timed(lambda: verdicts(case, seeds), "verdicts", "verdicts_seconds")
    return row


def run_stratum(stratum: str, seed: int, auto: bool, seeds: int) -> dict[str, Any]:
    """Draw and diagnose one case of a stratum, where it asks for that without a model too."""
    case = draw(stratum, seed)
    row = case.summary() | _timed(lambda: answer(case), "answer", "seconds")
    if auto:
        row |= _timed(lambda: ladder(case), "ladder", "ladder_seconds")
    if case.material:
        row |= _timed(lambda: answer(case, case.material), "material_answer", "material_seconds")
    if seeds > 1:
        row |= _timed(lambda: verdicts(case, seeds), "verdicts", "verdicts_seconds")
    return row


def run_signals(seed: int) -> dict[str, Any]:
    """Draw, reduce and diagnose one case of time signals."""
    case = draw_signal_case(seed)
    return case.summary() | _timed(lambda: answer_signals(case), "answer", "seconds")


def tie_broken(case: Case, row: dict[str, Any]) -> bool | None:
    """Carry out the suggested experiment.

    None where there is no tie or nothing that can be simulated.

    The tie is broken when the truth stays in the first class and that class has become smaller.
    """
    before = first_class(row)
    action = ((row["answer"] or {}).get("next_experiment") or {}).get("action")
    if case.kind != "one" or len(before) < 2 or not set(before) & set(case.truth) or not action:
        return None
    wider = remeasure(case, action)
    if wider is None:
        return None
    after = first_class({"answer": answer(wider)})
    return len(after) < len(before) and bool(set(after) & set(case.truth))


def _timed(call: Callable[[], Any], key: str, clock: str) -> dict[str, Any]:
    """Call the tool; a fault becomes part of the row, never a missing row."""
    start = time.perf_counter()
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        found = call()
        return {
            key: slim(found) if isinstance(found, dict) else found,
            clock: time.perf_counter() - start,
        }
    except Exception as fault:
        detail = getattr(fault, "stderr", "") or ""
        return {
            key: None,
            clock: time.perf_counter() - start,
            "fault": f"{type(fault).__name__}: {fault} {detail}"[:500],
        }
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def slim(found: dict[str, Any], most: int = 12) -> dict[str, Any]:
    """Drop prose and the tail of the ranking, to keep the file of answers small."""
    found = {k: v for k, v in found.items() if k != "where"}
    if "candidates" in found:
        drop = {"says"}
        found["candidates"] = [
            {k: v for k, v in c.items() if k not in drop} for c in found["candidates"][:most]
        ]
    if isinstance(found.get("diagnosis"), dict):
        found["diagnosis"] = slim(found["diagnosis"], 3)
    return found


# --- all cases
def run(asked: argparse.Namespace, path: Path) -> None:
    """Run what is not in the file of answers yet."""
    done = {_key(row) for row in read(path)}
    todo = [(key, function, options) for key, function, options in _jobs(asked) if key not in done]
    print(f"{len(done)} cases done, {len(todo)} to do")
    with (
        path.open("a", encoding="utf-8") as file,
        ProcessPoolExecutor(asked.workers, initializer=warm_up) as pool,
    ):
        futures = [pool.submit(function, *options) for _, function, options in todo]
        for count, future in enumerate(as_completed(futures), 1):
            file.write(json.dumps(future.result()) + "\n")
            file.flush()
            if count % 100 == 0:
                print(f"{count} of {len(todo)}", flush=True)


Job = tuple[tuple[str, int], Callable[..., dict[str, Any]], tuple[Any, ...]]


def _key(row: dict[str, Any]) -> tuple[str, int]:
    """What tells a row from all others; sweeps and fields are drawn from one row of seeds."""
    return ("cases" if row["design"] in ("sweep", "field") else row["design"]), row["seed"]


def _jobs(asked: argparse.Namespace) -> Iterator[Job]:
    """All that is asked for: a key, a function and its arguments."""
    seeds = range(asked.seed, asked.seed + asked.cases)
    for stratum in asked.strata:
        yield from (
            ((stratum, s), run_stratum, (stratum, s, _walks(asked, s), asked.seeds)) for s in seeds
        )
    if asked.strata:
        return
    plain = (not asked.no_rivals, asked.experiments, asked.reference, asked.seeds)
    yield from ((("cases", s), run_case, (s, _walks(asked, s), *plain)) for s in seeds)
    yield from (
        (("signals", s), run_signals, (s,)) for s in range(asked.seed, asked.seed + asked.signals)
    )


def _walks(asked: argparse.Namespace, seed: int) -> bool:
    """Whether this case is also discovered automatically."""
    return bool(asked.auto) and seed % asked.auto == 0


def read(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the collected rows; a last line cut short by an interruption is passed over."""
    if not path.exists():
        return
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            yield json.loads(line)
        except json.JSONDecodeError:
            continue


def _strata(text: str) -> tuple[str, ...]:
    """The named strata."""
    names = tuple(STRATA) if text == "all" else tuple(text.split(","))
    if unknown := set(names) - set(STRATA):
        raise argparse.ArgumentTypeError(
            f"no stratum {', '.join(sorted(unknown))}; there are {', '.join(STRATA)}"
        )
    return names


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--signals", type=int, default=0, metavar="N", help="cases of time signals")
    parser.add_argument(
        "--auto", type=int, default=0, metavar="N", help="discovery on every N-th case (1: all)"
    )
    parser.add_argument(
        "--experiments", action="store_true", help="carry out the suggested experiments"
    )
    parser.add_argument(
        "--no-rivals", action="store_true", help="skip the ideal rivals of one-effect cases"
    )
    parser.add_argument(
        "--reference", action="store_true", help="let the generator's own BIC selector answer"
    )
    parser.add_argument(
        "--seeds", type=int, default=1, metavar="N", help="verdicts of N seeds of simulated noise"
    )
    parser.add_argument(
        "--strata",
        type=_strata,
        default=(),
        metavar="NAME,...",
        help=f"these strata instead, or all: {', '.join(STRATA)}",
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "hidden_effect")
    parser.add_argument("--report-only", action="store_true")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    path = asked.out / "answers.jsonl"
    if not asked.report_only:
        run(asked, path)
    rows = list(read(path))
    if not rows:
        parser.error(f"{path} holds no answers yet")
    for figure in write(rows, asked.out):
        if figure.n and figure.goal is not None:
            met = "met   " if figure.met else "MISSED"
            print(
                f"{met} {figure.design:10} {figure.name:60} {figure.value:.3f} (goal"
                f" {figure.better} {figure.goal:g})"
            )


if __name__ == "__main__":
    main()
