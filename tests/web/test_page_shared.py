"""Parameters that specimens have for themselves, and ties, typed on the page."""

from __future__ import annotations

import numpy as np
import pytest
from browsing import IN_A_BROWSER, Open

pytestmark = IN_A_BROWSER


@pytest.mark.soak
def test_own_and_tied_parameters_are_typed_refused_and_left_with(page: Open):
    rng, omega = np.random.default_rng(1), np.geomspace(1.0, 300.0, 12)
    files = {}
    for lot, stiff in (("lot-1.csv", 100.0), ("lot-2.csv", 120.0)):
        exact = stiff + 2.0 * stiff * 0.01j * omega / (1.0 + 0.01j * omega)
        seen = exact * (1.0 + 0.005 * rng.standard_normal((12, 2)) @ [1.0, 1.0j])
        pairs = zip(omega / 2.0 / np.pi, seen, strict=True)
        rows = [f"{f:.6g},{k.real:.6g},{k.imag:.6g}\n" for f, k in pairs]
        head = "frequency [Hz],storage [kN/m],loss [kN/m]\n"
        files[lot] = "".join([head, *rows]).encode()
    here = page()
    here.name("zener")
    here.drop("lot-1.csv", files.pop("lot-1.csv"), **files)
    here.shows("zener")
    here.page.click("#shared summary")
    here.page.fill("#given", "--own k1,c --tie 'k2 = 2*k1'")
    here.page.click("#judge")
    here.page.locator(".parameter .name:has-text('k1_2')").wait_for()
    names = here.page.locator(".parameter .name").all_inner_texts()
    assert names == ["k1_1", "k1_2", "c_1", "c_2"]
    # Each file is a specimen, drawn in a colour of its own with a curve of its own.
    assert "● file lot-2" in here.reads(".legend").replace("\n", " ")
    assert here.page.locator("#plot-view .line.model.storage").count() == 2
    here.page.click("#leave")
    here.page.locator("dialog[open]:has-text('--own k1,c')").wait_for()
    here.page.keyboard.press("Escape")
    here.page.fill("#given", "--own q")
    here.page.click("#judge")
    here.page.locator("#refused:has-text('no free parameter')").wait_for()
    # What was refused stands where it can be mended.
    assert here.page.input_value("#given") == "--own q"
    assert here.violations() == []
