"""The time at which a point was measured, by the names that instruments give it."""

from __future__ import annotations

import pytest

import springpot


@pytest.mark.parametrize(
    "title",
    ["Elapsed time", "Time elapsed", "Total time", "Gesamtzeit", "Test time", "Curing time"],
)
def test_the_time_of_a_test_is_its_time(tmp_path, title):
    rows = [f"{f}\t{100.0 + f}\t{20.0 + f}\t{60.0 * f}" for f in range(1, 9)]
    path = tmp_path / "export.txt"
    path.write_text(
        "\n".join([f"Frequency\tStorage modulus\tLoss modulus\t{title}", "Hz\tPa\tPa\ts", *rows])
    )
    assert springpot.read(path).conditions["time"].tolist() == [60.0 * f for f in range(1, 9)]
