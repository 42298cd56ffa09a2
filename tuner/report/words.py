"""Laws, metrics, margins and gaps in plain words."""

import re

from objectives.margins.quantities import QUANTITIES
from plant.laws import LAWS
from tuner.documents.parts import Estimate
from tuner.documents.resolved import Resolved
from tuner.documents.summary import PickedOn, Summary, UncertaintyCost
from tuner.text.numbers import per_cent, significant

NOUNS = {
    "itae": "error", "iae": "error", "ise": "squared error", "rms": "RMS error", "peak": "peak", "overshoot": "overshoot",
    "rise": "rise time", "settling": "settling time", "recovery": "recovery time", "steady_error": "steady error",
    "travel": "rotor travel", "effort": "rotor effort", "saturation": "saturation", "command_peak": "largest rotor command",
    "failure": "failed flights", "noise": "rotor command noise",
}  # fmt: skip
_RISK = re.compile(r"([a-z_]+?)(\d+(?:\.\d+)?)?\(")


def plain_metric(metric: str, rotors: bool = True) -> str:
    """Return what a metric measures: "position error", "rotor travel"; its name where there are no words for it.

    rotors: whether commands are those of rotors.
    """
    family, _, signal = metric.partition(".")
    noun = NOUNS.get(family)
    if noun is not None and not rotors:
        noun = noun.replace("rotor command", "command").replace("rotor", "command")
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


def law_title(name: str) -> str:
    """Return what a law is called in full."""
    return LAWS[name].title if name in LAWS else name


def laws_of(resolved: Resolved) -> list[tuple[str, str]]:
    """Return the law of each loop: pairs of law and loop."""
    controller = resolved.controller
    if controller is None:
        return [(channel.law, channel.name) for channel in resolved.channel]
    return [(controller.position, "position"), (controller.attitude, "attitude")]


def gap_words(picked: PickedOn, gap: Estimate) -> str:
    """Return what the gap between held-out and search value of the recommended point says of the search.

    picked: `picked_on` of summary.json; a folder of an earlier version holds no `lost_in_search`.
    """
    lost = picked.lost_in_search if "lost_in_search" in picked.model_fields_set else 0.0
    if lost is None:
        return "it was not flown in the search, whose value is that of flights that failed at once"
    if lost > 0.0:
        return f"it lost {per_cent(lost)} of its flights in the search, and a lost flight costs more than any other"
    if gap.low is not None and gap.low > 0.0:
        return "the search was optimistic"
    return (
        "the search was pessimistic"
        if gap.high is not None and gap.high < 0.0
        else "no optimism of the search to be told"
    )


def loss_words(summary: Summary) -> list[str]:
    """Return what losses that were not seen could do, and the lost flights by name."""
    unseen = [] if summary.unseen is None else [summary.unseen.words]
    return [*unseen, *[f"Lost: {entry.words}." for entry in summary.lost_flights]]


def uncertainty_words(row: UncertaintyCost) -> str:
    """Return what an objective loses because the vehicle is not known better, and which number to measure next."""
    first, whole = row.next, abs(row.mean)
    spread = (
        f"{first.name} explains {per_cent(first.share)} of the spread"
        if first.shows
        else "no number shows in the spread"
    )
    if not row.told:
        return (
            f"{row.label}: knowing the vehicle better would change no choice among {row.finalists} finalists; {spread}."
        )
    worth = f"it alone is worth {per_cent(first.value / whole)}" if first.told else "none is worth much alone"
    return (
        f"{row.label}: not knowing the vehicle better costs {per_cent((row.mean - row.known) / whole)} of its mean among "
        f"{row.finalists} finalists. Measure {first.name} next: {worth}; {spread}."
    )
