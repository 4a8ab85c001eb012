"""Readers of tests in time: tables in many layouts, RepTate's files."""
