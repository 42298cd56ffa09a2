"""A flight log as a CSV table, with its mapping."""

import numpy as np

from tuner.extensions.logs.flight_log import FlightLog

COLUMNS = ("t", "p", "q", "r", "ax", "ay", "az", "m1", "m2", "m3", "m4")
MAPPING = """axes = "FLU"
time = { column = "t", unit = "s" }
gyro = { columns = ["p", "q", "r"], unit = "rad/s" }
acceleration = { columns = ["ax", "ay", "az"], unit = "m/s2" }
command = { columns = ["m1", "m2", "m3", "m4"], idle = 0.0, full = 1.0 }
"""
"""The mapping of these columns, as `tuner.extensions.logs.mapping` reads it."""
DIGITS = 9


def csv_table(log: FlightLog) -> str:
    """Return the table of a log: a row for each sample, to nine digits."""
    table = np.column_stack([log.time, log.gyro, log.acceleration, log.command])
    rows = [",".join(f"{value:.{DIGITS}g}" for value in row) for row in table.tolist()]
    return "\n".join([",".join(COLUMNS), *rows]) + "\n"
