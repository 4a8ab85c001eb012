"""Hidden-effect cases for tests in time.

What is drawn, how it is computed, how answers are counted.
"""
