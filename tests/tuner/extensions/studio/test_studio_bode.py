"""Bode curves of the page against python-control: plant sampled with its input held, the law as difference equations."""

import re
from base64 import b64decode
from typing import Any

import control
import numpy as np
import pytest

from tests.tuner.extensions.studio.conftest import STUDIES
from tuner.extensions.studio.answering import Bench, answer
from tuner.extensions.studio.messages import read_request
from tuner.extensions.studio.session import open_session

# Laplace variable.
S: Any = control.tf("s")


def motor():
    """Angle over voltage of the motor example of CTMS, behind an amplifier of 1 ms."""
    inertia, friction, constant, resistance = 3.2284e-6, 3.5077e-6, 0.0274, 4.0
    return constant / (S * (inertia * resistance * S + friction * resistance + constant**2)) / (0.001 * S + 1.0)


LOOPS = {
    # Study -> plant, control period, periods of delay, gains kp, ki, kd and t_f.
    "dc_motor": (motor(), 0.001, 1, (9.0, 14.0, 0.15, 0.001)),
    "heater": (1.8 / (120.0 * S**2 + 23.0 * S + 1.0), 0.25, 8, (2.0, 0.08, 6.0, 0.5)),
    "dead_time": (1.0 / (S + 1.0), 0.03125, 32, (0.5, 0.4, 0.0, 0.05)),
}


def sampled_loop(plant, period, delay, gains):
    """The loop as python-control closes it: the plant over a period, whole periods of delay, and PID or PI."""
    kp, ki, kd, t_f = gains
    z: Any = control.tf([1.0, 0.0], [1.0], period)
    pole = np.exp(-period / t_f)
    law = kp + ki * period / (z - 1.0)
    if kd:
        law = law + kd * (1.0 - pole) * (z - 1.0) / (period * (z - pole))
    late: Any = control.tf([1.0], [1.0, *[0.0] * delay], period)
    return control.sample_system(plant, period, method="zoh") * law * late


def drawn(made, key):
    """Frequencies and values of the line of the setting at hand."""
    trace = next(
        trace
        for trace in made["charts"][key]["traces"]
        if trace["meta"].get("layer") == "here" and trace["mode"] == "lines" and len(numbers(made, trace["x"])) > 2
    )
    return numbers(made, trace["x"]), numbers(made, trace["y"])


def numbers(made, name):
    return np.frombuffer(b64decode(made["arrays"][name[1:]]), "<f4").astype(float)


def opened(name, folder, is_pi):
    """The study; as PI with its derivative gain fixed at 0, since its range begins above."""
    text = (STUDIES / f"{name}.toml").read_text()
    if is_pi:
        text, count = re.subn(r'(\w+\.kd" = )\{.*?\}', r"\g<1>0.0", text)
        assert count == 1
    (folder / "study.toml").write_text(text.replace(f'"{name}.py"', f'"{STUDIES / name}.py"'))
    return open_session(folder / "study.toml")


@pytest.mark.parametrize("name", LOOPS)
def test_gain_and_phase_are_those_of_python_control(name, tmp_path):
    plant, period, delay, gains = LOOPS[name]
    session = opened(name, tmp_path, is_pi=not gains[2])
    bench = Bench.of(session, 2)
    (channel,) = bench.loops.channels
    given = {f"{channel}.{gain}": value for gain, value in zip(("kp", "ki", "kd"), gains, strict=False) if value}
    made = answer(bench, read_request(session, [channel], {"number": 1, "values": given}), 16)
    w, gain = drawn(made, "loop-gain")
    _, phase = drawn(made, "loop-phase")
    expected = sampled_loop(plant, period, delay, gains)(np.exp(1j * w * period))
    assert len(w) == 300
    assert gain == pytest.approx(20.0 * np.log10(np.abs(expected)), rel=1e-6, abs=1e-6)
    # The page counts turns from the last crossover, python-control from the first frequency.
    unwrapped = np.degrees(np.unwrap(np.angle(expected)))
    turns = 360.0 * np.round((phase[0] - unwrapped[0]) / 360.0)
    assert phase == pytest.approx(unwrapped + turns, rel=1e-6, abs=1e-6)
