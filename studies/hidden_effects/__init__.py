"""An independent generator of measurements with hidden physical effects.

With it come the figures of the hidden-effect test.
Nothing in this package imports springpot: the formulas are typed a second time, on purpose, as
plain complex functions, so that an error in the framework cannot hide itself in its own test.
"""
