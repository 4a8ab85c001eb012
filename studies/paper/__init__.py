"""What the studies of the paper share.

Its printed numbers, reading a study's results, the look of its figures.
"""
