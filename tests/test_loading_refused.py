"""Files that hold no answer are refused in one line, whatever stands in them."""

import pytest

import springpot
from springpot.errors import SpringpotError


@pytest.mark.parametrize(
    "text", ["{}", "[]", "3", '{"schema": []}', '{"schema": {}}', '{"schema": "none/1"}']
)
def test_what_is_no_answer_is_refused_in_one_line(tmp_path, text):
    path = tmp_path / "answer.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SpringpotError, match=r"answer\.json") as refused:
        springpot.load(path)
    assert "\n" not in str(refused.value)
