"""Firmwares that fly finalists, by name."""

from plant.errors import check_name
from tuner.engines.firmware.ardupilot.bench import ARDUPILOT
from tuner.engines.firmware.betaflight.bench import BETAFLIGHT
from tuner.engines.firmware.crazyflie.bench import CRAZYFLIE
from tuner.engines.firmware.firmware import Firmware
from tuner.engines.firmware.px4.bench import PX4_FIRMWARE

FIRMWARES: dict[str, Firmware] = {entry.name: entry for entry in (ARDUPILOT, BETAFLIGHT, CRAZYFLIE, PX4_FIRMWARE)}


def firmware_of(name: str) -> Firmware:
    """Return a firmware; UnknownNameError where there is none of that name."""
    check_name("firmware", name, FIRMWARES, key="--firmware")
    return FIRMWARES[name]
