"""Laws tell of themselves: nothing outside plant/laws has to know one by its name, but exporters of what their target has."""

import ast
import re

from plant.law_registry import LAWS
from tests.sources import sources, walk


def named_in(package: str) -> set[str]:
    """Files of a package with the name of a law as a text of its own."""
    return {
        name
        for name, text in sources(package, pattern="|".join(map(re.escape, LAWS)))
        if any(isinstance(node, ast.Constant) and node.value in LAWS for node in walk(ast.parse(text)))
    }


def test_proofs_and_designs_ask_laws_for_what_they_are() -> None:
    assert not named_in("objectives")


def test_of_the_rooms_of_the_user_only_targets_defaults_and_the_yardstick_name_laws() -> None:
    rooms = {tuple(name.split("/")[1:3]) for name in named_in("tuner")}
    # The law that a study has where it names none, and the pair that `tuner bench` flies.
    # Targets of extensions have names of laws; extension.py lists them.
    assert {room[0] for room in rooms} <= {"study", "cli", "api", "extensions", "extension.py"}
    assert {room[1] for room in rooms if room[0] == "extensions"} <= {
        "ardupilot",
        "autopilots",
        "autotune",
        "bench",
        "betaflight",
        "betaflight_adrc",
        # A certificate of the super-twisting algorithm is called after it, as the law is.
        "certificates",
        "crazyflie",
        # Rules are printed for laws, and a written study names one.
        "design_rules",
        "flight_plans",
        "judge",
        "plant_fit",
        "px4",
        "ros2",
        "textbook_laws",
    }
