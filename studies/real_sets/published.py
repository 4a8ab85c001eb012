"""What was found beside what is published, or what can be read off the data without a model.

Question: do the parameters that are found agree with what is published, or with what can be read
off the data without a model? Measure: each with its 95 % interval beside what is expected. What
would answer it: what is expected within the interval; where there is none, shift factors within 5 %
and an error no greater than that of the published model.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from paper.asking import asking
from springpot import Measurement, read
from springpot.benchmark import Interval, Table
from springpot.errors import DataError
from springpot.report.page import Entry

from .sets import RealSet, folders

KELVIN, KILO, GAS = 273.15, 1e3, 8.314462618
"""Zero Celsius [K], J in a kJ, molar gas constant [J/(mol K)]."""
COLUMNS = ("set", "model", "quantity", "found", "expected", "source of what is expected")
NOTE = (
    "Parameters with 95 % intervals. WLF: log10 a_T = -C1 (T - T0) / (C2 + T - T0), moved to the T0"
    " of the publication. Yield force: 4 F / pi is the first harmonic of a force of fixed size F,"
    " so that pi/4 of the median of |K| times amplitude is what an eye would read off, for all"
    " forces together."
)
WLF = {
    "pdms": (6.64 / np.log(10.0), 299.4, 25.0, (0.0, 50.0), "NIST SP 260-147"),
    # RepTate counts C2 = 114.03 K from 0 degC: from -35 degC that is 79.03 K.
    "polyisoprene": (8.772, 79.03, -35.0, (-40.0, 0.0), "RepTate, for long chains"),
}
"""C1 (log10), C2 [K], T0 [degC], temperatures compared [degC], source."""


def yardsticks(one: RealSet, data: Measurement) -> dict[str, float]:
    """Numbers of a set that need its data but none of our models."""
    amplitude = data.conditions.get("amplitude")
    found = {"reference_temperature": data.reference_temperature}
    if amplitude is not None and not data.units.is_modulus:
        found["yield_force"] = float(np.pi / 4.0 * np.median(data.magnitude * amplitude))
    if one.name == "pdms" and (error := _nist_error()):
        found["published_error"] = error
    if one.is_signals:
        found["signals_against_table"] = _against_table(
            data, read("friction-damper-brfd-lehigh@band_tension=36")
        )
    return found


def _nist_error() -> float | None:
    """Relative rms error of NIST's own fitted model, printed in the same table as the data."""
    for path in (folder / "nist-srm2491-pdms" / "normalized.csv" for folder in folders()):
        if path.exists():
            return _printed_error(path)
    return None


def _printed_error(path: Path) -> float:
    with path.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))

    def complex_of(storage: str, loss: str) -> np.ndarray[Any, Any]:
        return np.array([float(row[storage]) + 1j * float(row[loss]) for row in rows])

    measured = complex_of("storage_Pa", "loss_Pa")
    model = complex_of("storage_nist_model_Pa", "loss_nist_model_Pa")
    return float(np.sqrt(np.mean(np.abs(measured / model - 1.0) ** 2)))


def _against_table(data: Measurement, other: Measurement) -> float:
    """Largest difference between two reductions of the same tests, relative to |K|."""

    def order(of: Measurement) -> Any:
        return np.lexsort((of.conditions["amplitude"], of.omega.round(1)))

    if len(data) != len(other):
        raise DataError(
            f"{data.name}: {len(data)} tests here, {len(other)} in the table of harmonics"
        )
    ours, theirs = data.stiffness[order(data)], other.stiffness[order(other)]
    return float(np.max(np.abs(ours / theirs - 1.0)))


def asked(one: dict[str, Any]) -> str:
    """The model that discovery began with, and what it was given."""
    return one["model"] + (
        "".join(f" + {step['accepted']}" for step in one["steps"][1:]) if one["given"] else ""
    )


def published(answers: Sequence[dict[str, Any]]) -> Table:
    """What was found beside what was expected."""
    rows = [
        row
        for one in answers
        for part in (_wlf, _shifts, _errors, _force, _signals)
        for row in part(one)
    ]
    title = "Measured data: parameters against what is published"
    return asking(__doc__, Table(title, COLUMNS, rows, NOTE))


def _wlf(one: dict[str, Any]) -> Iterator[tuple[Entry, ...]]:
    """Constants of a WLF shift moved to the temperature of the publication."""
    last = one["steps"][-1]["parameters"]
    if one["set"] not in WLF or "wlf-shift.C1" not in last:
        return
    c1, c2, t0, _, source = WLF[one["set"]]
    ours = [
        [last[f"wlf-shift.{name}"][key] for key in ("value", "low", "high")]
        for name in ("C1", "C2")
    ]
    moved = t0 + KELVIN - one["yardsticks"]["reference_temperature"]
    factor = ours[1][0] / (ours[1][0] + moved)
    head = one["set"], asked(one)
    yield *head, "C1 (log10)", Interval(*(x * factor for x in ours[0])), c1, source
    yield *head, "C2 [K]", Interval(*(x + moved for x in ours[1])), c2, source


def _shifts(one: dict[str, Any]) -> Iterator[tuple[Entry, ...]]:
    """The shift itself at the ends of the temperatures: it is known where C1 and C2 are not."""
    last = one["steps"][-1]["parameters"]
    if one["set"] not in WLF or not {"wlf-shift.C1", "arrhenius-shift.Ea"} & set(last):
        return
    c1, c2, t0, ends, source = WLF[one["set"]]
    base = one["yardsticks"]["reference_temperature"] - KELVIN
    for t in ends:
        found = 10.0 ** (_log_shift(last, base, t) - _log_shift(last, base, t0))
        told = 10.0 ** (-c1 * (t - t0) / (c2 + t - t0))
        yield one["set"], asked(one), f"a_T at {t:g} degC, 1 at {t0:g} degC", found, told, source


def _log_shift(parameters: dict[str, Any], base: float, celsius: float) -> float:
    """log10 a_T of a fit whose reference temperature is `base`."""
    if "wlf-shift.C1" in parameters:
        c1, c2 = (float(parameters[f"wlf-shift.{name}"]["value"]) for name in ("C1", "C2"))
        return -c1 * (celsius - base) / (c2 + celsius - base)
    joule = float(parameters["arrhenius-shift.Ea"]["value"]) * KILO
    return joule / (GAS * np.log(10.0)) * (1.0 / (celsius + KELVIN) - 1.0 / (base + KELVIN))


def _errors(one: dict[str, Any]) -> Iterator[tuple[Entry, ...]]:
    if error := one["yardsticks"].get("published_error"):
        found = 100.0 * one["steps"][-1]["relative_rms"]
        yield (
            one["set"],
            asked(one),
            "error of the last model [%]",
            found,
            100.0 * error,
            "NIST's own model",
        )


def _force(one: dict[str, Any]) -> Iterator[tuple[Entry, ...]]:
    last = one["steps"][-1]["parameters"]
    for name in ("friction.F", "elasto-sliding.F"):
        if name in last and (expected := one["yardsticks"].get("yield_force")):
            found = Interval(*(last[name][key] for key in ("value", "low", "high")))
            yield (
                one["set"],
                asked(one),
                f"{name} [N]",
                found,
                expected,
                "pi/4 of the median force",
            )


def _signals(one: dict[str, Any]) -> Iterator[tuple[Entry, ...]]:
    if difference := one["yardsticks"].get("signals_against_table"):
        what = "largest difference of K from the set's table [%]"
        yield (
            one["set"],
            asked(one),
            what,
            100.0 * difference,
            0.0,
            "harmonics published with the signals",
        )
