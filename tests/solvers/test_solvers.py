"""What is handed over, run by the solvers themselves.

Each is skipped where it is not installed (extra `solvers`).
"""

from __future__ import annotations

import csv
import subprocess
import sys
import zipfile

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.solvers.exporting import exported

GIVEN = ["k=400", "c=60", "alpha=0.55"]
MODEL = parse_model("fractional-maxwell")
THETA = MODEL.theta(k=400.0, c=60.0, alpha=0.55)


def handed(format_name: str):
    return exported(
        "fractional-maxwell",
        format_name,
        band="1Hz:48Hz",
        values=GIVEN,
        unit="kN/m",
        tolerance="0.2%",
    )


OPENSEES = """
import sys
import numpy as np
import openseespy.opensees as ops
ops.wipe()
ops.model("basic", "-ndm", 1, "-ndf", 1)
exec(sys.stdin.read())
frequency, steps, cycles = float(sys.argv[1]), 400, 6
dt = 1.0 / (frequency * steps)
ops.setTime(0.0)
t = dt * np.arange(1, cycles * steps + 1)
ops.node(1, 0.0); ops.node(2, 0.0); ops.fix(1, 1)
ops.element("zeroLength", 1, 1, 2, "-mat", 100, "-dir", 1)
ops.timeSeries("Trig", 1, 0.0, 1e9, 1.0 / frequency)
ops.pattern("Plain", 1, 1); ops.load(2, 1.0)
ops.constraints("Plain"); ops.numberer("Plain"); ops.system("BandGeneral")
ops.mass(2, 1e-9)
ops.test("NormDispIncr", 1e-12, 50); ops.algorithm("Newton")
ops.integrator("Newmark", 0.5, 0.25); ops.analysis("Transient")
x = []
for _ in t:
    assert ops.analyze(1, dt) == 0
    x.append(ops.nodeDisp(2, 1))
x, last = np.array(x), slice((cycles - 2) * steps, None)
turn = np.exp(-2j * np.pi * frequency * t[last])
moved, pulled = (np.sum(s[last] * turn) for s in (x, np.sin(2 * np.pi * frequency * t)))
k = pulled / moved
print(k.real, k.imag)
"""


