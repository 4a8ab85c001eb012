"""A force of opposite sign is told by every command that opens it, with the one that turns it."""

import json
import re
import shlex

import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("asked_once")

TIME = np.linspace(0.0, 4.0, 401)
MOVED = np.sin(2.0 * np.pi * TIME)
FEW = ("--effects", "inertia,time-delay")


def record(write, force, name="rig.csv"):
    rows = (
        f"{t!r},{x!r},{f!r}"
        for t, x, f in zip(TIME.tolist(), MOVED.tolist(), force.tolist(), strict=True)
    )
    return write("\n".join(["time [s],displacement [mm],force [N]", *rows]) + "\n", name)


@pytest.mark.soak
def test_a_record_of_a_force_that_counts_the_other_way_is_diagnosed_the_other_way_next(
    springpot, write, rng
):
    force = -3.0 * np.sin(2.0 * np.pi * TIME + 0.4) + 0.01 * rng.normal(size=len(TIME))
    path = record(write, force, "my rig.csv")
    answer = springpot("diagnose", path, "--model", "kelvin")
    assert "the specimen gives work away, as if the force had the wrong sign" in answer.err
    assert answer.out.splitlines()[1].startswith("the force seems to count the other way")
    command = shlex.split(re.search(r"^next: springpot (.*)$", answer.out, re.MULTILINE)[1])
    assert command == ["diagnose", f"{path}?force=-N", "--model", "kelvin"]
    assert (
        "wrong sign"
        in json.loads(springpot("diagnose", path, "--model", "kelvin", "--json").out)["notes"][0]
    )
    climbed = springpot("discover", path, "--model", "kelvin", "--auto")
    assert climbed.out.splitlines()[-1] == f"next: springpot {shlex.join(command)}"
    turned = springpot(*command)
    assert turned.code == 0
    assert "wrong sign" not in turned.err


@pytest.mark.parametrize(
    "force",
    [
        3.0 * np.sin(2.0 * np.pi * TIME + 0.4),
        3.0 * np.sin(2.0 * np.pi * TIME + 2.7),  # above a resonance
        3.0 * np.sin(2.0 * np.pi * TIME - 0.05),  # a force that is read late
        1.0 + 0.5 * np.sign(np.cos(2.0 * np.pi * TIME)),  # friction under a preload
    ],
)
def test_no_other_record_is_doubted(springpot, write, force):
    answer = springpot("inspect", record(write, force))
    assert "wrong sign" not in answer.out


def test_a_step_that_is_answered_the_other_way_is_told(springpot, write):
    rows = "".join(f"{0.1 * i},1,{-5 * (i + 1) ** -0.2}\n" for i in range(30))
    path = write("time [s],displacement [mm],force [N]\n0,0,0\n" + rows)
    answer = springpot("inspect", path)
    assert "force and displacement are opposed" in answer.out


HERTZ = np.geomspace(0.5, 50.0, 12)
SOFT = 100.0 * (1j * HERTZ) ** 0.3


@pytest.mark.parametrize(
    ("head", "columns", "way"),
    [
        ("K' [N/mm],K'' [N/mm]", (SOFT.real, -SOFT.imag), "loss=-N/mm"),
        ("|K| [N/mm],phase [deg]", (abs(SOFT), -np.degrees(np.angle(SOFT))), "phase=-deg"),
    ],
)
def test_a_phase_of_the_other_sign_is_told_with_what_turns_it(springpot, write, head, columns, way):
    rows = [",".join(map(repr, row)) for row in np.column_stack([HERTZ, *columns]).tolist()]
    path = write("\n".join([f"f [Hz],{head}", *rows]) + "\n")
    answer = springpot("inspect", path)
    assert f"the {way.partition('=')[0]} counts the other way, open '{path}?{way}'" in " ".join(
        answer.out.split()
    )
    assert "wrong sign" not in springpot("inspect", f"{path}?{way}").out


