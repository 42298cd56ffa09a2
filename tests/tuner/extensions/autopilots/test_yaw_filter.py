"""The low-pass on yaw torque: carried where the target has it, named where it has not, and back again from a vehicle's file."""

from dataclasses import replace

import pytest

from tests.tuner.exchange.controllers import pid
from tests.tuner.exchange.reading import read, write
from tuner.exchange.registry import exporter, settings_of
from tuner.exchange.run import bundle_of
from tuner.exchange.target import Request


def bundle(target, cutoff, *given):
    own = pid("iris", z__kp=5.2, z__ki=0.4, z__kd=4.0)
    own = replace(own, options=replace(own.options, yaw_torque_cutoff=cutoff))
    entry = exporter(target)
    return bundle_of(entry, Request(own, "d" * 64, settings_of(entry, list(given)), None))


@pytest.mark.parametrize(("target", "name"), [("px4", "MC_YAW_TQ_CUTOFF"), ("ardupilot", "ATC_RAT_YAW_FLTE")])
@pytest.mark.parametrize("cutoff", [0.0, 0.25, 2.0])
def test_autopilots_with_a_low_pass_carry_ours_and_bring_it_back(target, name, cutoff, tmp_path):
    version = ("firmware=4.6",) if target == "ardupilot" else ()
    made = bundle(target, cutoff, *version)
    (parameter,) = [entry for entry in made.parameters if entry.name == name]
    assert parameter.held == pytest.approx(cutoff, rel=1e-7)
    assert made.held.options.yaw_torque_cutoff == pytest.approx(cutoff, rel=1e-7)
    assert not any("low-pass on yaw torque" in text for text in made.differences)
    (content,) = made.files.values()
    found = read(target, write(tmp_path, content.decode(), "vehicle.params"), *version, airframe="iris")
    assert found.controller.options.yaw_torque_cutoff == pytest.approx(cutoff, rel=1e-6)


@pytest.mark.parametrize("target", ["betaflight", "ros2"])
def test_others_say_that_they_lack_it_and_are_verified_without(target):
    made = bundle(target, 0.25)
    assert any("low-pass on yaw torque at 0.25 Hz has no counterpart" in text for text in made.differences)
    assert made.held.options.yaw_torque_cutoff == 0.0
    assert not any("low-pass on yaw torque" in text for text in bundle(target, 0.0).differences)
