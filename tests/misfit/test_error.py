"""An error over its floor, and where the noise is hard to believe."""

import pytest

from springpot.misfit.error import Error
from springpot.thresholds import SCATTER


@pytest.mark.parametrize("source", ["given", "estimated", "repeats"])
@pytest.mark.parametrize("memory", [None, 0.3])
def test_as_in_the_schemas_and_back(source, memory):
    error = Error(0.06, 0.02, source, "a doubt", 0.03, 0.4, memory)
    row = error.to_dict()
    assert row["over_floor"] == pytest.approx(3.0)
    assert ("noise_memory" in row) is (memory is not None)
    assert Error.from_dict(row) == error


@pytest.mark.parametrize("share", [0.99, 1.0, 1.01])
def test_repeats_are_judged_by_the_floor_and_scatter_by_the_error(share):
    beyond = share > 1.0
    assert Error(0.0, share * SCATTER.repeats_alike, "repeats").is_hardly_noise is beyond
    assert Error(share * SCATTER.believed, 0.0, "estimated").is_hardly_noise is beyond
    assert not Error(9.0, share * SCATTER.believed, "given").is_hardly_noise


def test_advice_names_the_size():
    assert "differ by 31 %" in Error(0.5, 0.31, "repeats").advice
    assert "noise of 31 %" in Error(0.5, 0.31, "estimated").advice
