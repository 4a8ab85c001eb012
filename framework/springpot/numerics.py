"""What is as good as nothing in floating point, and how far a search goes at most.

One level for each reason, for the whole house.  Shares are relative to the largest of what is
added, compared or measured.
"""

from __future__ import annotations

from math import log

ROUNDING = 1e-12
"""Share that sums and products of doubles leave: some thousand times their last digit, 2e-16."""
ALIKE = 1e-9
"""Two results of a solved system or a search within this share of each other are one.

Half the digits of a double are lost where a condition of 1e7 stands between data and result.
"""
NEGLIGIBLE = 1e-6
"""Share that no instrument shows and no printed digit: a thousandth of the best one's noise."""
PRINTED = 1e-4
"""Relative error below the four digits that are printed of an uncertain number."""
SMALLEST = 1e-300
"""Stands for nothing where one divides by it or takes its logarithm; its inverse is a number."""

DIFFERENCE = 1e-6
"""Relative step of a central difference: what is cut off and what is rounded are both 1e-10."""

MOST_STEPS = 60
"""Of a search that ends by itself, mostly in five to thirty: after these it found nothing."""
HALVINGS = 100
"""Of an interval with a root: beyond them only rounding is left of any."""

DECADE = log(10.0)
"""In a natural logarithm."""
NORMAL = 1.482602218505602
"""Standard deviation of a normal distribution over the median of its absolute values."""
MEDIAN_WORTH, FOURTH_WORTH = 0.37, 0.38
"""Share of the numbers that a median of absolute values uses, and that fourth differences do.

Their variances are 1/0.37 and 1/0.38 of the best one's: neighbouring differences share samples.
"""
TWO_DEVIATIONS = 4.0
"""Drop of chi-square, or twice that of a log-likelihood, by one number that is two of its standard
deviations: a chance of 5 %.
"""
