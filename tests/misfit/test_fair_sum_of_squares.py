"""What the lines of a free spectrum follow of the noise is put back, by hand."""

from types import SimpleNamespace

import pytest

from springpot.misfit.refit import Refit


@pytest.mark.parametrize(
    ("source", "lines", "wanted", "of_half"),
    [
        # No lines follow nothing.
        ("given", 0, 6.0, 3.0),
        ("estimated", 0, 6.0, 3.0),
        # Of a known noise each takes one from chi-square, however little something leaves of it.
        ("given", 4, 10.0, 7.0),
        ("repeats", 1, 7.0, 4.0),
        # Of an estimated one ten of 2 * 6 - 2 data were left to the noise, and six still are.
        ("estimated", 4, 10.0, 5.0),
        ("estimated", 9, 60.0, 30.0),
        # As many lines as data leave none.
        ("estimated", 10, 60.0, 30.0),
    ],
)
def test_each_source_of_the_noise(source, lines, wanted, of_half):
    fit = SimpleNamespace(
        lines=lines,
        own=[0, 1],
        noise=SimpleNamespace(source=source),
        fit=SimpleNamespace(measurement=range(6)),
    )
    assert Refit.fair(fit, 6.0) == pytest.approx(wanted)
    assert Refit.fair(fit, 3.0) == pytest.approx(of_half)
