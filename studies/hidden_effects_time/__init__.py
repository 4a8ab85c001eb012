"""Hidden-effect cases for tests in time: what is drawn, how it is computed, how answers are counted."""
