"""Differences that matter."""

RELEVANT = 0.02
"""Share of a value from which on a difference matters."""
