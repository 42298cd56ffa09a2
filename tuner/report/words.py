"""Metrics and margins in plain words, for the sentences and tables that a page opens with."""

import re

from objectives.margins.quantities import QUANTITIES
from tuner.text.numbers import significant

NOUNS = {
    "itae": "error", "iae": "error", "ise": "squared error", "rms": "RMS error", "peak": "peak", "overshoot": "overshoot",
    "rise": "rise time", "settling": "settling time", "recovery": "recovery time", "steady_error": "steady error",
    "travel": "rotor travel", "effort": "rotor effort", "saturation": "saturation", "command_peak": "largest rotor command",
    "failure": "failed flights",
}  # fmt: skip
_RISK = re.compile(r"([a-z_]+?)(\d+(?:\.\d+)?)?\(")


def plain_metric(metric: str) -> str:
    """Return what a metric measures: "position error", "rotor travel"; its name where there are no words for it."""
    family, _, signal = metric.partition(".")
    noun = NOUNS.get(family)
    return metric if noun is None else f"{signal.replace('_', ' ')} {noun}".strip()


def plain_risk(label: str) -> str:
    """Return over which flights a quantity is taken, from its label: "mean", "worst 20 %", "median", "95 % quantile"."""
    found = _RISK.match(label)
    if found is None:
        return ""
    name, level = found[1], float(found[2] or 0.0)
    if name == "cvar":
        return f"worst {significant(100.0 - level)} %"
    if name == "quantile":
        return "median" if level == 50.0 else f"{significant(level)} % quantile"
    return name


def plain_margin(label: str) -> str:
    """Return what a requirement limits, from its label such as "phase_margin" or "ms.roll"."""
    head, dot, axis = label.partition(".")
    label = QUANTITIES[head].label if head in QUANTITIES else head
    return f"{label}{dot and ' of '}{axis}"
