"""Waypoints: the curve through them against closed forms and what it must minimise, and mistakes in the file."""

from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from plant.references import build
from plant.references.spec import ACCELERATION, POSITION, VELOCITY, YAW, YAW_RATE
from plant.references.waypoints import Waypoints

DT = 0.002
POINTS = np.array(
    [[0.0, 1.0, 0.0, 0.0, 0.0], [2.0, 1.0, 0.5, 0.2, 40.0], [3.5, 2.0, -1.0, 0.0, 370.0], [6.0, 0.0, 0.0, 1.0, -30.0]]
)


def written(folder: Path, text: str) -> str:
    """Return the path of a waypoint file with this text."""
    path = folder / "route.csv"
    path.write_text(text)
    return str(path)


def as_text(points: np.ndarray) -> str:
    """Return the file of these points."""
    rows = "\n".join(",".join(map(repr, row)) for row in points.tolist())
    return f"t,x,y,z,yaw_deg\n{rows}\n"


def flown(folder: Path, points: np.ndarray, seconds: float) -> np.ndarray:
    """Return the samples of a flight through points, up to and including `seconds`."""
    return build(Waypoints(path=written(folder, as_text(points))), DT, round(seconds / DT) + 1).samples


def jerk_of(positions: np.ndarray) -> np.ndarray:
    """Return third derivatives per column, midway between samples, from third differences."""
    return np.diff(positions, n=3, axis=0) / DT**3


def test_two_points_are_the_minimum_jerk_movement(tmp_path: Path) -> None:
    """Oracle: 10 s^3 - 15 s^4 + 6 s^5 (Flash & Hogan 1985), and rest after the last point."""
    samples = flown(tmp_path, np.array([[0.0, 0.0, 1.0, 0.0, 0.0], [4.0, 2.0, 0.0, 0.0, 90.0]]), 6.0)
    s = np.minimum(np.arange(len(samples)) * DT / 4.0, 1.0)
    share = 10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5
    np.testing.assert_allclose(samples[:, 0], 2.0 * share, atol=1e-12)
    np.testing.assert_allclose(samples[:, 1], 1.0 - share, atol=1e-12)
    np.testing.assert_allclose(samples[:, YAW], np.pi / 2.0 * share, atol=1e-12)
    acceleration = 2.0 * (60.0 * s - 180.0 * s**2 + 120.0 * s**3) / 16.0
    np.testing.assert_allclose(samples[:, 6], acceleration, atol=1e-11)


def test_passes_through_every_point_and_rests_at_both_ends(tmp_path: Path) -> None:
    """Points are met to rounding; yaw is not wrapped (370 degrees is a turn and 10 degrees)."""
    samples = flown(tmp_path, POINTS, 8.0)
    at = np.round(POINTS[:, 0] / DT).astype(int)
    np.testing.assert_allclose(samples[at, POSITION], POINTS[:, 1:4], atol=1e-12)
    np.testing.assert_allclose(np.degrees(samples[at, YAW]), POINTS[:, 4], atol=1e-10)
    for k in (0, at[-1]):
        np.testing.assert_allclose(samples[k, VELOCITY], 0.0, atol=1e-11)
        np.testing.assert_allclose(samples[k, ACCELERATION], 0.0, atol=1e-10)
    after = samples[at[-1] + 1 :]
    np.testing.assert_allclose(after[:, POSITION], np.tile(POINTS[-1, 1:4], (len(after), 1)), atol=1e-12)
    assert not np.any(after[:, VELOCITY])
    assert not np.any(after[:, YAW_RATE])


def test_no_other_curve_through_the_points_has_less_jerk(tmp_path: Path) -> None:
    """The integrated squared jerk is least: the curve's jerk is orthogonal to that of every bump that is allowed.

    Allowed are bumps that vanish at all points and, with two derivatives, at both ends. The third differences leave out
    1.5 steps at either end, so the inner product may miss 3 dt max|jerk| max|bump's jerk|: below 2 % of the two norms,
    where a clamped cubic spline, for example, reaches 9 %.
    """
    positions = flown(tmp_path, POINTS, 6.0)[:, POSITION]
    t = np.arange(len(positions)) * DT
    own = jerk_of(positions)
    for power in (3, 4):
        bump = jerk_of((t * (6.0 - t)) ** power * (t - 2.0) * (t - 3.5))
        missed = 3.0 * DT * np.max(np.abs(own), axis=0) * np.max(np.abs(bump))
        norms = DT * np.sqrt(np.sum(own**2, axis=0) * np.sum(bump**2))
        assert np.all(missed < 0.02 * norms)
        assert np.all(np.abs(DT * bump @ own) <= missed)


