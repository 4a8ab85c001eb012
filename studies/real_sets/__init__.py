"""Measured sets of `real_data.py`: what they are, what the tool answers, what is published."""
