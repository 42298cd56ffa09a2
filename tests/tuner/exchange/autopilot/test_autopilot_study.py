"""studies/autopilot_pid.toml keeps its word: whatever its ranges allow, PX4 and ArduPilot hold."""

from itertools import product

import numpy as np
import pytest

from tests.tuner.conftest import QUICKSTART
from tuner.exchange.registry import EXPORTERS, settings_of
from tuner.exchange.target import Request
from tuner.gains import Controller
from tuner.study import load_study


@pytest.mark.parametrize(
    ("target", "options"),
    [("px4", ()), ("ardupilot", ("firmware=4.6",)), ("ardupilot", ("firmware=4.7",)), ("ros2", ())],
)
def test_every_corner_of_the_ranges_can_be_exported(target, options):
    study = load_study(QUICKSTART.parent / "autopilot_pid.toml")
    timing, exporter = study.system.timing, EXPORTERS[target]
    corners = np.array(list(product((0.0, 1.0), repeat=len(study.space.variables))))
    for row in study.space.gains(corners):
        given = Controller(study.airframe, study.system.cascade, study.options, *timing, tuple(row.tolist()))
        assert exporter.export(Request(given, "0" * 64, settings_of(exporter, options))).parameters or target == "ros2"
