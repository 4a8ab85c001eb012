"""One view of a fit, as wide as a journal's column, with labelled axes."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.errors import OutputError

LABELS = {
    "storage-loss": ("frequency f [Hz]", "storage, loss modulus [Pa]"),
    "loss-factor": ("frequency f [Hz]", "loss factor"),
    "cole-cole": ("storage modulus [Pa]", "loss modulus [Pa]"),
}


@pytest.fixture(scope="module")
def fitted() -> springpot.Identification:
    omega = np.geomspace(1.0, 100.0, 12)
    return springpot.identify(springpot.Measurement(omega, 100.0 + 2j * omega), "kelvin")


@pytest.mark.parametrize("view", LABELS)
def test_a_view_is_84_mm_wide_and_its_axes_have_units(fitted, view):
    pytest.importorskip("matplotlib")
    figure = fitted.plot(view=view)
    assert figure.get_figwidth() * 25.4 == pytest.approx(84.0)
    [axes] = figure.axes
    assert axes.get_xlabel() == LABELS[view][0]
    assert axes.get_ylabel().startswith(LABELS[view][1])
    told = axes.get_legend()
    # Storage over loss has no storage and loss of its own.
    assert (told is not None) == (view == "storage-loss")


@pytest.mark.soak
def test_a_view_is_drawn_where_one_says(fitted, tmp_path, springpot):
    plots = pytest.importorskip("matplotlib.figure")
    axes = plots.Figure().subplots()
    assert fitted.plot(ax=axes, view="black") is axes
    assert axes.lines
    for wrong in ({"view": "red"}, {"view": "black", "ax": axes, "path": tmp_path / "a.pdf"}):
        with pytest.raises(OutputError):
            fitted.plot(**wrong)
    path = tmp_path / "view.pdf"
    words = ["artificial-hidden", "-m", "kelvin", "--figure", path, "--view", "van-gurp-palmen"]
    springpot("identify", *words)
    springpot("identify", *words[:3], *words[5:]).is_one_line("give --figure FILE too")
    # 84 mm are 238 points.
    assert b"/MediaBox [ 0 0 238.1" in path.read_bytes()
