"""The paper's own kind of fluid, measured.

NIST SRM 2491, a certified polydimethylsiloxane, at six temperatures.

    springpot run studies/nist_fluid.py

Every fluid model of the paper is fitted at each temperature, weighted by NIST's standard
uncertainties, so that an error of 1 sd means a fit as good as the data. Then all temperatures are
fitted at once, with and without a shift by the WLF equation, whose constants are set beside NIST's:
C1 = 6.64 (natural logarithm), C2 = 299.4 K at 25 degC.
"""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path

import numpy as np

from paper.draw import COLOURS, INK, MARKERS, can_draw, legend_above, logarithmic, sheet
from paper.published import FLUIDS, in_fluid_columns
from paper.results import Results, relative_rms, sd_rms
from springpot import identify, open_measurement
from springpot.benchmark import Interval, Study, Table, save_table
from springpot.identification import Identification
from springpot.measurement import DataSet
from springpot.report.figures import figure_identification
from springpot.report.page import Entry
from springpot.report.views import DrawnFit

ALL = "nist-srm2491"
TEMPERATURES = (0, 10, 20, 30, 40, 50)
MODELS = FLUIDS | {"oldroyd-b": "Oldroyd-B, eq. (28)"}
SHIFTED = ("fractional-maxwell", "fractional-maxwell-ab", "maxwell-5")
YARDSTICK = "maxwell-5"
NESTED = {
    "fractional-maxwell": 9.0,
    "fractional-kelvin4": 6.0,
    "fractional-zener": 3.5,
    "oldroyd-b": 1.0,
}
"""Widths of lines that lie on each other."""
NIST_C1, NIST_C2, NIST_T = 6.64, 299.4, 25.0


def at(temperature: int) -> str:
    """Name of the data at one temperature."""
    return f"{ALL}@temperature={temperature}"


def dataset(name: str) -> DataSet:
    """The data with k-bar of the order of the fluid's E, which the frequencies do not reach."""
    return DataSet(name, "NIST SRM 2491", partial(open_measurement, name), stiffness_scale=50000.0)


def finish(path: Path, folder: Path) -> None:
    """Write tables and figures."""
    results = Results.of(path)
    save_table(isothermal(results), folder, "isothermal")
    save_table(together(), folder, "all_temperatures")
    save_table(shifts(), folder, "shift_factors")
    if can_draw(folder):
        draw_errors(results, folder)
        draw_parameters(results, folder)
        draw_shifts(folder)
        best = fitted("fractional-maxwell-ab + wlf-shift + vertical-shift")
        for suffix in ("png", "svg"):
            data = open_measurement(ALL)
            figure_identification(
                data, [DrawnFit(best.model, best.theta)], folder / f"all_temperatures.{suffix}"
            )


def isothermal(results: Results) -> Table:
    """Each model at each temperature."""
    rows: list[tuple[Entry, ...]] = []
    for temperature in TEMPERATURES:
        data = open_measurement(at(temperature))
        for model, title in MODELS.items():
            for who in ("pso-paper", "native"):
                best = results.best(at(temperature), model, who)
                if best:
                    errors = sd_rms(model, best.theta, data), relative_rms(model, best.theta, data)
                    rows.append(
                        (temperature, title, who, *in_fluid_columns(model, best.theta), *errors)
                    )
    values = ("E or E1 [Pa]", "eta or eta2 [Pa s^alpha]", "E2 [Pa]", "alpha [-]")
    note = (
        "16 frequencies from 0.1 to 100 rad/s at each temperature. Error in sd: root mean square of"
        " the differences of E' and E'' over NIST's standard uncertainties; 1 or less is as good as"
        " the data. Relative rms error: that of |E - E_m| / |E_m|. Best of three runs. A zero is"
        " printed as the lower end of the search box. Oldroyd-B is the Zener model in other"
        " parameters. Of the model with two orders E, E tau^beta and beta are given."
    )
    columns = ("temperature [degC]", "model", "who", *values, "error in sd", "relative rms error")
    return Table("NIST SRM 2491: models of the paper at each temperature", columns, rows, note)


@cache
def fitted(expression: str) -> Identification:
    """A model fitted to all temperatures at once."""
    found: Identification = identify(open_measurement(ALL), expression)
    return found


def together() -> Table:
    """All temperatures at once: without a shift, with WLF, and with a vertical shift too."""
    rows: list[tuple[Entry, ...]] = []
    for base in SHIFTED:
        for shift in ("", " + wlf-shift", " + wlf-shift + vertical-shift"):
            found = fitted(base + shift)
            data = found.measurement
            theta = dict(zip(found.model.names, found.theta.tolist(), strict=True))
            errors = sd_rms(found.model, theta, data), relative_rms(found.model, theta, data)
            power = theta.get("vertical-shift.n")
            rows.append((base + shift, len(theta), *errors, *constants(found), power))
    rows.append(("NIST", None, None, None, NIST_C1, NIST_C2, None))
    columns = (
        "model",
        "parameters",
        "error in sd",
        "relative rms error",
        "C1 (ln, 25 degC)",
        "C2 at 25 degC [K]",
    )
    note = (
        "96 points, weighted by NIST's standard uncertainties. WLF: ln a_T = -C1 (T - 25) / (C2 +"
        " T - 25); constants with 95 % intervals from the Jacobian, which hold only where the"
        " error is near 1 sd. n: power of the absolute temperature by which all moduli rise."
        f" {YARDSTICK}, five classical Maxwell elements, is no model of the paper but shows how"
        " good a fit of these data can be."
    )
    return Table(
        "NIST SRM 2491: all temperatures at once", (*columns, "vertical shift n"), rows, note
    )


