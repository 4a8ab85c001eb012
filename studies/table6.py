"""Table 6 and Figures 13 to 17.

What the range of frequencies does to the Maxwell parameters of the silicone fluid.

    springpot run studies/table6.py

The measured moduli are not printed. Three things can be done without them: the seven printed fits
are compared where each of them had data and beyond; the curve of the first row is refitted over the
seven ranges, which must return its parameters each time, so that the drift in Table 6 cannot come
from a Maxwell fluid; and the drift is shown on measured moduli of a fluid of the same kind, NIST
SRM 2491, cut to ever shorter ranges. Sensitivities are exact.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper.draw import COLOURS, Curve, can_draw, legend_above, logarithmic, moduli, sheet
from paper.results import Results, absolute_rms, relative_rms
from springpot import Measurement, open_measurement, parse_model
from springpot.benchmark import Study, Table, save_table
from springpot.report.page import Entry
from springpot.rheology import Real
from springpot_plugins.datasets.shipped import TABLE_6

MODEL = "fractional-maxwell"
ROWS = {
    row: (top, {"k": e, "c": eta, "alpha": alpha})
    for row, (top, e, eta, alpha) in enumerate(TABLE_6, 1)
}
LOWEST, TOP = 0.3, TABLE_6[0][0]
NIST = "nist-srm2491@temperature=20"
NIST_TOPS = (16.0, 10.1, 6.4, 4.1, 2.6)
SENSITIVITIES = {15: ("k", "E", "-"), 16: ("c", "η", "s$^{-α}$"), 17: ("alpha", "α", "Pa")}
SIMILAR = 0.1


def cut(data: Measurement, top: float, name: str) -> Measurement:
    """The part of the data from 0.3 Hz to `top`."""
    inside = (data.frequency >= LOWEST * (1 - 1e-9)) & (data.frequency <= top * (1 + 1e-9))
    return data.subset(inside, name)


def reconstruction(top: float) -> Measurement:
    """The curve of the first row, over a shorter range."""
    return cut(open_measurement("reconstruction-pdms-table6-1"), top, f"table6-row1-to-{top:g}Hz")


def nist(top: float) -> Measurement:
    """NIST's fluid at 20 degC, over a shorter range."""
    return cut(open_measurement(NIST), top, f"nist-20C-to-{top:g}Hz")


DATA = [*(reconstruction(top) for top, _ in ROWS.values()), *(nist(top) for top in NIST_TOPS)]


def finish(path: Path, folder: Path) -> None:
    """Write the tables and the figures."""
    results = Results.of(path)
    save_table(table(results), folder, "table6")
    save_table(validity(), folder, "validity")
    if can_draw(folder):
        figures(folder)


def table(results: Results) -> Table:
    """The paper's rows, the first refitted over each range, and the measured fluid cut likewise."""
    rows: list[tuple[Entry, ...]] = [
        ("paper", f"{LOWEST}-{top:g}", None, *theta.values(), None, None)
        for top, theta in ROWS.values()
    ]
    for data in DATA:
        best = results.best(data.name, MODEL)
        if best:
            source = (
                "curve of row 1" if data.name.startswith("table6") else "NIST SRM 2491, 20 degC"
            )
            error = absolute_rms(MODEL, best.theta, data)
            reach = f"{LOWEST}-{data.name.split('-to-')[1].removesuffix('Hz')}"
            rows.append(
                (
                    source,
                    reach,
                    len(data),
                    *best.theta.values(),
                    relative_rms(MODEL, best.theta, data),
                    error,
                )
            )
    columns = ("data", "range [Hz]", "points", "E [Pa]", "eta [Pa s^alpha]", "alpha [-]")
    note = (
        "Maxwell model, best run of both optimisers by eq. (44). Error by eq. (44): root of the sum"
        " of |E - E_m|^2 over that of |E_m|^2. The curve of row 1 is a reconstruction, the same"
        " over every range: the drift in the paper's rows means that the fluid is no fractional"
        " Maxwell fluid (or that a search stopped early). NIST's moduli are measured: there the"
        " shorter range gives the smaller E and eta and the larger alpha, as in Table 6."
    )
    head = (*columns, "relative rms error", "error by eq. (44)")
    return Table("Table 6: range of frequencies and Maxwell parameters", head, rows, note)


