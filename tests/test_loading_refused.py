"""Files that hold no answer are refused in one line, whatever stands in them."""

import json
from math import inf

import pytest

import springpot
from springpot.errors import SpringpotError
from springpot.files import json_of
from springpot.identification import Value
from springpot.plain_data import jsonable


@pytest.mark.parametrize(
    "text", ["{}", "[]", "3", '{"schema": []}', '{"schema": {}}', '{"schema": "none/1"}']
)
def test_what_is_no_answer_is_refused_in_one_line(tmp_path, text):
    path = tmp_path / "answer.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SpringpotError, match=r"answer\.json") as refused:
        springpot.load(path)
    assert "\n" not in str(refused.value)


def test_no_answer_tells_a_number_that_is_refused_where_it_is_read():
    told = Value(1.0, -1e160, 1e160, "s").to_dict()
    again = json_of(json.dumps(jsonable(told)), finite=True)
    assert Value.from_dict(again) == Value(1.0, -inf, inf, "s")


def test_a_word_is_no_parameter_of_a_kept_fit(tmp_path):
    """Python takes "1e400" for a number, which is infinite."""
    fit = springpot.identify("artificial-springpot", "springpot").to_dict()
    path = tmp_path / "fit.json"
    told = jsonable(fit)
    told["kept"]["theta"][0] = "1e400"
    path.write_text(json.dumps(told), encoding="utf-8")
    with pytest.raises(SpringpotError, match="holds a word where a number belongs"):
        springpot.load(path)
