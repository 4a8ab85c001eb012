"""What is found is told in the words in which the data came: rad/s and G', Hz and stiffness."""

import re
from dataclasses import replace
from html import unescape
from math import inf, nan
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.diagnosis.result import AsTold, Candidate, Diagnosis
from springpot.identification.value import PartResult, Value
from springpot.misfit.error import Error
from springpot.misfit.where import Where
from springpot.registry import parse_model, plugins
from springpot.report.told import told

pytestmark = pytest.mark.usefixtures("asked_once")

MODEL = ("--model", "fractional-maxwell")
OMEGA = np.geomspace(1.0, 100.0, 15)


def table(omega, header, mass=0.02):
    """A fractional Maxwell element with a mass that the model lacks."""
    stiffness = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * (1j * omega) ** 0.5)) - mass * omega**2
    first = omega / (2.0 * np.pi) if "Hz" in header else omega
    rows = [
        f"{x!r},{k.real!r},{k.imag!r}"
        for x, k in zip(first.tolist(), stiffness.tolist(), strict=True)
    ]
    return "\n".join([header, *rows]) + "\n"


@pytest.fixture
def rheometer(write):
    """As a rheometer exports it."""
    return write(table(OMEGA, "Angular frequency [rad/s],G' [Pa],G'' [Pa]"), "rheometer.csv")


@pytest.mark.soak
def test_a_rheologist_reads_omega_and_the_letters_of_the_file(springpot, rheometer):
    for command in (["inspect"], ["identify", *MODEL], ["compare", *MODEL], ["diagnose", *MODEL]):
        said = springpot(command[0], rheometer, *command[1:])
        assert said.code == 0, said.err
        assert "Hz" not in said.out, said.out
        assert "rad/s" in said.out or command[0] == "compare"
        assert "|K|" not in said.out
        assert "G'" in said.out or command[0] == "diagnose"
    where = springpot("compare", rheometer, *MODEL).out
    assert "% of |G*| too " in where


def test_a_damper_engineer_reads_hertz_and_stiffness(springpot, write):
    damper = write(table(OMEGA, "frequency [Hz],storage [kN/m],loss [kN/m]"), "rig.csv")
    said = springpot("compare", damper, *MODEL).out
    assert "stiffness" in said
    assert "% of |K| too " in said
    assert "Hz" in said
    assert "modulus" not in said
    assert "rad/s" not in said


@pytest.mark.soak
def test_json_stays_in_hertz(springpot, rheometer, write):
    """Words change with the file, numbers for programs never."""
    same = write(table(OMEGA, "frequency [Hz],storage [Pa],loss [Pa]"), "hertz.csv")
    first, second = (
        springpot("compare", path, *MODEL, "--json").json for path in (rheometer, same)
    )
    where, again = (answer["models"][0]["where"] for answer in (first, second))
    assert where
    assert [place["from"] for place in where] == pytest.approx([place["from"] for place in again])
    assert springpot("inspect", rheometer, "--json").json["frequency"]["unit"] == "Hz"


def test_a_share_beyond_all_is_written_out():
    """A stiffness that is twentyfold too high is off by 1900 %, not by 1.9e+03 %."""
    from springpot import Measurement
    from springpot.misfit.where import PlaneOfFit, _place

    data = Measurement(OMEGA, np.full(15, 100.0 + 1.0j))
    part = PlaneOfFit(
        data.units.storage, np.full(15, -1900.0), np.full(15, -19.0), np.full(15, -50.0)
    )
    assert _place(data, [], part, np.arange(15), "stiffness").says.startswith(
        "storage modulus 1900 % of |G*| too high"
    )


def test_far_from_the_noise_without_a_pattern_is_no_noise(springpot, write, rng):
    """Scatter of 30 % in one direction of an otherwise smooth curve is not 'nothing but noise'."""
    from springpot.comparison import Judgement
    from springpot.misfit.error import Error

    class Quiet(Judgement):
        fails = False
        refit = property(lambda self: self.fitted)

    def judged(size):
        known = SimpleNamespace(dof=40, source="estimated")
        fitted = SimpleNamespace(
            fit=known, noise=known, relative_rms=size, error=size, floor=0.01, error_dof=40
        )
        return Quiet.told(fitted, Error(size, 0.01, "estimated", "", 0.005), 0.0, {})

    far, near = judged(0.2), judged(0.012)
    assert (far.unclear, near.unclear) == (True, False)
    assert "cannot tell" in far.says
    assert near.says.endswith("nothing is left but noise")


