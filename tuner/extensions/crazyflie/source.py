"""Parameter files of the Crazyflie as a source."""

import re

from tuner.extensions.autopilots.sources import EVERY, PERIOD, Source, fixed_options
from tuner.extensions.crazyflie.facts import crazyflie_facts
from tuner.extensions.crazyflie.text import read

SOURCE = Source(
    re.compile(r"type:\s*persistent_param_state\s*"),
    re.compile(r"\s+(\w+\.\w+):\s*(?:\{.*)?"),
    read,
    lambda _: None,
    fixed_options("crazyflie", PERIOD, EVERY),
    re.compile(r"pid_rate\.(roll|pitch|yaw)_k[pid]"),
    facts=crazyflie_facts,
)
