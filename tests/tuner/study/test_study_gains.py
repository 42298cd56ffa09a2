"""The [gains] table: which gains a variable moves, over which range, and what stands where no variable does."""

from math import sqrt
from pathlib import Path

import numpy as np
import pytest

from plant.quadrotor.gains import gain_addresses
from tests.tuner.study.study_text import STUDY, changed, with_gains, write
from tuner.study.build import load_study
from tuner.study.study import Study

LAMBDA = '"tilt.lambda" = { low = 1, high = 16 }'


def loaded(folder: Path, lines: str) -> Study:
    return load_study(write(folder, with_gains(lines)))


def row(study: Study, point: list[float]) -> dict[str, float]:
    """Return the gains at a point of the unit cube by address."""
    values = study.space.gains(np.array([point]))[0]
    return {gain.address: float(values[gain.column]) for gain in gain_addresses(study.system.cascade)}


def defaults(study: Study) -> dict[str, float]:
    return {gain.address: gain.default for gain in gain_addresses(study.system.cascade)}


def test_a_group_moves_its_axes_together_and_nothing_else(tmp_path: Path):
    study = loaded(tmp_path, LAMBDA)
    moved = row(study, [0.5])
    usual = defaults(study)
    assert {address for address in moved if moved[address] != usual[address]} == {"roll.lambda", "pitch.lambda"}


# The middle of a log range is the geometric mean of its ends, that of a linear one the arithmetic mean.
@pytest.mark.parametrize(
    ("line", "middle"),
    [
        ("{ low = 1, high = 16 }", 4.0),
        ('{ low = 1, high = 16, scale = "log" }', 4.0),
        ('{ low = 1, high = 16, scale = "linear" }', 8.5),
        ("{ low = 2, high = 18 }", 6.0),
    ],
)
def test_a_scale_decides_the_middle(line: str, middle: float, tmp_path: Path):
    study = loaded(tmp_path, f'"yaw.lambda" = {line}')
    assert row(study, [0.5])["yaw.lambda"] == pytest.approx(middle, rel=1e-14)
    low, high = study.space.variables[0].low, study.space.variables[0].high
    assert row(study, [0.0])["yaw.lambda"] == pytest.approx(low, rel=1e-14)
    assert row(study, [1.0])["yaw.lambda"] == pytest.approx(high, rel=1e-14)


def test_an_empty_table_searches_the_usual_range_of_the_loop(tmp_path: Path):
    # The numbers are those of the hybrid law's k1 (0 to 40, linear) and of LADRC's bandwidth in the position loop.
    study = loaded(tmp_path, '"roll.k1" = {}\n"x.omega_c" = {}')
    roll, x = study.space.variables
    assert (roll.low, roll.high, roll.scale) == (0.0, 40.0, "linear")
    assert (x.low, x.high, x.scale) == (0.3, 6.0, "log")
    middle = row(study, [0.5, 0.5])
    assert middle["roll.k1"] == 20.0
    assert middle["x.omega_c"] == pytest.approx(sqrt(0.3 * 6.0), rel=1e-14)


def test_one_end_of_a_range_leaves_the_other_as_usual(tmp_path: Path):
    variable = loaded(tmp_path, '"roll.k1" = { high = 30 }').space.variables[0]
    assert (variable.low, variable.high) == (0.0, 30.0)


@pytest.mark.parametrize("lines", [f'{LAMBDA}\n"roll.lambda" = 3.0', f'"roll.lambda" = 3.0\n{LAMBDA}'])
def test_an_axis_overrides_its_group_wherever_it_stands(lines: str, tmp_path: Path):
    study = loaded(tmp_path, lines)
    assert study.space.variables[0].addresses == ("pitch.lambda",)
    assert row(study, [1.0])["roll.lambda"] == 3.0
    assert row(study, [1.0])["pitch.lambda"] == pytest.approx(16.0)


def test_three_widths_override_each_other(tmp_path: Path):
    study = loaded(tmp_path, '"attitude.k2" = 7.0\n"tilt.k2" = 8.0\n"roll.k2" = { low = 1, high = 4 }')
    assert study.space.variables[0].addresses == ("roll.k2",)
    base = row(study, [0.5])
    assert (base["roll.k2"], base["pitch.k2"], base["yaw.k2"]) == (pytest.approx(2.0), 8.0, 7.0)


@pytest.mark.parametrize("target", ["tilt.lambda", "roll.lambda", "pitch.lambda"])
def test_a_tie_follows_a_key_or_an_address(target: str, tmp_path: Path):
    study = loaded(tmp_path, f'{LAMBDA}\n"yaw.lambda" = {{ tie = "{target}" }}')
    assert len(study.space.variables) == 1
    moved = row(study, [0.25])
    assert moved["yaw.lambda"] == moved["roll.lambda"] == moved["pitch.lambda"] == pytest.approx(2.0)


def test_a_tie_follows_a_tie(tmp_path: Path):
    lines = '"yaw.k2" = { tie = "pitch.k2" }\n"pitch.k2" = { tie = "roll.k2" }\n"roll.k2" = { low = 1, high = 9 }'
    moved = row(loaded(tmp_path, lines), [0.5])
    assert moved["yaw.k2"] == moved["pitch.k2"] == moved["roll.k2"] == pytest.approx(3.0)


def test_a_tied_gain_must_allow_the_range_too(tmp_path: Path):
    # k1 may be 0, lambda may not.
    with pytest.raises(Exception, match="given 0 s\\^-1 for roll.lambda .*must be above 0"):
        loaded(tmp_path, '"roll.k1" = { low = 0, high = 9 }\n"roll.lambda" = { tie = "roll.k1" }')


def test_the_order_of_variables_is_that_of_the_file(tmp_path: Path):
    study = loaded(tmp_path, '"z.zeta" = {}\n"roll.k1" = {}\n"horizontal.omega_o" = {}')
    assert [variable.name for variable in study.space.variables] == ["z.zeta", "roll.k1", "horizontal.omega_o"]


def test_the_default_row_holds_fixed_gains_and_the_usual_rest(tmp_path: Path):
    study = loaded(tmp_path, f'{LAMBDA}\n"yaw.k1" = 3.5')
    expected = defaults(study) | {"yaw.k1": 3.5}
    values = study.default_row
    assert {g.address: float(values[g.column]) for g in gain_addresses(study.system.cascade)} == expected


def test_without_searched_gains_a_study_loads_and_has_no_variables(tmp_path: Path):
    assert loaded(tmp_path, "").space.variables == ()
    assert loaded(tmp_path, '"roll.k1" = 3').space.variables == ()


def test_the_gains_of_another_law_are_known_by_their_names(tmp_path: Path):
    text = changed('attitude = "hybrid"', 'attitude = "pid"\nposition = "pid"', with_gains('"attitude.t_f" = {}'))
    study = load_study(write(tmp_path, text))
    assert study.space.variables[0].addresses == ("roll.t_f", "pitch.t_f", "yaw.t_f")


def test_points_and_gains_are_inverse_inside_the_range(tmp_path: Path):
    study = loaded(tmp_path, f'{LAMBDA}\n"yaw.k1" = {{ low = 5, high = 6 }}\n"x.zeta" = {{}}')
    points = np.random.default_rng(3).uniform(size=(20, 3))
    for point, gains in zip(points, study.space.gains(points), strict=True):
        np.testing.assert_allclose(study.space.point(gains), point, rtol=0, atol=1e-12)


def test_the_study_text_searches_one_group(tmp_path: Path):
    study = load_study(write(tmp_path, STUDY))
    assert [variable.name for variable in study.space.variables] == ["tilt.lambda"]
