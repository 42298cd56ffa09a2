"""margins.parquet of a run: the stability margins and the loop transfer function of every finalist, channel by channel.

The loop is that of hover in still air as it is flown, at the amplitude of its nonlinear terms at which its sensitivity peaks
highest, on the nominal vehicle. Where two channels have the same gains and the same dynamics their rows are alike.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.margins.period import CHANNELS
from objectives.margins.quantities import QUANTITIES, RECORDED
from objectives.margins.results import Margins
from plant.errors import InputError

if TYPE_CHECKING:
    from objectives.margins.margins import MarginModel
    from tuner.experiments.tuning.outcome import Outcome

# Frequencies of a curve, from so many rad/s up to Nyquist: 28 a decade, which a line through them does not show.
POINTS, LOWEST = 120, 0.05


def margin_table(outcome: "Outcome") -> Any:
    """Return a pandas table, a row for each finalist and channel with a loop; None where no steady flight is found.

    Columns: point, channel, stable, those of `RECORDED` in SI units (empty where no crossing limits a margin, or where the loop
    is not stable), case (amplitude of the curve in words, empty for a linear loop), and the lists frequency [rad/s], real and
    imag of the loop transfer function.
    """
    import pandas as pd

    try:
        model = margin_model(outcome)
    except InputError:
        return None
    margins = model.evaluate(outcome.finalist_rows)
    looped = {channel for block in model.blocks for channel in block}
    rows = [
        loop_row(model, margins, outcome.gains(row), row, channel) | {"point": name}
        for row, name in enumerate(outcome.names)
        for channel in CHANNELS
        if channel in looped
    ]
    return pd.DataFrame(rows, columns=pd.Index(["point", *[key for key in rows[0] if key != "point"]]))


def margin_model(outcome: "Outcome") -> "MarginModel":
    """Return the margins of the study's loop; raises InputError where there is no steady flight."""
    from objectives.margins.margins import MarginModel
    from objectives.margins.trim import Trim
    from tuner.study.margins import holds_place

    system = outcome.study.system
    held = holds_place(tuple(entry.spec for entry in outcome.study.scenarios), system.timing)
    return MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, Trim(hold=held))


def loop_row(model: "MarginModel", margins: Margins, gains: np.ndarray, row: int, channel: str) -> dict[str, Any]:
    """Return margins and curve of one loop of one finalist."""
    i = CHANNELS.index(channel)
    stable = bool(margins.stable[row, i])
    values = {name: float(QUANTITIES[name].values(margins)[row, i]) for name in RECORDED}
    case = max(int(margins.sensitivity.case[row, i]), 0)
    frequency = np.geomspace(LOWEST, np.pi / model.period, POINTS)
    loop = model.loop(gains, channel, model.cases[case], frequency).loop
    swept = margins.sensitivity.case[row, i] >= 0
    return {
        "channel": channel,
        "stable": stable,
        **{name: value if stable and np.isfinite(value) else None for name, value in values.items()},
        "case": model.cases[case].label if swept else "",
        "frequency": frequency.astype(np.float32),
        "real": loop.real.astype(np.float32),
        "imag": loop.imag.astype(np.float32),
    }