def test_a_flight_may_end_before_the_route(tmp_path: Path) -> None:
    """A shorter flight sees the beginning."""
    np.testing.assert_array_equal(flown(tmp_path, POINTS, 1.0), flown(tmp_path, POINTS, 8.0)[:501])


def test_levels_are_those_of_the_first_point(tmp_path: Path) -> None:
    """The route may begin away from the origin, which is where the vehicle then starts."""
    track = build(Waypoints(path=written(tmp_path, as_text(POINTS))), DT, 10)
    np.testing.assert_allclose(track.start, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-15)


def test_a_file_without_yaw_with_blanks_and_a_byte_order_mark(tmp_path: Path) -> None:
    """What spreadsheets write is read."""
    path = tmp_path / "route.csv"
    path.write_bytes(b"\xef\xbb\xbft, x, y, z\r\n0, 0, 0, 0\r\n\r\n,,,\r\n2, 1, 2, 3\r\n")
    spec = Waypoints(path=str(path))
    assert spec.points == ((0.0, 0.0, 0.0, 0.0, 0.0), (2.0, 1.0, 2.0, 3.0, 0.0))


MISTAKES = {
    "empty": ("", None, "is empty; the header must be"),
    "no header": ("0,0,0,0\n1,1,1,1\n", "line 1", "unknown column '0'"),
    "misspelt column": ("t,x,y,z,yaw\n0,0,0,0,0\n", "line 1", "did you mean 'yaw_deg'"),
    "columns in another order": ("t,y,x,z\n0,0,0,0\n1,1,1,1\n", "line 1", "the header is t,y,x,z"),
    "missing column": ("t,x,y\n0,0,0\n1,1,1\n", "line 1", "the header is t,x,y;"),
    "short row": ("t,x,y,z\n0,0,0,0\n1,1,1\n", "line 3", "has 3 columns, the header has 4"),
    "long row": ("t,x,y,z\n0,0,0,0\n\n1,1,1,1,1\n", "line 4", "has 5 columns"),
    "text": ("t,x,y,z\n0,0,0,0\n1,a,1,1\n", "line 3", "x is 'a'; it must be a finite number"),
    "missing cell": ("t,x,y,z\n0,0,0,0\n1,1,,1\n", "line 3", "y is ''"),
    "nan": ("t,x,y,z\n0,0,0,nan\n1,1,1,1\n", "line 2", "z is 'nan'"),
    "late start": ("t,x,y,z\n0.5,0,0,0\n1,1,1,1\n", "line 2", "the first t is 0.5 s"),
    "time stands still": ("t,x,y,z\n0,0,0,0\n1,1,1,1\n1,2,2,2\n", "line 4", "t is 1 s, not after the 1 s before it"),
    "one point": ("t,x,y,z\n0,0,0,0\n", None, "has 1 waypoints; give at least two"),
    "no point": ("t,x,y,z\n", None, "has 0 waypoints"),
    "open quote": ('t,x,y,z\n0,0,0,"0\n', None, "is not a CSV file"),
}


@pytest.mark.parametrize(("text", "line", "says"), MISTAKES.values(), ids=MISTAKES.keys())
def test_mistakes_name_file_and_line(tmp_path: Path, text: str, line: str | None, says: str) -> None:
    """Each mistake is an input error at its line of the file."""
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        Waypoints(path=path)
    assert caught.value.file == path
    assert caught.value.key == line
    assert says in caught.value.message


def test_unknown_columns_are_unknown_names(tmp_path: Path) -> None:
    """A misspelt column is the same kind of error as a misspelt key."""
    with pytest.raises(UnknownNameError):
        Waypoints(path=written(tmp_path, "time,x,y,z\n0,0,0,0\n"))


def test_a_missing_file_and_a_folder(tmp_path: Path) -> None:
    """Neither can be read."""
    for path, words in ((tmp_path / "none.csv", "no such file"), (tmp_path, "cannot be read")):
        with pytest.raises(InputError, match=words):
            Waypoints(path=str(path))


def test_a_device_without_an_end_is_no_file_of_waypoints():
    with pytest.raises(InputError, match="no regular file"):
        Waypoints(path="/dev/zero")
