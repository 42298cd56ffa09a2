"""Margins against python-control on the same state space: random stable designs of every law of the registry.

python-control reads margins off a grid; what it finds there is refined with roots and minima of SciPy on its own frequency
response, and its disk margins on ever narrower grids.
"""

import sys
from functools import cache
from typing import Any

import control
import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from objectives.margins.disk import disk_range
from objectives.margins.period import CHANNELS
from plant.laws import LAWS
from tests.objectives.margins.designs import OPTIONS, H, model_of, random_gains

DESIGNS = 17
GRID = np.geomspace(1e-2, np.pi / H, 300)
RELATIVE = 1e-6


@pytest.fixture(autouse=True)
def no_slycot(monkeypatch):
    """python-control looks for it at every frequency; told at once that it is not there, it takes half the time."""
    monkeypatch.setitem(sys.modules, "slycot", None)


@cache
def designs(name):
    """Stable designs of a law as (model, margins, row, index, channel); channels take turns, options from law to law."""
    options = list(OPTIONS.values())[list(LAWS).index(name) % len(OPTIONS)]
    model = model_of(name, name, options)
    gains = random_gains(name, name, 160, 1)
    margins = model.evaluate(gains)
    found = [(model, margins, gains[i], i, i % 6) for i in range(len(gains)) if margins.stable[i, i % 6]]
    return found[:DESIGNS]


def loop_of(model, gains, channel):
    """Loop transfer function as a system of python-control: closed loop T with its command taken back off the input."""
    r = model.realisation(gains, CHANNELS[channel], model.cases[0])
    return control.ss(r.a - np.outer(r.b, r.c), r.b[:, None], -r.c[None], 0.0, H)


class Loop:
    """Frequency response of a system as python-control works it out, kept for the grid."""

    def __init__(self, system):
        self.system = system
        self.on_grid = system(np.exp(1j * GRID * H))

    def __call__(self, w):
        return complex(self.system(np.exp(1j * w * H)))

    def refined(self, f, w):
        """Root of f(L) next to a frequency."""
        i = int(np.clip(np.searchsorted(GRID, w), 1, len(GRID) - 1))
        for low, high in ((GRID[i - 1], GRID[i]), (GRID[max(i - 2, 0)], GRID[min(i + 1, len(GRID) - 1)])):
            if f(self(low)) * f(self(high)) < 0.0:
                return brentq(lambda v: f(self(v)), low, high, xtol=1e-10 * high, rtol=np.float64(1e-10))
        return w

    def least(self, f):
        """Least f(L) over all frequencies, ends included."""
        values = f(self.on_grid)
        lowest = []
        for i in np.nonzero(values < 1.2 * values.min(axis=0))[0]:
            bounds = GRID[max(i - 1, 0)], GRID[min(i + 1, len(GRID) - 1)]
            if values[max(i - 1, 0)] >= values[i] <= values[min(i + 1, len(GRID) - 1)]:
                found: Any = minimize_scalar(
                    lambda w: f(self(w)), bounds=bounds, method="bounded", options={"xatol": 1e-6 * bounds[1]}
                )
                lowest.append(min(found.fun, values[i]))
        return min(lowest)


def classical(loop):
    """Gain factors up and down, phase and delay margin of a loop, from the crossings that python-control finds."""
    data = control.frd(loop.on_grid, GRID, smooth=True)
    gains, phases, _, w_gain, w_phase, _ = control.stability_margins(data, returnall=True)
    factors = np.array([abs(1.0 / loop(loop.refined(np.imag, w))) for w in w_gain])
    crossed = np.array([loop.refined(lambda z: np.log(np.abs(z)), w) for w in w_phase])
    # At z = -1 the loop is real, which a grid does not tell.
    end = loop.on_grid[-1].real
    factors = np.append(factors, -1.0 / end if end < 0.0 else np.inf)
    lag = np.mod(np.angle([loop(w) for w in crossed]) + np.pi, 2.0 * np.pi) if len(crossed) else np.array([])
    return {
        "gain_up": min(factors[factors > 1.0], default=np.inf),
        "gain_down": min(1.0 / factors[(factors < 1.0) & (factors > 0.0)], default=np.inf),
        "phase": min(np.minimum(lag, 2.0 * np.pi - lag), default=np.inf),
        "delay": min(lag / crossed, default=np.inf) if len(lag) else np.inf,
    }


def agree(got, wanted, what):
    if max(got, wanted) > 1e3 and what.startswith("gain"):
        return
    assert got == pytest.approx(wanted, rel=RELATIVE), what


@pytest.mark.parametrize("name", LAWS)
def test_margins_are_those_of_python_control(name):
    found = designs(name)
    assert len(found) == DESIGNS
    for model, margins, gains, row, channel in found:
        loop = Loop(loop_of(model, gains, channel))
        value = {key: getattr(margins, key).value[row, channel] for key in ("gain_up", "gain_down", "phase", "delay")}
        for what, wanted in classical(loop).items():
            agree(value[what], wanted, what)
        agree(margins.sensitivity.value[row, channel], 1.0 / loop.least(lambda z: np.abs(1.0 + z)), "Ms")
        agree(margins.complementary.value[row, channel], 1.0 / loop.least(lambda z: np.abs(1.0 + 1.0 / z)), "Mt")


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


def disks_agree(name, skew, step):
    for model, _, gains, _, channel in designs(name)[::step]:
        # The skew is all that changes: the model is built once.
        model.skew = skew
        margins = model.evaluate(gains[None])
        alpha = margins.disk.value[0, channel]
        wanted, gain, phase = disk_of_control(loop_of(model, gains, channel), skew)
        assert alpha == pytest.approx(wanted, rel=RELATIVE)
        held = disk_range(wanted, skew)
        assert 20.0 * np.log10(min(1.0 / held.low, held.high)) == pytest.approx(gain, rel=1e-9)
        assert np.degrees(held.phase) == pytest.approx(phase, rel=1e-9)


@pytest.mark.parametrize("name", LAWS)
def test_disk_margins_are_those_of_python_control(name):
    for skew in SKEWS:
        disks_agree(name, skew, 8)


@pytest.mark.slow
@pytest.mark.parametrize("skew", SKEWS)
@pytest.mark.parametrize("name", LAWS)
def test_disk_margins_of_every_design_are_those_of_python_control(name, skew):
    disks_agree(name, skew, 1)
