"""Exact lengths of the two non-SI units in which the turbulence specifications are written."""

FOOT = 0.3048  # m
KNOT = 1852.0 / 3600.0  # m/s
