"""Relaxations of one material at several temperatures: all at once is as one by one."""

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.registry import parse_model, plugins
from springpot.timetests import fitting, identify
from springpot.timetests.material import spectral, with_rates
from springpot.timetests.temperatures import StackedResiduals, is_material_alone

REFERENCE = 293.15
RATES = np.geomspace(1e-3, 1e3, 7)


def creeps():
    rng = np.random.default_rng(2)
    t = np.concatenate([[0.0], np.geomspace(0.01, 10.0, 12)])
    strain = 0.05 + 0.1 * (1.0 - np.exp(-t)) + 0.01 * t
    return [
        TimeTest.of_compliance(
            t, strain * np.exp(0.01 * rng.normal(size=13)), "kPa", temperature=celsius, name=f"{i}"
        )
        for i, celsius in enumerate((10.0, 20.0, 40.0))
    ]


def relaxations(kind="kPa"):
    rng = np.random.default_rng(1)
    t = np.concatenate([[0.0], np.geomspace(0.01, 10.0, 12)])
    stress = 5.0 + 20.0 * np.exp(-t)
    return [
        TimeTest.of_relaxation(
            t, stress * np.exp(0.01 * rng.normal(size=13)), kind, temperature=celsius, name=f"{i}"
        )
        for i, celsius in enumerate((10.0, 20.0, 40.0))
    ]


@pytest.mark.parametrize("tests", [relaxations, creeps])
@pytest.mark.parametrize("laws", ["", " + wlf-shift", " + arrhenius-shift + vertical-shift"])
def test_all_at_once_is_as_one_by_one(laws, tests):
    parts = parts_of_specimen(tests())
    parts[1] = parts[1].with_scale(3.0)
    model = with_rates(parse_model("material" + laws), RATES.tolist())
    theta = np.concatenate([[4.0, 0.0 if tests is relaxations else 2.0], np.linspace(1.0, 3.0, 7)])
    theta = np.append(theta, np.linspace(0.5, 2.0, len(model.names) - 9) * 30.0)
    together = StackedResiduals(model, parts, REFERENCE)
    assert (len(together.steps), together.others) == (1, [])
    value, by_theta = together.residuals(theta)
    apart = [part.residual(model, theta, REFERENCE) for part in parts]
    np.testing.assert_allclose(value, np.concatenate([each.value for each in apart]), atol=1e-9)
    np.testing.assert_allclose(
        by_theta, np.concatenate([each.by_theta for each in apart]), rtol=1e-9, atol=1e-9
    )


def test_what_one_test_alone_has_is_worked_out_for_it_alone():
    tests = relaxations()
    parts = parts_of_specimen(tests)
    model = with_rates(parse_model("material + wlf-shift + force-drift"), RATES.tolist())
    assert not any(is_material_alone(model, part) for part in parts)
    together = StackedResiduals(model, parts, REFERENCE)
    assert (together.steps, len(together.others)) == ([], 3)


def test_a_test_at_one_temperature_is_missed_alone_as_by_any_material():
    tests = relaxations()
    fit = identify(tests, parse_model("material") + plugins().effect("wlf-shift"))
    for test, row in zip(tests, fit.tests, strict=True):
        alone = identify(test, parse_model("material")).tests[0]
        # Together they know their noise, alone each tells its own.
        missed = row.over_floor_alone * row.noise_floor
        assert missed == pytest.approx(alone.over_floor_alone * alone.noise_floor, rel=0.05)


@pytest.mark.soak
def test_what_any_material_follows_to_its_noise_is_not_searched_once_more(monkeypatch):
    searched = []
    monkeypatch.setattr(fitting, "spectral", lambda *a: searched.append(a[1]) or spectral(*a))
    tests = relaxations()
    fit = identify(tests, parse_model("material + wlf-shift + force-drift"))
    assert [len(parts) for parts in searched] == [3]
    assert all(row.over_floor_alone < 1.5 for row in fit.tests)
