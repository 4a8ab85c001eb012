"""JSON holds finite numbers and JSON's own types only."""

import json
from pathlib import Path

import numpy as np

from springpot.report.text import to_json


def _refuse(constant):
    raise AssertionError(constant)


def test_every_number_is_finite_or_null():
    value = {
        "a": np.nan,
        "b": [np.inf, -np.inf, np.float64(2.5)],
        "c": np.array([1.0, np.nan]),
        4: np.int64(7),
    }
    assert json.loads(to_json(value), parse_constant=_refuse) == {
        "a": None,
        "b": [None, None, 2.5],
        "c": [1.0, None],
        "4": 7,
    }


def test_other_types():
    class Result:
        def to_dict(self):
            return {"x": 1 + 2j}

    value = {"r": Result(), "p": Path("a/b"), "t": (True, np.bool_(False), None), "α": "é"}
    text = to_json(value, indent=None)
    assert json.loads(text) == {
        "r": {"x": [1.0, 2.0]},
        "p": "a/b",
        "t": [True, False, None],
        "α": "é",
    }
    assert "\n" not in text
    assert "é" in text