def constants(found: Identification) -> tuple[Interval | None, Interval | None]:
    """C1 for the natural logarithm and C2, moved from the fit's reference to 25 degC."""
    names = found.model.names
    if "wlf-shift.C1" not in names:
        return None, None
    i, j = names.index("wlf-shift.C1"), names.index("wlf-shift.C2")
    c2 = found.theta[j]
    moved = NIST_T - (found.measurement.reference_temperature - 273.15)
    factor = np.log(10.0) * c2 / (c2 + moved)
    one, two = (
        [float(column[k]) for column in (found.theta, found.low, found.high)] for k in (i, j)
    )
    return Interval(*(factor * value for value in one)), Interval(*(value + moved for value in two))


def log_shift(found: Identification, temperature: float) -> float:
    """Ln a_T of a fit, counted from 25 degC."""
    c1, c2 = constants(found)
    assert c1 is not None
    assert c2 is not None
    return wlf(c1.value, c2.value, temperature)


def wlf(c1: float, c2: float, temperature: float) -> float:
    """Ln a_T by the WLF equation from 25 degC."""
    return -c1 * (temperature - NIST_T) / (c2 + temperature - NIST_T)


def shifts() -> Table:
    """Shift factors themselves: C1 and C2 of good fits may differ widely where a_T does not."""
    models = [
        base + shift
        for base in SHIFTED
        for shift in (" + wlf-shift", " + wlf-shift + vertical-shift")
    ]
    rows: list[tuple[Entry, ...]] = [
        ("NIST", *(float(np.exp(wlf(NIST_C1, NIST_C2, t))) for t in TEMPERATURES))
    ]
    rows += [(m, *(float(np.exp(log_shift(fitted(m), t))) for t in TEMPERATURES)) for m in models]
    columns = ("model", *(f"{t} degC" for t in TEMPERATURES))
    note = "a_T by which frequencies are multiplied, counted from 25 degC, where it is 1."
    return Table("NIST SRM 2491: shift factors", columns, rows, note)


def draw_errors(results: Results, folder: Path) -> None:
    """Error in standard uncertainties of every model against temperature."""
    with sheet(folder, "errors", 7.4, 4.8) as page:
        axes = page.subplots()
        for i, (model, title) in enumerate(MODELS.items()):
            found = [error_at(results, model, t) for t in TEMPERATURES]
            width = NESTED.get(model, 1.6)
            axes.plot(
                TEMPERATURES,
                found,
                color=COLOURS[i],
                marker=MARKERS[i],
                label=title,
                linewidth=width,
            )
        axes.axhline(1.0, color=INK, linewidth=1.0, linestyle=":", label="as good as the data")
        logarithmic(axes, "y")
        axes.set(xlabel="temperature [°C]", ylabel="rms error in standard uncertainties")
        legend_above(page, axes, "NIST SRM 2491: models fitted at each temperature")


def error_at(results: Results, model: str, temperature: int) -> float:
    """Error of a model's best fit, nan where there is none."""
    best = results.best(at(temperature), model)
    return sd_rms(model, best.theta, open_measurement(at(temperature))) if best else np.nan


def draw_parameters(results: Results, folder: Path) -> None:
    """Parameters of two models against temperature."""
    shown = {
        "fractional-maxwell": (("k", "E [Pa]"), ("c", "η [Pa s$^α$]"), ("alpha", "α [-]")),
        "fractional-maxwell-ab": (("k", "E [Pa]"), ("tau", "τ [s]"), ("ratio", "α/β [-]")),
    }
    with sheet(folder, "parameters", 9.6, 5.4) as page:
        for panels, (model, names) in zip(
            page.subplots(2, 3, sharex=True), shown.items(), strict=True
        ):
            trials = {t: best.theta for t in TEMPERATURES if (best := results.best(at(t), model))}
            for axes, (name, label) in zip(panels, names, strict=True):
                axes.plot(
                    list(trials), [theta[name] for theta in trials.values()], "o-", color=COLOURS[0]
                )
                axes.set(ylabel=label)
                axes.margins(y=0.15)
            panels[0].set_title(f"{MODELS[model]}")
        for axes in panels:
            axes.set(xlabel="temperature [°C]")


def draw_shifts(folder: Path) -> None:
    """Shift factors relative to NIST's, in per cent."""
    fine = np.linspace(0.0, 50.0, 101)
    with sheet(folder, "shift_factors", 7.4, 4.4) as page:
        axes = page.subplots()
        for i, base in enumerate(SHIFTED):
            for shift, line in ((" + wlf-shift", "--"), (" + wlf-shift + vertical-shift", "-")):
                found = fitted(base + shift)
                gap = [100 * np.expm1(log_shift(found, t) - wlf(NIST_C1, NIST_C2, t)) for t in fine]
                label = f"{base}, WLF{' and vertical' if 'vertical' in shift else ''}"
                axes.plot(fine, gap, line, color=COLOURS[i], label=label)
        axes.axhline(0.0, color=INK, linewidth=1.0)
        axes.set(xlabel="temperature [°C]", ylabel="a$_T$ relative to NIST's [%]")
        legend_above(
            page, axes, "NIST SRM 2491: shift factors against those that NIST states", columns=2
        )


study = Study(
    "nist_fluid",
    datasets=[dataset(at(temperature)) for temperature in TEMPERATURES],
    models=list(MODELS),
    objectives=["weighted"],
    optimisers=["pso-paper", "native"],
    repetitions=3,
    budget=8020,
    asks=(
        "Which of the paper's models describes its kind of fluid within what its measurement"
        " can tell?",
        "The error in standard uncertainties at each temperature, and of all together with a"
        " shift.",
        "One of at most about one: as good as the data. Shift factors and constants beside"
        " NIST's own.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
