"""Further strata of the hidden-effect test.

Their physics in time, their noise, and the figures made of answers.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
STUDIES = ROOT / "studies"
GENERATOR = ("drawn", "rig", "noise", "several", "wrong_base", "in_time", "time_domain", "__init__")
sys.path.insert(0, str(STUDIES))

import springpot  # noqa: E402
from hidden_effects.bases import BASES  # noqa: E402
from hidden_effects.effects import EFFECTS  # noqa: E402
from hidden_effects.strata import STRATA, draw, in_time  # noqa: E402
from hidden_effects.strata.figures import by_detail, recognised, strata_table  # noqa: E402
from hidden_effects.strata.wrong_base import material_loss  # noqa: E402

MOTION = in_time.Motion(np.geomspace(1.0, 100.0, 7), np.full(7, 0.5))
SOLID = in_time.Solid(10.0, 50.0, 0.1)
S = 1j * MOTION.omega
K = BASES["zener"].stiffness(S, np.array([10.0, 50.0, 5.0]))


def stiffness(force: np.ndarray, order: int = 1) -> np.ndarray:
    return in_time.harmonic(force, order) / MOTION.top


@pytest.mark.parametrize("name", GENERATOR)
def test_the_strata_know_nothing_of_the_framework(name):
    tree = ast.parse(
        (STUDIES / "hidden_effects" / "strata" / f"{name}.py").read_text(encoding="utf-8")
    )
    for node in ast.walk(tree):
        names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        assert not [each for each in names if each.startswith("springpot")]


# --- the integration in time against what is known in closed form ---------------------------------
def test_a_linear_solid_in_time_is_its_complex_stiffness():
    np.testing.assert_allclose(stiffness(in_time.solid_force(SOLID, MOTION)), K, rtol=1e-6)


@pytest.mark.soak
def test_a_load_cell_in_time_is_its_transfer_function():
    seen = stiffness(
        in_time.load_cell_force(in_time.solid_force(SOLID, MOTION), MOTION, 150.0, 0.05)
    )
    r = MOTION.omega / 150.0
    np.testing.assert_allclose(seen, K / (1.0 - r**2 + 0.1j * r), rtol=1e-4)


@pytest.mark.soak
def test_a_mount_and_a_slip_that_are_linear_add_their_compliance():
    mount = stiffness(in_time.mount_force(SOLID, MOTION, 200.0, 0.0))
    np.testing.assert_allclose(1.0 / mount, 1.0 / K + 1.0 / 200.0, rtol=1e-6)
    slip = stiffness(in_time.slip_force(SOLID, MOTION, 0.05, 1.0))
    np.testing.assert_allclose(1.0 / slip, 1.0 / K + 0.05 / S, rtol=1e-6)


@pytest.mark.soak
def test_a_hardening_mount_stiffens_and_makes_odd_harmonics_only():
    soft = in_time.mount_force(SOLID, MOTION, 200.0, 0.0)
    hard = in_time.mount_force(SOLID, MOTION, 200.0, 3000.0)
    assert np.all(stiffness(hard).real > stiffness(soft).real)
    assert np.all(np.abs(stiffness(hard, 3)) > 1e-6 * np.abs(K))
    assert np.all(np.abs(stiffness(hard, 2)) < 1e-6 * np.abs(K))
    assert np.all(np.abs(hard.mean(axis=0)) < 1e-6 * np.abs(hard).max(axis=0))


def test_friction_has_its_textbook_harmonics():
    """First harmonic 4 F / pi.

    Third a third of it, in phase with time from the top of the displacement.
    """
    creep = 1e-4 * MOTION.omega * MOTION.top
    force = in_time.instant_force(lambda x, v, a: 3.0 * np.tanh(v / creep), MOTION)
    np.testing.assert_allclose(stiffness(force), 4j * 3.0 / np.pi / MOTION.top, rtol=1e-3)
    np.testing.assert_allclose(
        in_time.harmonic(force, 3) / in_time.harmonic(force, 1), 1.0 / 3.0, rtol=1e-3
    )


@pytest.mark.soak
def test_one_slider_is_jenkins_and_a_sharp_bouc_wen_nearly_the_same():
    rho = 0.2 / 0.5
    beta = np.arccos(1.0 - 2.0 * rho)
    told = 7.0 / np.pi * (beta - 0.5 * np.sin(2.0 * beta)) + 28j / np.pi * rho * (1.0 - rho)
    slider = stiffness(in_time.sliders_force(7.0, np.array([0.2]), MOTION))
    np.testing.assert_allclose(slider, told, rtol=1e-4)
    np.testing.assert_allclose(
        stiffness(in_time.bouc_wen_force(7.0, 0.2, 30.0, 0.5, MOTION)), slider, rtol=2e-3
    )
    smooth = stiffness(in_time.bouc_wen_force(7.0, 0.2, 1.0, 0.5, MOTION))
    assert np.all(np.abs(smooth / slider - 1.0) > 0.05)


def test_any_material_follows_a_relaxation_and_not_a_mass():
    omega, sigma = np.geomspace(0.1, 100.0, 30), np.full(30, 0.01)
    k = 1.0 + (1j * omega) ** 0.4
    assert material_loss(omega, k, sigma) < 1e-3
    assert material_loss(omega, k - 1e-4 * omega**2, sigma) > 100.0


# --- what is drawn --------------------------------------------------------------------------------
@pytest.mark.soak_cases("three", "time", "wrong-base", "two")
@pytest.mark.parametrize("stratum", STRATA)
def test_a_case_is_the_same_each_time_and_another_for_another_seed(stratum, tmp_path):
    one, again, other = (
        draw(stratum, s).to_csv(tmp_path / f"{i}.csv") for i, s in enumerate((3, 3, 4))
    )
    assert one.read_bytes() == again.read_bytes() != other.read_bytes()


def test_a_notch_is_three_points_wide_and_as_deep_as_told():
    for seed in range(5):
        case = draw("notch", seed)
        place, depth = int(case.parameters["place"]), case.parameters["depth"]
        inner = np.abs(np.diff(np.log(np.abs(case.K_true))))[[place - 1, place]]
        assert 0.15 <= depth <= 0.35
        assert inner.max() > 0.3 * depth


@pytest.mark.parametrize(("seed", "larger"), [(0, "gain"), (1, "phase")])
def test_gain_and_phase_scatter_apart(seed, larger):
    errors = [draw("noise", seed + 12 * i) for i in range(10)]
    gain, phase = (
        np.concatenate([part(np.log(case.K / case.K_true)) / case.floor for case in errors])
        for part in (np.real, np.imag)
    )
    ratio = np.std(gain) / np.std(phase)
    assert (ratio if larger == "gain" else 1.0 / ratio) > 3.0
    assert np.mean(gain**2 + phase**2) == pytest.approx(1.0, rel=0.15)


def test_rounding_leaves_three_digits_and_is_in_the_floor(tmp_path):
    case = draw("rounding", 0)
    rows = case.to_csv(tmp_path / "case.csv").read_text(encoding="utf-8").splitlines()
    printed = np.array([[float(cell) for cell in row.split(",")[1:3]] for row in rows[1:]])
    seen = printed[:, 0] + 1j * printed[:, 1]
    np.testing.assert_array_equal(printed, [[float(f"{v:.2e}") for v in row] for row in printed])
    error = np.sqrt(np.mean(np.abs(seen / case.K_true - 1.0) ** 2))
    assert error == pytest.approx(case.floor, rel=0.25)


def test_replicates_differ_by_a_gain_and_a_drift_is_hidden_by_the_order_of_rows():
    case = draw("replicates", 0)
    gain, repeat = np.log(np.abs(case.K / case.K_true)), case.sweep.repeat
    means = np.array([gain[repeat == n].mean() for n in np.unique(repeat)])
    within = np.sqrt(2.0) * np.std(gain - means[repeat - 1])
    assert np.std(means) > within
    assert case.floor == pytest.approx(np.hypot(within, np.std(means)), rel=0.05)
    assert np.any(np.diff(draw("noise", 5).sweep.omega) < 0.0)
    assert np.any(np.diff(draw("noise", 5).sweep.omega) > 0.0)


@pytest.mark.soak
def test_names_that_count_as_right_are_those_of_effects():
    for stratum, seed in (
        ("time", 1),
        ("time", 3),
        ("time", 6),
        ("time", 7),
        ("noise", 6),
        ("rounding", 1),
    ):
        (name,) = draw(stratum, seed).right
        assert name in EFFECTS or name.endswith(("shift", "heating"))


def test_beside_a_wrong_base_stands_what_no_material_does():
    alone, rig = draw("wrong-base", 0), draw("wrong-base", 1)
    assert alone.material_chi2 < 1.0 < 60.0 < alone.chi2
    assert rig.material_chi2 >= 60.0
    assert set() < set(rig.material_right) <= set(rig.right)


# --- figures --------------------------------------------------------------------------------------
def row(
    stratum: str, seed: int, kind: str, verdict: str, floor: float = 1.0, **more: object
) -> dict[str, object]:
    candidates = [{"effect": "inertia", "class": ["inertia"], "probability": 0.99}]
    return {
        "design": stratum,
        "seed": seed,
        "kind": kind,
        "detail": "any",
        "truth": [],
        "chi2": 100.0,
        "floor": 0.01,
        "points": 30,
        "seconds": 1.0,
        "material_truth": [],
        "answer": {
            "verdict": verdict,
            "error": {"noise_floor": 0.01 * floor},
            "candidates": candidates,
        },
    } | more


def figures(rows):
    return {(f.design, f.name): f for f in strata_table(rows)}


@pytest.mark.soak
def test_what_is_the_matter_with_a_file_is_in_it(tmp_path):
    files = {}
    for seed in range(1, 8):
        case = draw("measured", seed)
        text = case.to_csv(tmp_path / "case.csv").read_text("utf-8")
        files[case.detail] = (case, text)
        assert bool(case.right) != bool(case.told)
    assert len(files) == 7
    wrong = files["sign"][0].columns
    assert np.corrcoef(wrong["displacement [mm]"], wrong["force [N]"])[0, 1] < -0.3
    loose = files["slack"][0]
    pulled = np.abs(loose.columns["force [N]"])
    before = loose.columns["displacement [mm]"] < loose.parameters["loose"]
    assert pulled[before].max() < 0.2 * pulled.max()
    assert ",n/a," in files["missing"][1]
    assert np.unique(files["calibration"][0].columns["plates"]).tolist() == [8.0, 25.0]
    assert np.all(np.diff(files["drift"][0].columns["time [s]"]) > 0.0)
    moved = files["confounded"][0].columns
    assert np.corrcoef(*np.log([moved["frequency [Hz]"], moved["amplitude [mm]"]]))[0, 1] < -0.99


@pytest.mark.parametrize(
    ("verdict", "named", "note", "known"),
    [
        ("effect-missing", "slack", "", True),
        ("effect-missing", "backlash", "the specimen is slack", False),
        ("unexplained", "slack", "", True),
        ("unexplained", "backlash", "the specimen is slack", True),
        ("unexplained", "backlash", "", False),
        ("adequate", "slack", "the specimen is slack", False),
    ],
)
def test_a_cause_is_told_by_its_name_or_in_words(verdict, named, note, known):
    found = {
        "verdict": verdict,
        "candidates": [{"effect": named, "class": [named]}],
        "notes": [note],
        "actions": [],
    }
    assert recognised({"answer": found, "truth": ["slack"], "told": ["is slack"]}) is known


def test_figures_count_verdicts_floors_and_seeds():
    rows = [
        row("notch", 0, "outside", "adequate", 3.0, verdicts=["adequate", "unexplained"]),
        row("notch", 1, "outside", "unexplained", 1.4, verdicts=["unexplained"] * 2),
        row("notch", 2, "outside", "effect-missing", 0.5),
    ]
    found = figures(rows)
    assert found["notch", "outside the library: called adequate"].value == pytest.approx(1 / 3)
    assert found["notch", "outside the library: called adequate"].met is False
    assert found["notch", "outside the library: confidently misnamed"].value == pytest.approx(1 / 3)
    assert found["notch", "noise floor within 1.5 x of the truth"].value == pytest.approx(1 / 3)
    assert found["notch", "same verdict for 2 seeds"].value == pytest.approx(0.5)
    assert ("notch", "nothing missing, yet flagged") not in found


def test_the_question_without_a_model_has_its_own_figures():
    wrong = row("wrong-base", 0, "base", "effect-missing", truth=["series-spring", "inertia"])
    named = wrong["answer"]
    alone = wrong | {
        "detail": "alone",
        "material_answer": named | {"verdict": "adequate"},
        "material_chi2": 0.0,
    }
    beside = wrong | {
        "material_truth": ["inertia"],
        "material_answer": named,
        "material_chi2": 200.0,
    }
    found = figures([alone, beside])
    assert found["wrong-base", "without a model: nothing missing, yet flagged"].value == 0.0
    assert found["wrong-base", "without a model: detected, chi2 >= 30"].n == 1
    assert found["wrong-base", "without a model: first by name, chi2 >= 120"].value == 1.0
    assert len(by_detail([alone, beside])) == 2 + 4


@pytest.mark.soak
@pytest.mark.slow
def test_strata_run_by_themselves_with_their_seeds(tmp_path, monkeypatch, capfd):
    import hidden_effect

    monkeypatch.setattr(hidden_effect, "warm_up", lambda: None)  # nobody looks at the times

    def study(*arguments):
        command = [
            "hidden_effect.py",
            "--out",
            str(tmp_path),
            "--workers",
            "1",
            "--seeds",
            "2",
            *arguments,
        ]
        monkeypatch.setattr(sys, "argv", command)
        hidden_effect.main()

    study("--strata", "rounding,history", "--cases", "1")
    assert "0 cases done, 2 to do" in capfd.readouterr().out
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "| same verdict for 2 seeds | rounding |" in text
    assert "| history | nothing, nothing | 1 |" in text
    with pytest.raises(SystemExit) as refused:
        study("--strata", "nonsense")
    assert refused.value.code == 2
    assert "no stratum nonsense; there are time, history" in capfd.readouterr().err


@pytest.mark.soak
def test_a_twin_that_ended_in_another_minimum_of_the_base_stands_beside_its_like(tmp_path):
    """A dashpot beside a stiff solid is a delay by its curve, wherever its own fit began."""
    case = draw("noise", 910050)
    assert case.right == ("parallel-dashpot",)
    case.to_csv(tmp_path / "case.csv")
    answer = springpot.diagnose(str(tmp_path / "case.csv"), case.model)
    assert {"parallel-dashpot", "time-delay"} <= set(answer.classes[0])


@pytest.mark.soak
def test_two_effects_stand_in_the_class_of_the_one_that_imitates_them(tmp_path):
    """A dashpot and friction are a damper of a power of the speed, where more is missing still."""
    case = draw("three", 990020)
    assert {"friction", "parallel-dashpot"} < set(case.right)
    case.to_csv(tmp_path / "case.csv")
    ladder = springpot.discover(str(tmp_path / "case.csv"), case.model)
    (step,) = ladder.steps[1:]
    assert step.accepted == "power-law-damper"
    assert "parallel-dashpot" in step.alike