@pytest.mark.soak_cases("1.0", "8.0")
@pytest.mark.parametrize("frequency", [1.0, 8.0, 48.0])
def test_opensees_gives_k_over_the_band(frequency):
    """A node on the exported material alone, pushed by a sinusoid until it repeats itself."""
    pytest.importorskip("openseespy", reason="openseespy is not installed (extra solvers)")
    run = [sys.executable, "-c", OPENSEES, str(frequency)]
    done = subprocess.run(
        run,
        input=handed("openseespy").text,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    if "Failed to import openseespy" in done.stderr:
        pytest.skip("openseespy lacks a library of this machine, such as libblas3")
    assert done.returncode == 0, done.stderr
    storage, loss = map(float, done.stdout.split()[-2:])
    exact = MODEL.stiffness(THETA, np.array([2 * np.pi * frequency]))[0]
    assert abs(storage + 1j * loss - exact) < 0.005 * abs(exact)


T = np.linspace(0.0, 1.0, 501)
X = 0.01 * np.sin(2 * np.pi * 3.0 * T) + 0.002 * np.sin(2 * np.pi * 11.0 * T)


@pytest.fixture
def unit(tmp_path):
    """The unit as a file, compiled."""
    pytest.importorskip("fmpy", reason="fmpy is not installed (extra solvers)")
    path = tmp_path / "damper.fmu"
    path.write_bytes(handed("fmu").data)
    if not any(name.startswith("binaries/") for name in zipfile.ZipFile(path).namelist()):
        pytest.skip("there is no C compiler here: the unit holds its source only")
    return path


def series_force():
    """The exported series by the exact recursion."""
    series = handed("fmu").handoff.prony
    force, q = series.equilibrium * X, np.zeros(len(series.times))
    for k, h in enumerate(np.diff(T), 1):
        q = np.exp(-h / series.times) * q - np.expm1(-h / series.times) * series.times / h * (
            X[k] - X[k - 1]
        )
        force[k] += series.weights @ q
    return force


@pytest.mark.soak
def test_a_unit_exchanges_its_model(unit):
    """This master holds the displacement over each of its own steps: they must be short."""
    import fmpy

    signal = np.array(list(zip(T, X, strict=True)), dtype=[("time", float), ("x", float)])
    found = fmpy.simulate_fmu(
        str(unit),
        input=signal,
        output=["F"],
        fmi_type="ModelExchange",
        stop_time=0.2,
        output_interval=5e-5,
        relative_tolerance=1e-6,
    )
    early = T <= 0.2
    force = np.interp(T[early], found["time"], found["F"])
    assert np.abs(force - series_force()[early]).max() < 5e-3 * np.abs(series_force()).max()


def cosimulated(unit, derivatives):
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    told = read_model_description(str(unit))
    slave = FMU2Slave(
        guid=told.guid,
        unzipDirectory=extract(str(unit)),
        modelIdentifier=told.coSimulation.modelIdentifier,
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.setReal([0], [X[0]])
    slave.exitInitializationMode()
    force = [slave.getReal([1])[0]]
    for k, h in enumerate(np.diff(T)):
        slave.setReal([0], [X[k]])
        if derivatives:
            slave.setRealInputDerivatives([0], [1], [(X[k + 1] - X[k]) / h])
        slave.doStep(currentCommunicationPoint=T[k], communicationStepSize=h)
        force.append(slave.getReal([1])[0])
    slave.terminate()
    slave.freeInstance()
    return np.array(force)


@pytest.mark.soak
def test_in_cosimulation_it_is_exact_with_the_derivative_and_one_step_late_without(unit):
    exact = series_force()
    told = cosimulated(unit, derivatives=True)
    assert np.abs(told - exact).max() < 1e-9 * np.abs(exact).max()
    assert np.abs(told - MODEL.respond(THETA, T, X)).max() < 0.02 * np.abs(exact).max()
    late = cosimulated(unit, derivatives=False)
    assert np.abs(late[1:] - exact[:-1]).max() < 0.35 * np.abs(late[1:] - exact[1:]).max()


def test_the_unit_describes_itself_by_the_standard(tmp_path):
    pytest.importorskip("fmpy", reason="fmpy is not installed (extra solvers)")
    from fmpy.validation import validate_fmu

    path = tmp_path / "damper.fmu"
    path.write_bytes(handed("fmu").data)
    assert validate_fmu(str(path)) == []


@pytest.mark.soak
def test_the_same_model_gives_the_same_unit():
    assert handed("fmu").data == handed("fmu").data


@pytest.mark.soak
def test_nastran_cards_are_read_and_joined(tmp_path):
    pytest.importorskip("pyNastran", reason="pyNastran is not installed (extra solvers)")
    from pyNastran.bdf.bdf import BDF

    path = tmp_path / "damper.bdf"
    body = handed("nastran").text + "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nCBUSH,1,100,1,2,,,,0\n"
    path.write_text(f"SOL 108\nCEND\nBEGIN BULK\n{body}ENDDATA\n")
    model = BDF(debug=None)
    model.read_bdf(str(path))
    bush = model.pbusht[100]
    assert bush.k_tables[0] == 101
    assert bush.ge_tables[0] == 102
    table = model.tables_d[101]
    exact = MODEL.stiffness(THETA, 2 * np.pi * np.asarray(table.x))
    assert np.asarray(table.y) == pytest.approx(exact.real, rel=0.005)


STEPS = 60
"""Of a period: the force of straight pieces then repeats the sinusoid's within 0.2 %."""
SOLID = parse_model("fractional-zener")
SOLID_THETA = SOLID.theta(k1=2.0, k2=30.0, c=0.5, alpha=0.6)


@pytest.fixture(scope="module")
def terms():
    """What stands in the exported table: the spring, and weight and time of each term."""
    given = ["k1=2", "k2=30", "c=0.5", "alpha=0.6"]
    table = exported(
        "fractional-zener", "csv", band="1Hz:48Hz", values=given, unit="MPa", tolerance="0.2%"
    ).text
    rows = csv.reader(line for line in table.splitlines() if not line.startswith("#"))
    _, (_, spring, _), *rest = rows
    return (
        float(spring),
        [float(weight) for _, weight, _ in rest],
        [float(time) for _, _, time in rest],
    )


@pytest.mark.soak_cases("1.0-3", "48.0-8", "8.0-6")
@pytest.mark.parametrize(("frequency", "cycles"), [(1.0, 3), (8.0, 6), (48.0, 8)])
def test_finite_elements_run_the_series(terms, frequency, cycles):
    """Eight elements in simple shear, whose force over displacement is the shear modulus."""
    pytest.importorskip("felupe", reason="felupe is not installed (extra solvers)")
    import felupe

    spring, weights, times = terms
    t = np.arange(cycles * STEPS + 1) / (STEPS * frequency)
    moved = 0.01 * np.sin(2 * np.pi * frequency * t)
    field = felupe.FieldContainer([felupe.Field(felupe.RegionHexahedron(felupe.Cube(n=3)), dim=3)])
    law = felupe.MaterialStrain(
        felupe.linear_elastic_viscoelastic,
        μ=spring,
        λ=10.0 * spring,
        G=weights,
        τ=times,
        Δt=t[1],
        statevars=((len(times), 3, 3),),
    )
    solid, everywhere = felupe.SolidBody(law, field), np.ones(27, dtype=bool)
    bounds = {
        "no way aside": felupe.Boundary(field[0], mask=everywhere, skip=(1, 0, 0)),
        "bottom": felupe.Boundary(field[0], fy=0, skip=(0, 1, 1)),
        "top": felupe.Boundary(field[0], fy=1, skip=(0, 1, 1)),
    }
    step = felupe.Step([solid], ramp={bounds["top"]: moved[1:]}, boundaries=bounds)
    pulled = np.array(
        [
            felupe.tools.force(field, each.fun, bounds["top"])[0]
            for each in step.generate(x0=field, verbose=0)
        ]
    )
    alike = SOLID.respond(SOLID_THETA, t, moved)[1:]
    assert np.abs(pulled - alike).max() < 0.02 * np.abs(alike).max()
    turn = np.exp(-2j * np.pi * frequency * t[-STEPS:])
    found = np.sum(pulled[-STEPS:] * turn) / np.sum(moved[-STEPS:] * turn)
    exact = SOLID.stiffness(SOLID_THETA, 2 * np.pi * frequency)[0]
    assert abs(found - exact) < 0.005 * abs(exact)
