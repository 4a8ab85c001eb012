"""What the studies of the paper share: its printed numbers, reading a study's results, the look of its figures."""
