"""Studies of autopilots keep their word: whatever their ranges allow, the autopilot holds."""

from itertools import product

import numpy as np
import pytest

from tests.tuner.conftest import QUICKSTART
from tuner.exchange.registry import exporters, settings_of
from tuner.exchange.target import Request
from tuner.gains import Controller
from tuner.study.build import load_study


@pytest.mark.parametrize(
    ("name", "target", "options"),
    [
        *(("autopilot_pid", target, ()) for target in ("px4", "ros2")),
        *(("autopilot_pid", "ardupilot", (f"firmware={version}",)) for version in ("4.6", "4.7")),
        ("crazyflie_firmware", "crazyflie", ("form=parameters",)),
    ],
)
def test_every_corner_of_the_ranges_can_be_exported(name, target, options):
    study = load_study(QUICKSTART.parent / f"{name}.toml")
    timing, exporter = study.system.timing, exporters()[target]
    corners = np.array(list(product((0.0, 1.0), repeat=len(study.space.variables))))
    for row in study.space.gains(corners):
        given = Controller(study.airframe, study.system.cascade, study.options, *timing, tuple(row.tolist()))
        assert exporter.export(Request(given, "0" * 64, settings_of(exporter, options))).parameters or target == "ros2"
