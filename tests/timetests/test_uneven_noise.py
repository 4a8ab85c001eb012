"""A record that is missed by no more than its noise lacks nothing, however uneven the noise is."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot import parse_model
from springpot.timetests import identify
from springpot.timetests.residuals_of_tests import parts_of_specimen
from springpot.timetests.scatter import scatter_of
from springpot.timetests.verdict import Left

DATA = (
    os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0]
    or Path(__file__).parents[3] / "shared" / "data"
)
UNSEEN = Path(DATA).parent / "unseen"


@pytest.mark.parametrize("seed", range(6))
def test_noise_that_is_larger_in_a_part_of_the_record_is_no_misfit(seed):
    rng = np.random.default_rng(seed)
    residual = rng.normal(size=160)
    residual[40:] *= 0.03
    found = scatter_of(residual)
    assert not found.misfit


def test_a_part_that_is_missed_beyond_the_noise_is_told():
    rng = np.random.default_rng(1)
    residual = rng.normal(size=400)
    residual[200:225] += 6.0 * np.hanning(25)
    assert scatter_of(residual).misfit


@pytest.mark.skipif(not UNSEEN.is_dir(), reason="the unseen files are not here")
@pytest.mark.parametrize(
    "spec", ["C0224_NVT_450K_1atm.gt", "stressrelaxation_pp_data.csv?time=s,relaxation=Pa"]
)
def test_at_the_noise_nothing_is_missing_from_a_real_relaxation(spec):
    [test] = springpot.open_in_time(f"{UNSEEN}/{spec}")
    fit = identify(test, parse_model("material"))
    assert not Left.by(fit.model, fit.theta, fit.reference, parts_of_specimen([test])).misfit
