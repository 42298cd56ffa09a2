"""Reads a table of waypoints: CSV with the header t,x,y,z or t,x,y,z,yaw_deg, in s, m and degrees."""

import csv
from io import StringIO
from math import isfinite
from pathlib import Path

from plant.errors import InputError, check_name
from plant.input_files import given_text

COLUMNS = ("t", "x", "y", "z", "yaw_deg")
_FORM = "the header must be t,x,y,z or t,x,y,z,yaw_deg"

Point = tuple[float, ...]


def read_waypoints(path: Path) -> tuple[Point, ...]:
    """Return points (t [s], x, y, z [m], yaw [deg]), at least two, t increasing from 0; yaw is 0 where not given.

    Raises InputError naming the file, and the line where there is one.
    """
    rows = _rows(path)
    if not rows:
        raise InputError(f"is empty; {_FORM}", file=path)
    _check_header(rows[0][1], path)
    width = len(rows[0][1])
    points = [_point(number, cells, width, path) for number, cells in rows[1:]]
    _check_times([(number, point[0]) for (number, _), point in zip(rows[1:], points, strict=True)], path)
    return tuple(points)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    try:
        reader = csv.reader(StringIO(given_text(path, "give a CSV file of waypoints"), newline=""), strict=True)
        return [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(map(str.strip, row))]
    except csv.Error as error:
        raise InputError(f"is not a CSV file: {error}", file=path) from error


def _check_header(header: list[str], path: Path) -> None:
    for name in header:
        check_name("column", name, COLUMNS, file=path, key="line 1")
    if tuple(header) not in (COLUMNS, COLUMNS[:-1]):
        raise InputError(f"the header is {','.join(header)}; {_FORM}", file=path, key="line 1")


def _point(number: int, cells: list[str], width: int, path: Path) -> Point:
    if len(cells) != width:
        raise InputError(f"has {len(cells)} columns, the header has {width}", file=path, key=f"line {number}")
    values = [_number(cell, name, number, path) for name, cell in zip(COLUMNS, cells, strict=False)]
    return tuple(values) if width == len(COLUMNS) else (*values, 0.0)


def _number(cell: str, column: str, number: int, path: Path) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise InputError(f"{column} is '{cell}'; it must be a finite number", file=path, key=f"line {number}")
    return value


def _check_times(times: list[tuple[int, float]], path: Path) -> None:
    if len(times) < 2:
        raise InputError(f"has {len(times)} waypoints; give at least two", file=path)
    number, first = times[0]
    if first != 0.0:
        message = f"the first t is {first:g} s; it must be 0, where the flight starts"
        raise InputError(message, file=path, key=f"line {number}")
    for (_, before), (number, after) in zip(times, times[1:], strict=False):
        if after <= before:
            raise InputError(f"t is {after:g} s, not after the {before:g} s before it", file=path, key=f"line {number}")
