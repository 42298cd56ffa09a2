"""Advice of refused exports: each option and target that a message prints is tried."""

import re
from dataclasses import replace

import pytest

from plant.errors import InputError
from tests.tuner.exchange.controllers import controller, pid
from tests.tuner.exchange.test_export_contract import request_of
from tuner.exchange.advice import bundle_or_advise
from tuner.exchange.registry import exporter, settings_of
from tuner.exchange.run import bundle_of, check_laws
from tuner.exchange.target import ExportTarget

pytestmark = pytest.mark.usefixtures("few_golden_vectors", "uncompiled")


def powerful(given, factor):
    """Return a controller on a vehicle whose rotors lift more."""
    vehicle = given.airframe.vehicle
    stronger = vehicle._replace(thrust_coefficient=factor * vehicle.thrust_coefficient)
    return replace(given, airframe=replace(given.airframe, vehicle=stronger))


PX4 = {"position": "px4_position", "attitude": "px4", "airframe": "f450", "period": 0.002, "every": 4}
REFUSED = {
    "px4, hover command too low, and local helps": ("px4", powerful(controller(**PX4, z__p=5.0), 4.0), "--set thrust_model=local"),
    "px4, hover command too low, and code is left": ("px4", powerful(controller(**PX4), 4.0), "--to c99"),
    "ardupilot, angle loop too fast": ("ardupilot", pid(period=0.002, roll__kp=900, pitch__kp=900), "--to c99"),
    "betaflight, two angle loops": ("betaflight", pid(period=0.002, roll__kd=0.001), "--to c99"),
    "crazyflie, another form": ("crazyflie", pid(period=0.002, roll__kd=0.001), "--set form=controller"),
}  # fmt: skip


def follow(text, given):
    """Export by the first advice of a message."""
    if match := re.search(r"--set (\w+=\w+) exports these gains", text):
        return lambda target: bundle_of(
            target, replace(request_of(target, given), settings=settings_of(target, match.groups()))
        )
    (name,) = re.findall(r"--to (\w+) exports these gains", text)
    return lambda _: bundle_of(exporter(name), request_of(exporter(name), given))


@pytest.mark.parametrize(("name", "given", "advice"), REFUSED.values(), ids=REFUSED)
def test_the_advice_of_a_refusal_exports_the_gains(name, given, advice):
    target = exporter(name)
    with pytest.raises(InputError) as plain:
        bundle_of(target, request_of(target, given))
    with pytest.raises(InputError) as refusal:
        bundle_or_advise(target, request_of(target, given), bundle_of)
    text = str(refusal.value)
    assert text.startswith(str(plain.value)) and advice in text
    assert follow(text, given)(target).files


def test_each_target_that_a_refused_law_is_sent_to_takes_it():
    given = controller("ladrc", "hybrid", period=0.002)
    with pytest.raises(InputError) as refusal:
        check_laws(exporter("px4"), request_of(exporter("px4"), given))
    names = re.search(r"--to ((?:\w+)(?: or \w+)*), or tune", str(refusal.value))
    assert names is not None
    for name in names[1].split(" or "):
        check_laws(exporter(name), request_of(exporter(name), given))


def test_a_wrong_file_of_the_vehicle_is_named_without_advice():
    def refuse(*_):
        raise InputError("holds no parameter", file="old.params")

    target: ExportTarget = exporter("px4")
    with pytest.raises(InputError) as refusal:
        bundle_or_advise(target, request_of(target, pid(period=0.002)), refuse)
    assert str(refusal.value) == "old.params: holds no parameter"


def test_gains_that_nothing_takes_keep_their_message():
    def refuse(*_):
        raise InputError("given nan", key="roll.kp")

    with pytest.raises(InputError) as refusal:
        bundle_or_advise(exporter("px4"), request_of(exporter("px4"), pid(period=0.002)), refuse)
    assert str(refusal.value) == "roll.kp: given nan"