def test_a_loss_that_is_negative_by_a_little_is_no_wrong_sign(springpot, write):
    late = 100.0 * np.exp(-0.05j) * np.ones(12)
    rows = [f"{f},{k.real},{k.imag}" for f, k in zip(HERTZ, late, strict=True)]
    path = write("\n".join(["f [Hz],K' [N/mm],K'' [N/mm]", *rows]) + "\n")
    assert "as if" not in springpot("inspect", path).out


@pytest.mark.soak
def test_where_the_phase_counts_the_other_way_no_effect_is_named(springpot, write, rng):
    noisy = np.conj(SOFT) * (1.0 + 0.005 * (rng.normal(size=12) + 1j * rng.normal(size=12)))
    rows = [f"{f},{k.real},{k.imag}" for f, k in zip(HERTZ, noisy, strict=True)]
    path = write("\n".join(["f [Hz],K' [N/mm],K'' [N/mm]", *rows]) + "\n")
    answer = springpot("diagnose", path, "--model", "kelvin")
    assert answer.out.splitlines()[1].startswith("the phase seems to count the other way")
    command = shlex.split(re.search(r"^next: springpot (.*)$", answer.out, re.MULTILINE)[1])
    assert command == ["diagnose", f"{path}?loss=-N/mm", "--model", "kelvin"]
    assert not json.loads(springpot("diagnose", path, "--model", "kelvin", "--json").out)["leading"]
    climbed = springpot("discover", path, "--model", "kelvin", "--accept", "inertia")
    assert climbed.code == 0
    last = shlex.split(climbed.out.splitlines()[-1])
    assert last == ["next:", "springpot", *command]


# The best model of such data has no stiffness at all, and the warnings that makes are another
# matter.
@pytest.mark.soak
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_sweep_of_a_force_that_counts_the_other_way_is_diagnosed_the_other_way_next(
    springpot, damper
):
    lines = damper.read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    damper.write_text("\n".join([lines[0], *(f"{f},-{k},-{c}" for f, k, c in rows)]) + "\n")
    answer = springpot("diagnose", damper, "--model", "maxwell", *FEW)
    assert answer.code == 0, answer.err
    assert "storage and loss are negative, as if the force had the wrong sign" in answer.err
    assert answer.out.splitlines()[1].startswith("the force seems to count the other way")
    command = shlex.split(re.search(r"^next: springpot (.*)$", answer.out, re.MULTILINE)[1])
    assert command[:2] == ["diagnose", f"{damper}?storage=-kN/m,loss=-kN/m"]
    assert "wrong sign" not in springpot("inspect", command[1]).out
    assert answer.out.count("wrong sign") == 0
    kept = json.loads(springpot("diagnose", damper, "--model", "maxwell", *FEW, "--json").out)
    assert any("wrong sign" in note for note in kept["notes"])


@pytest.mark.soak_cases("identify {data} --model material --figure {figure}")
@pytest.mark.parametrize(
    "arguments",
    [
        "identify {data} --model material --figure {figure}",
        pytest.param("discover {data} --model kelvin --auto", marks=pytest.mark.soak),
    ],
)
def test_a_model_without_any_stiffness_is_judged_as_others_are(
    springpot, write, rng, tmp_path, arguments
):
    """Any material's best answer to a turned force is none: it is off by 100 %, not a fault."""
    omega = np.geomspace(1.0, 300.0, 16)
    stiffness = -50.0 * (1.0 + 0.01 * rng.normal(size=16)) - 1j * omega**0.3
    rows = [
        f"{w!r},{k.real!r},{k.imag!r}"
        for w, k in zip(omega.tolist(), stiffness.tolist(), strict=True)
    ]
    data = write("\n".join(["omega [rad/s],storage [kN/m],loss [kN/m]", *rows]) + "\n")
    asked = arguments.format(data=data, figure=tmp_path / "f.svg").split()
    answer = springpot(*asked, "--json").json
    error = answer.get("relative_rms") or answer["steps"][0]["relative_rms"]
    assert error == pytest.approx(1.0, rel=1e-3)
    assert answer.get("verdict", "unexplained") == "unexplained"
