"""A model with one more effect, of the material or of tests in time."""

import pytest

from springpot.errors import ModelError
from springpot.measurement import grown
from springpot.measurement.timed import Timed
from springpot.registry import parse_model, plugins


def test_an_effect_is_added_to_what_it_acts_on():
    library = plugins()
    inertia, drift = library.effect("inertia"), library.find("time effect", "force-drift")
    kelvin = parse_model("kelvin")
    assert grown(kelvin, inertia).name == "kelvin + inertia"
    both = grown(grown(kelvin, drift), inertia)
    assert isinstance(both, Timed)
    assert both.material.name == "kelvin + inertia"
    assert [each.name for each in both.time_effects] == ["force-drift"]


def test_an_effect_of_tests_in_time_is_taken_once():
    drift = plugins().find("time effect", "force-drift")
    once = grown(parse_model("kelvin"), drift)
    with pytest.raises(ModelError, match="already"):
        grown(once, drift)
