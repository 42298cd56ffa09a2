"""Files of other frames than quadrotors are refused with the frame's name, on the way in and as --previous; quadrotors are read."""

import pytest

from plant.errors import InputError
from tests.tuner.exchange.controllers import pid
from tests.tuner.exchange.reading import read, write
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.ardupilot.export import TARGET as ARDUPILOT
from tuner.extensions.px4.export import TARGET as PX4

OTHERS = [
    ("ardupilot", {"FRAME_CLASS": 2, "FRAME_TYPE": 1}, "FRAME_CLASS.*given 2, a hexacopter"),
    ("ardupilot", {"FRAME_CLASS": 3}, "FRAME_CLASS.*given 3, an octocopter"),
    ("ardupilot", {"FRAME_CLASS": 4}, "octoquad"),
    ("ardupilot", {"FRAME_CLASS": 5}, "Y6"),
    ("ardupilot", {"FRAME_CLASS": 7}, "tricopter"),
    ("ardupilot", {"FRAME_CLASS": 12}, "dodecahexacopter"),
    ("ardupilot", {"FRAME_CLASS": 14}, "decacopter"),
    ("ardupilot", {"FRAME_CLASS": 15}, "32 motors"),
    ("px4", {"CA_AIRFRAME": 0, "CA_ROTOR_COUNT": 6, "SYS_AUTOSTART": 6001}, "CA_ROTOR_COUNT.*given 6, a hexacopter"),
    ("px4", {"CA_ROTOR_COUNT": 8, "SYS_AUTOSTART": 4001}, "CA_ROTOR_COUNT.*given 8, an octocopter"),
    ("px4", {"SYS_AUTOSTART": 6002}, "SYS_AUTOSTART.*hexacopter"),
    ("px4", {"SYS_AUTOSTART": 7001, "CA_ROTOR_COUNT": 0}, "hexacopter"),
    ("px4", {"SYS_AUTOSTART": 8001}, "octocopter"),
    ("px4", {"SYS_AUTOSTART": 12001}, "coaxial octocopter"),
    ("px4", {"SYS_AUTOSTART": 4001, "MAV_TYPE": 13}, "MAV_TYPE.*hexacopter"),
    ("px4", {"CA_AIRFRAME": 2, "CA_ROTOR_COUNT": 4}, "CA_AIRFRAME.*VTOL"),
    ("px4", {"SYS_AUTOSTART": 13000}, "VTOL"),
]
QUADS = [
    ("ardupilot", {"FRAME_CLASS": 1, "FRAME_TYPE": 1}),
    ("ardupilot", {"FRAME_CLASS": 0}),
    ("ardupilot", {}),
    ("px4", {"SYS_AUTOSTART": 4001, "CA_ROTOR_COUNT": 4, "CA_AIRFRAME": 0, "MAV_TYPE": 2}),
    ("px4", {"SYS_AUTOSTART": 4014, "CA_ROTOR_COUNT": 0}),
    ("px4", {"SYS_AUTOSTART": 6001, "CA_ROTOR_COUNT": 4}),
    ("px4", {"SYS_AUTOSTART": 1100}),
    ("px4", {}),
]
GAINS = {"ardupilot": {"ATC_RAT_RLL_P": 0.12, "ATC_ANG_RLL_P": 4.5}, "px4": {"MC_ROLLRATE_P": 0.12}}


def text_of(target: str, values: dict[str, float]) -> str:
    rows = {**values, **GAINS[target]}
    if target == "px4":
        return "".join(f"1\t1\t{name}\t{value}\t{9 if name in GAINS[target] else 6}\n" for name, value in rows.items())
    return "".join(f"{name},{value}\n" for name, value in rows.items())


def settings(target: str) -> tuple[str, ...]:
    return ("firmware=4.6",) if target == "ardupilot" else ()


@pytest.mark.parametrize(("target", "values", "words"), OTHERS)
def test_another_frame_is_refused_by_its_name(target, values, words, tmp_path):
    file = write(tmp_path, text_of(target, values))
    with pytest.raises(InputError, match=words):
        read(target, file, *settings(target), airframe="f450")
    exporter = PX4 if target == "px4" else ARDUPILOT
    with pytest.raises(InputError, match=words):
        exporter.export(Request(pid("f450"), "ab" * 32, settings_of(exporter, settings(target)), file))


@pytest.mark.parametrize(("target", "values"), QUADS)
def test_a_quadrotor_and_a_file_without_a_frame_are_read(target, values, tmp_path):
    read(target, write(tmp_path, text_of(target, values)), *settings(target), airframe="f450")
