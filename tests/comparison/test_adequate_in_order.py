"""No model is adequate at an error at which a simpler one is not.

Few numbers left to judge by are no merit.
"""

from types import SimpleNamespace

from springpot.comparison.comparing import _no_worse_than_rejected


def judged(parameters, error):
    ranked = SimpleNamespace(theta=[0.0] * parameters, floor=0.1, least_error=0.0, relative_rms=1.0)
    return SimpleNamespace(
        ranked=ranked, error=SimpleNamespace(relative_rms=error, noise_floor=0.1)
    )


def test_a_richer_model_farther_from_the_data_is_no_more_adequate():
    simple, rejected, rich = judged(3, 0.11), judged(4, 0.12), judged(6, 0.15)
    assert _no_worse_than_rejected([simple, rich], [simple, rejected, rich]) == [simple]


def test_one_that_is_nearer_stays():
    rejected, rich = judged(3, 0.15), judged(6, 0.11)
    assert _no_worse_than_rejected([rich], [rejected, rich]) == [rich]


def test_a_richer_one_that_is_rejected_says_nothing_of_a_simpler_one():
    simple, rejected = judged(3, 0.15), judged(6, 0.11)
    assert _no_worse_than_rejected([simple], [simple, rejected]) == [simple]


def test_of_two_alike_the_rejected_one_decides():
    adequate, rejected = judged(3, 0.15), judged(3, 0.15)
    # Two models, however alike.
    rejected.name = "other"
    assert _no_worse_than_rejected([adequate], [adequate, rejected]) == []
