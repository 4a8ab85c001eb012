"""What a trial is called depends on what it is made of, never on what ran before in the process."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from springpot.benchmark import Study

STUDY = {
    "datasets": ["artificial-fractional-zener", "artificial-springpot"],
    "models": ["own", "fractional-maxwell"],
    "objectives": ["paper", "relative"],
    "optimisers": ["pso-paper", "native", "cma-es"],
    "repetitions": 2,
    "budget": 300,
}


def digests(study):
    return [cell.digest for cell in study.plan().cells]


@pytest.fixture(scope="module")
def fresh():
    """Of the same study in a process that has done nothing else."""
    code = (
        "import json, sys; from springpot.benchmark import Study; "
        "cells = Study('race', **json.loads(sys.argv[1])).plan().cells; "
        "print(json.dumps([cell.digest for cell in cells]))"
    )
    said = subprocess.run(
        [sys.executable, "-c", code, json.dumps(STUDY)], capture_output=True, text=True, check=True
    )
    return json.loads(said.stdout)


@pytest.mark.soak
def test_a_digest_knows_nothing_of_what_ran_before(fresh):
    """Fits, a diagnosis, other studies and what libraries keep for the whole process."""

    import springpot

    springpot.compare("artificial-fractional-zener", ["fractional-maxwell", "fractional-zener"])
    springpot.identify("artificial-springpot", "springpot", optimiser="cma-es", budget=50)
    digests(Study("before", **{**STUDY, "optimisers": ["nlopt-crs"]}))
    np.random.seed(5)  # noqa: NPY002
    assert digests(Study("race", **STUDY)) == fresh


@pytest.mark.soak
def test_a_digest_knows_nothing_of_order_and_name(fresh):
    turned = {
        key: value[::-1] if isinstance(value, list) else value for key, value in STUDY.items()
    }
    assert sorted(digests(Study("another", **turned))) == sorted(fresh)
    assert len(set(fresh)) == len(fresh)


def test_a_digest_knows_what_matters():
    known = digests(Study("race", **STUDY))
    assert not set(digests(Study("race", **{**STUDY, "budget": 301}))) & set(known)
    # Raising them runs the new ones only.
    assert digests(Study("race", **{**STUDY, "repetitions": 9})) == known


COMPUTED = {
    "poynting-thomson": "f3b4fa1da744d9e6",
    "record-jenkins": "b3fc0df1b0aaa822",
    "record-play": "2d2f1fccd3a5a10b",
}
"""First digits of the digests of data that end in other bits where exponentials are rounded
otherwise; the archive of the main study has been made with them."""


@pytest.mark.soak
def test_data_of_another_processor_have_the_digests_that_were_published():
    """Without fused multiplication, which the C library of Linux can be told to leave."""
    code = (
        "import json, sys, springpot; "
        "suite = springpot.plugins().find('suite', 'springpot-60'); "
        "tests = {name: suite.problem(f'springpot-60/{name}').tests() for name in sys.argv[1:]}; "
        "print(json.dumps({name: each[0].digest()[:16] for name, each in tests.items()}))"
    )
    surroundings = {**os.environ, "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"}
    said = subprocess.run(
        [sys.executable, "-c", code, *COMPUTED],
        capture_output=True, text=True, check=True, env=surroundings,
    )  # fmt: skip
    assert json.loads(said.stdout) == COMPUTED