def validity() -> Table:
    """How far each printed fit is from the first, in its range and outside, and where it holds."""
    full = open_measurement("reconstruction-pdms-table6-1")
    rows: list[tuple[Entry, ...]] = []
    for row, (top, theta) in ROWS.items():
        inside = relative_rms(MODEL, theta, reconstruction(top))
        alike = [similar_to(row, name) for name, _, _ in SENSITIVITIES.values()]
        rows.append((row, top, inside, relative_rms(MODEL, theta, full), peak(theta), *alike))
    note = (
        "Distance: relative rms difference from the curve of row 1. Largest E'': frequency of its"
        " maximum. Similar: up to which frequency a sensitivity of E'' stays within"
        f" {100 * SIMILAR:g} % (of its largest size in row 1) of that of row 1, looked for up to 63"
        " Hz. The text sees a minimum of E'' with the last row; a fractional Maxwell model has"
        " none, what the row has inside the range is the maximum."
    )
    columns = (
        "row",
        "range to [Hz]",
        "distance inside",
        "distance to 63 Hz",
        "largest E'' at [Hz]",
    )
    similar = tuple(f"dE''/d{name} similar to [Hz]" for name in ("E", "eta", "alpha"))
    return Table("Where the fits of Table 6 agree", (*columns, *similar), rows, note)


def peak(theta: dict[str, float]) -> float:
    """Frequency in Hz at which the loss modulus is largest."""
    grid = np.geomspace(0.01, 1e4, 20001)
    return float(grid[np.argmax(Curve("", MODEL, theta).at(2 * np.pi * grid).imag)])


def similar_to(row: int, name: str) -> float:
    """Up to which frequency in Hz a sensitivity is that of the first row."""
    hertz = np.linspace(LOWEST, TOP, 6271)
    first, other = sensitivity(1, name, hertz), sensitivity(row, name, hertz)
    apart = np.abs(other - first) > SIMILAR * np.max(np.abs(first))
    return float(hertz[np.argmax(apart)]) if apart.any() else TOP


def sensitivity(row: int, name: str, hertz: Real) -> Real:
    """Exact derivative of the loss modulus by a parameter, with the parameters of a row."""
    model = parse_model(MODEL)
    slopes = model.jacobian(model.vector(ROWS[row][1]), 2.0 * np.pi * hertz)
    column: Real = slopes[:, model.names.index(name)].imag
    return column


def figures(folder: Path) -> None:
    """Figures 13 and 14: the moduli of all rows.

    Figures 15 to 17: the sensitivities of the loss modulus.
    """
    shades = {row: COLOURS[i % 7] for i, row in enumerate(ROWS)}
    for number, part in ((13, "storage"), (14, "loss")):
        curves = []
        for row, (top, theta) in ROWS.items():
            line = {1: "-", 7: ":"}.get(row, "--")
            style = {"color": shades[row], "marker": None, "linestyle": line}
            style["linewidth"] = 2.2 if row in (1, 7) else 1.1
            curves.append(Curve(f"{row}: 0.3-{top:g} Hz", MODEL, theta, style))
        with sheet(folder, f"figure{number}", 7.4, 4.8) as page:
            axes = page.subplots()
            moduli(axes, open_measurement("reconstruction-pdms-table6-1"), curves, part, log=False)
            axes.lines[-1].remove()
            for curve, (top, _) in zip(curves, ROWS.values(), strict=True):
                end = curve.at(np.array([2 * np.pi * top]))[0]
                axes.plot(
                    top,
                    end.real if part == "storage" else end.imag,
                    "o",
                    color=curve.style["color"],
                )
            legend_above(
                page,
                axes,
                f"Figure {number}: {part} modulus of the fits in Table 6; dots end their data",
                4,
            )
    for number, (name, symbol, unit) in SENSITIVITIES.items():
        with sheet(folder, f"figure{number}", 7.4, 4.8) as page:
            axes = page.subplots()
            hertz = np.geomspace(LOWEST, TOP, 200)
            for row, (top, _) in ROWS.items():
                axes.plot(
                    hertz,
                    sensitivity(row, name, hertz),
                    color=shades[row],
                    label=f"{row}: 0.3-{top:g} Hz",
                )
                axes.plot(top, sensitivity(row, name, np.array([top])), "o", color=shades[row])
            logarithmic(axes, "x")
            axes.set(xlabel="frequency f [Hz]", ylabel=f"∂E''/∂{symbol} [{unit}]")
            legend_above(
                page,
                axes,
                f"Figure {number}: sensitivity of the loss modulus; dots end the data",
                4,
            )


study = Study(
    "table6",
    datasets=DATA,
    models=[MODEL],
    objectives=["paper"],
    optimisers=["pso-paper", "native"],
    repetitions=5,
    budget=8020,
    asks=(
        "Why do the Maxwell parameters drift with the range of frequencies?",
        "Parameters over ever shorter ranges, of a fractional Maxwell fluid and of a measured one.",
        "None in the first and the paper's drift in the second: the fluid is no fractional"
        " Maxwell fluid.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
