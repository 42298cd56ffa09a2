"""Plain labels, definitions and units of quantities, from their registries."""

import re
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

from objectives.margins.quantities import QUANTITIES
from objectives.metrics.registry import METRICS
from objectives.risk import RISKS
from tuner.documents.summary import ComparedRow, RequiredRow, TableRow
from tuner.documents.tuning import DEFAULT
from tuner.text.neutral import Neutral
from tuner.text.numbers import significant

if TYPE_CHECKING:
    from tuner.documents.comparison import ComparedFolder
    from tuner.documents.tuning import TuningFolder

_RISK = re.compile(r"([a-z_]+?)(\d+(?:\.\d+)?)?\(")
_LEVEL = re.compile(r"[a-z_]+(\d+(?:\.\d+)?)\(")
_SHARE = re.compile(r"(?:the )?share (1 - )?`level`")
_ERROR = re.compile(r" ?error ?")
_MARGIN = re.compile(r"(\w+)(?:\((.*)\)|\.(.*))?$")
# Times from which on they are printed in seconds, and in minutes [s].
SLOW, VERY_SLOW = 1.0, 600.0
MEDIAN = 50.0
"""Level of the quantile that is named median [%]."""


def plain_metric(metric: str, channels: Collection[str] | None = None) -> str:
    """Return a metric in words: "position error (ITAE)", "rotor travel"; its name where it has no title.

    Args:
        metric: Address of the metric.
        channels: Channels of a plant; its other signals have no errors but values, "force RMS". None for quadrotors.
    """
    family, _, signal = metric.partition(".")
    title = METRICS[family].title if family in METRICS else ""
    if channels is not None:
        title = title if signal in channels else _ERROR.sub("", title)
        title = Neutral().text(title.replace("rotor command", "command").replace("rotor", "command"))
    return f"{signal.replace('_', ' ')} {title}".strip() if title else metric


def plain_risk(label: str) -> str:
    """Return the risk of a label in words: "mean of the worst 20 %", "median", "95 % quantile"; "" for the mean."""
    match = _RISK.match(label)
    if match is None or match[1] not in RISKS:
        return ""
    level = float(match[2] or 0.0)
    if match[1] == "quantile" and level == MEDIAN:
        return "median"
    return RISKS[match[1]].title.format(level=significant(level), beyond=significant(100.0 - level))


def plain_label(
    label: str,
    metric: str,
    scenario: str | None = None,
    channels: Collection[str] | None = None,
    short: bool = False,
) -> str:
    """Return a quantity in words: "position error (ITAE), mean of the worst 20 %".

    scenario: named behind it; short: without "mean of the".
    """
    risk = plain_risk(label)
    parts = [plain_metric(metric, channels), risk.removeprefix("mean of the ") if short else risk, scenario]
    return ", ".join(part for part in parts if part)


def compared_label(compared: "ComparedFolder", label: str, short: bool = True) -> str:
    """Return a compared quantity in plain words."""
    row = compared.quantity.get(label)
    if row is None:
        return label
    scenario = row.scenario if len(compared.document.compared_on) > 1 else None
    return plain_label(label, row.metric, scenario, channels_of(compared), short)


def channels_of(compared: "ComparedFolder") -> set[str] | None:
    """Return the channels of the plants that flew, None where quadrotors flew."""
    if any(entry.airframe for entry in compared.contenders):
        return None
    return {name for entry in compared.contenders for name in entry.channels or {}}


def user_names(compared: "ComparedFolder") -> list[str]:
    """Return the names that study, contenders and plants give."""
    scenarios = [entry.scenario for entry in compared.document.compared_on]
    channels = [name for entry in compared.contenders for name in entry.channels or {}]
    return [compared.document.title, *compared.index, *compared.flown, *scenarios, *channels]


def names_of(results: "TuningFolder") -> dict[str, str]:
    """Return the compared quantities of a run in plain words, by label."""
    return {row.label: named(results, row, short=True) for row in results.quantities}


def in_plain_words(text: str, names: Mapping[str, str]) -> str:
    """Return a sentence with labels of quantities in plain words.

    Args:
        text: Sentence of a document.
        names: Label -> plain words.
    """
    for label in sorted(names, key=len, reverse=True):
        text = text.replace(label, names[label])
    return text


def plain_margin(label: str) -> str:
    """Return a limited margin in words: "phase margin", "phase margin of roll"."""
    match = _MARGIN.match(label)
    if match is None or match[1] not in QUANTITIES:
        return label
    loop = match[2] or match[3]
    return f"{QUANTITIES[match[1]].label}{f' of {loop}' if loop else ''}"


def named(results: "TuningFolder", row: ComparedRow | RequiredRow, short: bool = False) -> str:
    """Return a row in plain words, with its scenario among several."""
    if row.kind == "requirement":
        return plain_margin(row.label)
    scenario = row.scenario if len(results.resolved.scenario) > 1 else None
    return plain_label(row.label, row.metric, scenario, _channels(results), short)


@lru_cache(maxsize=1)
def titles_of(results: "TuningFolder") -> dict[str, str]:
    """Return words for each point of a run: "tuned gains (p0122)".

    The name is behind them; a point without words has its name alone.
    """
    front = results.held_out_front
    words = {entry.point: f"{point_words(results, entry.name)} ({entry.point})" for entry in results.document.points}
    words |= {results.tuned: results.shown_name, DEFAULT: f"default {results.gains_noun}"}
    return {point: words.get(point, point) for point in front.points}


def point_words(results: "TuningFolder", name: str) -> str:
    """Return the name of a named point in words: "least position error (ITAE)"."""
    kind, _, metric = name.partition("-")
    is_metric = kind == "least" and metric in [row.metric for row in results.objectives]
    return f"least {plain_metric(metric, _channels(results))}" if is_metric else name


def _channels(results: "TuningFolder") -> set[str] | None:
    """Return the channels of a plant; None if a quadrotor flew."""
    return None if results.has_rotors else {channel.name for channel in results.resolved.channel}


def risk_words(label: str, risk: str) -> str:
    """Return a risk in words: "worst 10 % of the scenarios"."""
    level = _LEVEL.match(label)
    if level is None:
        return risk
    beyond = f"{significant(100.0 - float(level[1]))} %"
    return _SHARE.sub(lambda match: beyond if match[1] else f"{level[1]} %", risk)


def definition_text(row: TableRow) -> str:
    """Return label, definition and scenario of a quantity."""
    if row.kind == "requirement":
        return f"{row.label}: {row.quantity}"
    where = "all scenarios" if row.scenario is None else f"scenario {row.scenario}"
    return f"{row.label}: {row.definition}; {risk_words(row.label, row.risk)}, {where}".replace("`", "")


def time_unit(name: str, values: Sequence[float | None]) -> tuple[str, float]:
    """Return the unit of a row of margins, and its size in the shown unit.

    Args:
        name: Name of the quantity.
        values: Its readings in SI units; None has no end.
    """
    unit = QUANTITIES[name].shown_unit
    longest = max((value for value in values if value is not None), default=0.0)
    slow = unit == "ms" and longest >= SLOW
    return ("min", 6e4) if slow and longest >= VERY_SLOW else ("s", 1e3) if slow else (unit, 1.0)
