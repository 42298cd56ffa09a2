"""Margins against python-control on the same state space: random stable designs of every law of the registry.

What python-control finds on a grid is refined (`python_control`), its disk margins on ever narrower grids.
"""

import sys
from functools import cache
from typing import Any

import control
import numpy as np
import pytest

from objectives.margins.disk import disk_range
from objectives.margins.period import CHANNELS
from plant.law_registry import LAWS
from tests.objectives.margins.designs import CASCADED, OPTIONS, H, model_of, random_gains, realisation
from tests.objectives.margins.python_control import Loop, classical

# Designs of a law that are compared, one of each loop, and those of the slow proofs.
FEW, DESIGNS = 6, 17
# Candidates among which so many stable ones are found.
DRAWN, MANY = 60, 160
# A resonance of a tenth of a rad/s lies between two of 300 points.
GRID = np.geomspace(1e-2, np.pi / H, 900)
RELATIVE = 1e-6
# Peak of the sensitivity up to which loops are compared.
MAX_SENSITIVITY = 50.0


@pytest.fixture(autouse=True)
def no_slycot(monkeypatch):
    """python-control looks for it at every frequency; told at once that it is not there, it takes half the time."""
    monkeypatch.setitem(sys.modules, "slycot", None)


@cache
def designs(name, drawn):
    """Stable ones of some candidates of a law as (model, margins, row, index, channel); channels take turns, options from law to law."""
    options = list(OPTIONS.values())[list(LAWS).index(name) % len(OPTIONS)]
    model = model_of(name, name, options)
    gains = random_gains(name, name, drawn, 1)
    margins = model.evaluate(gains)
    # A loop loses as many digits as its sensitivity has: of one at the edge of stability none are left to compare.
    peaks = margins.sensitivity.value
    sound = [i for i in range(len(gains)) if margins.stable[i, i % 6] and peaks[i, i % 6] < MAX_SENSITIVITY]
    return [(model, margins, gains[i], i, i % 6) for i in sound]


def one_of_each_loop(name):
    """The first stable design of each loop of a law, and further ones where it has less than six that are stable."""
    stable = designs(name, DRAWN)
    first = {design[-1]: design for design in reversed(stable)}
    others = [design for design in stable if design is not first[design[-1]]]
    found = [*first.values(), *others][:FEW]
    assert len(found) == FEW
    return found


def all_designs(name):
    """The first stable designs of a law, for proofs."""
    found = designs(name, MANY)[:DESIGNS]
    assert len(found) == DESIGNS
    return found


def loop_of(model, gains, channel):
    """Loop transfer function as a system of python-control: closed loop T with its command taken back off the input."""
    r = realisation(model, gains, CHANNELS[channel], model.cases[0])
    return control.ss(r.a - np.outer(r.b, r.c), r.b[:, None], -r.c[None], 0.0, H)


def grid_of(system):
    """Frequencies with some around each pole: a loop may rise above 1 and fall again within 1 % at a resonance."""
    poles = np.abs(np.angle(system.poles())) / H
    beside = np.outer(poles, [0.99, 0.994, 0.997, 1.0, 1.003, 1.006, 1.01]).ravel()
    return np.union1d(GRID, beside[(beside > GRID[0]) & (beside < GRID[-1])])


def agree(got, wanted, what):
    if max(got, wanted) > 1e3 and what.startswith("gain"):
        return
    # The gain may fall where several integrators lie together at z = 1, and eigenvalues there have fewer digits.
    assert got == pytest.approx(wanted, rel=10.0 * RELATIVE if what == "gain_down" else RELATIVE), what


def margins_agree(found):
    for model, margins, gains, row, channel in found:
        system = loop_of(model, gains, channel)
        loop = Loop(system, H, grid_of(system))
        value = {key: getattr(margins, key).value[row, channel] for key in ("gain_up", "gain_down", "phase", "delay")}
        for what, wanted in classical(loop).items():
            agree(value[what], wanted, what)
        agree(margins.sensitivity.value[row, channel], 1.0 / loop.least(lambda z: np.abs(1.0 + z)), "Ms")
        agree(margins.complementary.value[row, channel], 1.0 / loop.least(lambda z: np.abs(1.0 + 1.0 / z)), "Mt")


# The delay line of a Smith predictor is large: its loops are those of the slow proofs alone.
QUICK = tuple(name for name in CASCADED if name != "smith")


@pytest.mark.parametrize("name", QUICK)
def test_margins_are_those_of_python_control(name):
    margins_agree(one_of_each_loop(name))


@pytest.mark.slow
@pytest.mark.parametrize("name", CASCADED)
def test_margins_of_every_design_are_those_of_python_control(name):
    margins_agree(all_designs(name))


def disk_of_control(system: Any, skew: float) -> tuple[float, ...]:
    """Disk margin, guaranteed gain [dB] and phase [deg] of python-control, on grids that close in on the worst frequency."""
    w, found = GRID, (np.zeros(1), np.zeros(1), np.zeros(1))
    for _ in range(7):
        found = control.disk_margins(system, w, skew, returnall=True)
        i = int(np.argmin(np.asarray(found[0])))
        w = np.linspace(w[max(i - 1, 0)], w[min(i + 1, len(w) - 1)], 20)
    worst = int(np.argmin(np.asarray(found[0])))
    return tuple(float(np.asarray(part)[worst]) for part in found)


SKEWS = (-0.6, 0.0, 0.75)


def disk_agrees(design, skew):
    model, _, gains, _, channel = design
    # The skew is all that changes: the model is built once.
    model.skew = skew
    margins = model.evaluate(gains[None])
    alpha = margins.disk.value[0, channel]
    wanted, gain, phase = disk_of_control(loop_of(model, gains, channel), skew)
    assert alpha == pytest.approx(wanted, rel=RELATIVE)
    held = disk_range(wanted, skew)
    assert 20.0 * np.log10(min(1.0 / held.low, held.high)) == pytest.approx(gain, rel=1e-9)
    assert np.degrees(held.phase) == pytest.approx(phase, rel=1e-9)


@pytest.mark.parametrize("name", QUICK)
def test_disk_margins_are_those_of_python_control(name):
    for design, skew in zip(one_of_each_loop(name), SKEWS, strict=False):
        disk_agrees(design, skew)


@pytest.mark.slow
@pytest.mark.parametrize("skew", SKEWS)
@pytest.mark.parametrize("name", CASCADED)
def test_disk_margins_of_every_design_are_those_of_python_control(name, skew):
    for design in all_designs(name):
        disk_agrees(design, skew)
