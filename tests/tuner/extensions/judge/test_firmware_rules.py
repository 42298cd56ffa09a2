"""Contract of the rules of firmwares: a source by name, a refusal in the worse direction alone, margins at the last crossover."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.analysis.margins.curves import Curves
from tuner.extensions.judge import firmware_rules as rules_module
from tuner.extensions.judge.firmware_rules import RULES, firmware_rules, margin_at_phase

FREQUENCIES = np.linspace(0.05, 10.0, 2000)
TOOLS = {"betaflight": "betaflight-configurator #", "ardupilot": "AC_AutoTune_Heli.cpp"}
"""Firmware -> words of the source of its rules."""


def curves(gain, phase) -> Any:
    """Curves of a loop by its gain [dB] and phase [deg] at corner frequencies, linear between them."""
    decibels, degrees = (
        np.interp(FREQUENCIES, [at for at, _ in corners], [value for _, value in corners]) for corners in (gain, phase)
    )
    loop = 10.0 ** (decibels / 20.0) * np.exp(1j * np.radians(degrees))
    return Curves("roll", FREQUENCIES, loop[None], ("",))


def simple(margin) -> Any:
    """A loop with one crossover at 1 and a gain of -margin from 3 on, where its phase is -161 deg."""
    return curves(
        [(0.0, 12.0), (1.0, 0.0), (3.0, -margin), (10.0, -margin)], [(0.0, -90.0), (3.0, -161.0), (10.0, -161.0)]
    )


TWICE = curves(
    [(0.0, 6.0), (1.0, 0.0), (1.5, -4.0), (2.0, 0.0), (2.5, 6.0), (3.0, 0.0), (5.0, -9.0), (10.0, -9.0)],
    [(0.0, -90.0), (1.4, -170.0), (1.6, -170.0), (2.2, -100.0), (3.0, -120.0), (5.0, -161.0), (10.0, -162.0)],
)
"""A loop that crosses 0 dB downwards at 1 and at 3. It has -161 deg at 1.3 with 2.5 dB left, at 5 with 9 dB left."""


def loop_set(ms: float = 1.5, margin: float = 10.0, **filters: float) -> Any:
    gains = {f"roll.{name}": 100.0 for name in ("d_lpf1", "d_lpf2")} | {
        f"roll.{name}": value for name, value in filters.items()
    }
    return SimpleNamespace(ms=lambda _: ms, gains=gains, loops=simple(margin))


@pytest.fixture(autouse=True)
def given_curves(monkeypatch):
    monkeypatch.setattr(rules_module, "curves_of", lambda loops, _: loops)


def test_a_margin_is_that_beyond_the_last_of_two_crossovers():
    assert margin_at_phase(TWICE, "roll") == pytest.approx(9.0, abs=0.05)
    assert margin_at_phase(simple(7.5), "roll") == pytest.approx(7.5, abs=0.05)


def test_a_phase_that_stays_above_leaves_every_margin():
    flat = curves([(0.0, 12.0), (1.0, 0.0), (10.0, -40.0)], [(0.0, -90.0), (10.0, -160.0)])
    assert margin_at_phase(flat, "roll") is None


CHANGES = {
    "peak sensitivity Ms": ("betaflight", {"ms": 1.5}, {"ms": 2.5}, len(ATTITUDE_AXES)),
    "unstable": ("betaflight", {"ms": 1.5}, {"ms": np.inf}, len(ATTITUDE_AXES)),
    "D-term low-pass 1 over that before": ("betaflight", {"d_lpf1": 100.0}, {"d_lpf1": 150.0}, 1),
    "D-term low-pass 2 over that before": ("betaflight", {"d_lpf2": 100.0}, {"d_lpf2": 150.0}, 1),
    "a low-pass is switched off": ("betaflight", {"d_lpf2": 100.0}, {"d_lpf2": 0.0}, 1),
    # A rule of helicopters warns: ArduPilot's own autotune of multicopters leaves 1.9 dB.
    "gain left at a phase of -161 deg": ("ardupilot", {"margin": 10.0}, {"margin": 3.0}, 0),
}
"""Rule -> firmware, a sound state and a worse one, number of rows that refuse the change from one to the other."""


@pytest.mark.parametrize(("firmware", "sound", "worse", "count"), CHANGES.values(), ids=CHANGES)
def test_a_rule_refuses_the_worse_direction_alone(firmware, sound, worse, count):
    def refusing(after, before, noise_rises=True):
        rows = firmware_rules(firmware, loop_set(**after), None if before is None else loop_set(**before), noise_rises)
        return [row for row in rows if row.refuses]

    rows = firmware_rules(firmware, loop_set(**worse), loop_set(**sound), True)
    assert any(row.verdict == "violated" for row in rows)
    assert len(refusing(worse, sound)) == count
    assert all(row.verdict == "violated" for row in refusing(worse, sound))
    # Back, the same again, and without a file before: nothing is made worse.
    assert refusing(sound, worse) == refusing(sound, sound) == refusing(worse, worse) == refusing(worse, None) == []


@pytest.mark.parametrize("firmware", RULES)
def test_every_rule_names_its_source_and_has_a_case_here(firmware):
    rows = firmware_rules(firmware, loop_set(), loop_set(), False)
    assert rows and all(TOOLS[firmware] in row.source for row in rows)
    assert {row.rule for row in rows} <= {rule for rule, (of, *_) in CHANGES.items() if of == firmware}


@pytest.mark.parametrize("name", ["d_lpf1", "d_lpf2"])
def test_a_higher_filter_without_more_noise_is_violated_and_refuses_nothing(name):
    rows = firmware_rules("betaflight", loop_set(**{name: 150.0}), loop_set(), False)
    (row,) = (row for row in rows if row.verdict == "violated")
    assert row.value == 1.5 and not row.refuses and "noise" not in row.note
    (refusing,) = (
        row for row in firmware_rules("betaflight", loop_set(**{name: 150.0}), loop_set(), True) if row.refuses
    )
    assert "noise of the commands rises" in refusing.note


@pytest.mark.parametrize(("ms", "refuses"), [(2.19, False), (2.21, True)])
def test_a_peak_above_2_must_grow_by_a_tenth_to_refuse(ms, refuses):
    rows = firmware_rules("betaflight", loop_set(ms=ms), loop_set(ms=2.0), False)
    assert any(row.refuses for row in rows) == refuses


@pytest.mark.parametrize(("margin", "verdict"), [(6.1, "satisfied"), (5.9, "violated")])
def test_a_margin_below_6_is_violated(margin, verdict):
    rows = firmware_rules("ardupilot", loop_set(margin=margin), None, False)
    assert {row.verdict for row in rows} == {verdict}


def test_a_firmware_without_rules_has_none():
    assert firmware_rules("px4", loop_set(), loop_set(), True) == []
