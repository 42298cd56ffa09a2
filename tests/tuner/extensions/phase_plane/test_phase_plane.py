"""Phase planes of motions with closed forms."""

from typing import Any

import numpy as np
import pytest

import tuner
from plant.errors import InputError
from tuner.analysis.responses import Responses
from tuner.extensions.phase_plane.api import phase_plane
from tuner.extensions.phase_plane.figure import phase_sheet
from tuner.extensions.phase_plane.trajectories import trajectories
from tuner.report.charts.chart import Line

T = np.linspace(0.0, 4.0, 400)


def responses(actual, reference):
    """Responses of one signal, and of a command that follows nothing."""
    nothing = np.full_like(actual, np.nan)
    return Responses(
        T, np.stack([actual, actual], axis=-1), np.stack([reference, nothing], axis=-1), ("angle", "u"), ("rad", "V")
    )


class Flown:
    """Flights of which only the responses count."""

    scenario = "swing"

    def __init__(self, recorded):
        self.recorded = recorded


def test_an_oscillation_is_an_ellipse_and_a_command_has_no_plane():
    w, phases = 3.0, np.array([[0.0], [1.0]])
    (found,) = trajectories(responses(np.cos(w * T + phases), np.zeros((2, len(T)))))
    inner = slice(1, -1)
    assert (found.error**2 + (found.rate / w) ** 2)[:, inner] == pytest.approx(1.0, abs=1e-3)
    assert found.signal == "angle"


def test_a_damped_motion_spirals_inwards_by_its_decrement():
    d, w = 0.4, 5.0
    motion = np.exp(-d * T) * np.array([np.cos(w * T)])
    (found,) = trajectories(responses(motion, np.zeros((1, len(T)))))
    turn = int(round(2.0 * np.pi / w / (T[1] - T[0])))
    radius = np.hypot(found.error, (found.rate + d * found.error) / w)[0]
    assert radius[turn + 5] / radius[5] == pytest.approx(np.exp(-d * turn * (T[1] - T[0])), rel=3e-3)


def test_a_jump_of_the_reference_breaks_the_line():
    reference = np.where(T >= 1.0, 1.0, 0.0)[None]
    (found,) = trajectories(responses(np.where(T >= 1.0, 1.0 - np.exp(-(T - 1.0)), 0.0)[None], reference))
    at = int(np.argmax(T >= 1.0))
    assert np.isnan(found.rate[0, at - 1 : at + 1]).all() and np.isfinite(found.rate[0, at + 1 :]).all()
    later = slice(at + 2, -1)
    assert found.rate[0, later] == pytest.approx(-found.error[0, later], rel=1e-3)


def test_the_figure_has_a_panel_with_units_and_a_file(tmp_path):
    flights: Any = Flown(responses(np.array([np.cos(T)] * 3), np.zeros((3, len(T)))))
    (panel,) = phase_sheet(trajectories(flights.recorded), "swing").panels
    assert panel.title == "angle" and panel.x.title.endswith("[°]") and panel.y.title.endswith("[°/s]")
    lines = [mark for mark in panel.marks if isinstance(mark, Line)]
    assert (
        len(lines) == 3 and lines[-1].name == "first flight" and np.nanmax(lines[-1].x) == pytest.approx(57.3, abs=0.1)
    )
    phase_plane(flights, tmp_path / "phase.png")
    assert (tmp_path / "phase.png").stat().st_size > 0
    with pytest.raises(InputError, match="allowed endings: .png, .pdf, .svg"):
        phase_plane(flights, tmp_path / "phase.txt")
    assert "phase_plane" in tuner.__all__


def test_the_command_draws_the_loops_of_gains_and_names_them(small_run, tmp_path, tuner):
    folder, picture = small_run[1], tmp_path / "phase.svg"
    done = tuner("phase-plane", folder / "gains.json", "--seeds", 2, "--plot", picture)
    assert done.stdout.startswith("Phase planes of x, y, z, roll, pitch and yaw, two flights of scenario ")
    assert picture.read_text(encoding="utf-8").startswith("<?xml")
