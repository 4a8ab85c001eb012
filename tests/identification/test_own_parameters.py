"""Specimens that share some parameters and have others for themselves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.errors import DataError, ModelError, OptionError
from springpot.loading import load

STIFFNESS = {1.0: 100.0, 2.0: 112.0, 3.0: 93.0}
OMEGA = 2.0 * np.pi * np.geomspace(0.5, 50.0, 14)
NOISE = 0.004


def batches(rng: np.random.Generator, noise: float = NOISE) -> springpot.Measurement:
    """Three batches that differ in stiffness and share a dashpot."""
    omega, batch = np.tile(OMEGA, 3), np.repeat(list(STIFFNESS), len(OMEGA))
    exact = np.array([STIFFNESS[each] for each in batch]) + 0.4j * omega
    draws = rng.standard_normal((2, len(omega)))
    return springpot.Measurement(
        omega, exact * (1.0 + noise * (draws[0] + 1j * draws[1])), conditions={"batch": batch}
    )


def files(rng: np.random.Generator) -> list[springpot.Measurement]:
    """The same as a sweep each."""
    whole = batches(rng)
    rows = whole.conditions["batch"]
    return [
        springpot.Measurement(whole.omega[rows == i], whole.stiffness[rows == i], name=f"s{i:.0f}")
        for i in STIFFNESS
    ]


def test_each_batch_has_its_stiffness_and_all_share_the_dashpot(rng: np.random.Generator) -> None:
    fit = springpot.identify(batches(rng), "kelvin", own={"k": "batch"})
    for i, k in STIFFNESS.items():
        assert fit[f"k_{i:.0f}"].low < k < fit[f"k_{i:.0f}"].high
    assert fit["c"].value == pytest.approx(0.4, rel=0.01)
    assert fit.dof == 2 * 3 * len(OMEGA) - 4


def test_the_floor_is_that_of_a_material_for_each_batch(rng: np.random.Generator) -> None:
    fit = springpot.identify(batches(rng), "kelvin", own={"k": "batch"})
    assert fit.standing is not None
    assert fit.standing.good_enough
    assert fit.standing.material_floor <= fit.relative_rms


def test_files_are_numbered_and_are_no_repeats_of_one_another(rng: np.random.Generator) -> None:
    fit = springpot.identify(files(rng), "kelvin", own={"k": "file"})
    assert "file: 1 is s1, 2 is s2, 3 is s3" in fit.notes
    assert fit.standing is not None
    assert fit.standing.noise_source == "estimated"
    assert fit.standing.noise_floor < 2.0 * NOISE


def test_the_answer_opens_again_with_its_levels(rng: np.random.Generator, tmp_path: Path) -> None:
    import json

    fit = springpot.identify(batches(rng), "kelvin", own={"k": "batch"}, bounds={"c": (0.0, 9.0)})
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    again = load(path)
    assert isinstance(again, springpot.Identification)
    assert again.model.names == fit.model.names
    asked = {"omega": [3.0], "batch": 2.0}
    assert again.predict(**asked).storage.tolist() == fit.predict(**asked).storage.tolist()


@pytest.mark.soak
def test_what_is_missing_from_all_batches_is_found_beside_their_own(
    rng: np.random.Generator,
) -> None:
    data = batches(rng)
    heavy = springpot.Measurement(
        data.omega, data.stiffness - 4e-4 * data.omega**2, conditions=data.conditions
    )
    found = springpot.diagnose(heavy, "kelvin", own={"k": "batch"})
    assert found.best is not None
    assert found.best.effect == "inertia"


def test_a_start_is_named_for_all_levels(rng: np.random.Generator) -> None:
    data = batches(rng)
    free = springpot.identify(data, "kelvin", own={"k": "batch"})
    for start in ({"k": 3.0}, {"k": 3.0, "c": 0.1}):
        begun = springpot.identify(data, "kelvin", own={"k": "batch"}, start=start)
        assert begun.theta == pytest.approx(free.theta, rel=1e-6)
    with pytest.raises(ModelError, match="no free parameter 'k_9'"):
        springpot.identify(data, "kelvin", own={"k": "batch"}, start={"k_9": 3.0})


def test_what_cannot_be_a_levels_own_is_told(rng: np.random.Generator) -> None:
    data = batches(rng)
    with pytest.raises(DataError, match="has no column 'day' \\(there are: batch\\)"):
        springpot.identify(data, "kelvin", own={"k": "day"})
    with pytest.raises(DataError, match="is one file: name several, or the column"):
        springpot.identify(data, "kelvin", own={"k": "file"})
    with pytest.raises(ModelError, match="k9"):
        springpot.identify(data, "kelvin", own={"k9": "file"})
    one = data.subset(data.conditions["batch"] == 1.0)
    with pytest.raises(DataError, match="one level of batch: nothing is its own"):
        springpot.identify(one, "kelvin", own={"k": "batch"})
    relaxation = springpot.TimeTest.of_relaxation([0.1, 1.0, 10.0], [3.0, 2.0, 1.0])
    with pytest.raises(DataError, match="relaxation has no batch"):
        springpot.identify(relaxation, "maxwell", own={"k": "batch"})
    with pytest.raises(ModelError, match="not in a free spectrum"):
        springpot.identify(data, "material", own={"*": "batch"})
    with pytest.raises(OptionError, match="own is a dictionary by parameter"):
        springpot.identify(data, "kelvin", own="k")  # type: ignore[arg-type]