@pytest.mark.soak
def test_where_the_floor_moves_a_line_says_why(springpot):
    """Amplitudes that differ from point to point leave no smooth curve to take scatter from."""
    import springpot as package

    ladder = package.discover(
        "artificial-hidden", "fractional-maxwell", accept=["inertia", "time-delay"]
    )
    floors = [step.noise_floor for step in ladder.steps]
    assert max(floors) > 1.1 * min(floors)
    said = told(ladder, 80)
    assert "the noise floor moved from 1.2 % to 0.85 %: it is estimated" in said
    assert "diagnose may find a lower one" in springpot("identify", "artificial-hidden", *MODEL).out
    table = said.split("\n\n")[1]
    assert max(map(len, table.splitlines())) <= 80
    assert "+ time-delay" in table


def test_no_reason_is_given_where_nothing_moved():
    from types import SimpleNamespace

    from springpot.report.ladder_text import floor_moved

    def steps(*floors, source="estimated"):
        error = SimpleNamespace(noise_source=source)
        rungs = [SimpleNamespace(noise_floor=floor) for floor in floors]
        return SimpleNamespace(steps=rungs, diagnosis=SimpleNamespace(error=error))

    assert floor_moved(steps(0.010, 0.0101)) == ""
    assert floor_moved(steps(0.010, 0.005, source="repeats")) == ""
    assert floor_moved(steps(0.010, 0.005)).startswith("the noise floor moved from 1.0 % to 0.50 %")


@pytest.mark.soak
def test_comparisons_fit_the_window_and_name_the_next_command(springpot, rheometer, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    models = ("-m", "fractional-maxwell", "-m", "fractional-maxwell + inertia")
    lines = springpot("compare", rheometer, *models).out.splitlines()
    assert (
        lines[-1] == f"next: springpot identify {rheometer} --model 'fractional-maxwell + inertia'"
    )
    assert max(map(len, lines[:-1])) <= 80
    lines = springpot("compare", rheometer, "-m", "fractional-maxwell").out.splitlines()
    assert lines[-1].startswith("next: springpot diagnose ")


@pytest.mark.soak
def test_a_master_curve_speaks_of_a_T(springpot, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    lines = springpot("mastercurve", "nist-srm2491").out.splitlines()
    assert any("a_T" in line and "b_T" in line for line in lines)
    assert max(map(len, lines)) <= 80


def diagnosed_in_time() -> Diagnosis:
    """A diagnosis of a record, with long sentences."""
    inertia = Candidate(
        plugins().effect("inertia"),
        alike=("inertia", "specimen-inertia"),
        probability=0.97,
        delta_bic=1234.5,
        score=nan,
        verdict="missing",
        predicted_error=nan,
        bound=inf,
        says="a mass " * 20,
        alone=AsTold(0.0051, 1.02, {"m": Value(0.25, 0.24, 0.26, "kg")}),
    )
    says = "record is missed most " * 8
    return Diagnosis(
        data="record",
        model=parse_model("zener"),
        error=Error(0.1, 0.005, "residual", "", nan, nan),
        verdict="effect-missing",
        says="the error is " * 12,
        split="",
        where=(Where("signal", "record", 0.1, 0.2, 9.0, says),),
        candidates=(inertia,),
        classes=(("inertia", "specimen-inertia"),),
        leading=("inertia",),
        tests=(PartResult("record", "history", 99, 0.1, 0.005, 20.0, 20.0),),
        left_out={"gain-error": "nothing follows it"},
    )


def test_an_answer_in_time_fits_the_window():
    text = told(diagnosed_in_time(), 80)
    assert max(map(len, text.splitlines())) <= 80
    assert "m 0.250 [0.240, 0.260] kg" in text


def test_terminal_and_notebook_tell_one_document():
    """An answer was laid out several times, and each layout told something else."""
    found = diagnosed_in_time()
    page = unescape(re.sub(r"<[^>]+>", " ", found._repr_html_()))
    words = [word for word in told(found, 400).split() if set(word) - {"-"}]
    assert {word for word in words if word not in page} == set()
    for said in ("specimen-inertia", "0.51 % (1.0 x)", "left out", "nothing follows it"):
        assert said in page


@pytest.mark.parametrize("verdict", ["adequate", "unexplained"])
def test_a_column_that_says_nothing_is_left_out(verdict: str):
    text = told(replace(diagnosed_in_time(), verdict=verdict), 400)
    assert "predicted" not in text
    assert "material floor" not in text
    # Nor is there a ranking where nothing is missing.
    assert ("probability" in text) is (verdict != "adequate")


@pytest.mark.soak_cases("fractional-maxwell + inertia + time-delay-False")
@pytest.mark.parametrize(
    ("model", "biased"),
    [("fractional-maxwell", True), ("fractional-maxwell + inertia + time-delay", False)],
)
def test_intervals_of_a_model_that_misses_something_say_so(springpot, model: str, biased: bool):
    told = springpot("identify", "artificial-hidden", "--model", model).out
    assert ("what it misses may move its parameters" in " ".join(told.split())) == biased
