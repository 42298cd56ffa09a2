"""Every registry as a table: laws, metrics, airframes and what else a study or an export may name."""

from collections.abc import Callable, Iterable
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from objectives.margins.quantities import LIMITABLE
from objectives.metrics import METRICS
from objectives.risk import RISKS
from plant.errors import InputError, UnknownNameError
from plant.input_files import read_input_text
from plant.law_registry import LAWS
from plant.model.signals import SIGNALS
from plant.quadrotor import airframes as bundled
from plant.quadrotor.airframes.derived import quantities
from plant.quadrotor.gains import GROUPS
from plant.references import REFERENCES, parameters
from plant.texts import PlainTable, toml_table
from tuner.api.frames import frame
from tuner.extension import extensions, objects, refuse_lacking
from tuner.search.names import ALGORITHMS, AUTOMATIC

if TYPE_CHECKING:
    import pandas as pd

Rows = list[PlainTable]


def laws() -> Rows:
    """Control laws and their gains."""
    LAWS.ask_packages()
    return [
        {
            "law": law.name,
            "title": law.title,
            "gain": gain.name.rstrip("_"),
            "symbol": gain.symbol,
            "loop": loop,
            "unit": gain.unit_in(loop),
            "default": gain.span(loop).default,
            "low": gain.span(loop).low,
            "high": gain.span(loop).high,
            "scale": gain.scale,
            "meaning": gain.meaning,
            "source": gain.source,
        }
        for law in LAWS.values()
        for loop in ("attitude", "position")
        for gain in law.gains
    ]


def airframes() -> Rows:
    """Bundled airframes and what follows from their numbers."""
    rows = []
    for name in bundled.names():
        airframe = bundled.load(name, allow_unphysical=True)
        derived = quantities(airframe.vehicle)
        rows.append(
            {
                "airframe": name,
                "title": airframe.title,
                "frame": airframe.frame,
                "mass [kg]": airframe.vehicle.mass,
                "hover [rad/s]": derived["hover_speed"].value,
                "thrust:weight": derived["thrust_to_weight"].value,
                "lag [s]": airframe.vehicle.lag_up,
            }
        )
    return rows


def metrics() -> Rows:
    """Metrics; those with axes are addressed as NAME.AXIS or NAME.GROUP."""
    METRICS.ask_packages()
    return [
        {
            "metric": metric.name,
            "unit": metric.unit.format("m|rad"),
            "definition": metric.definition,
            "address": f"{metric.name}.AXIS, AXIS: {', '.join(GROUPS)}, or a channel of a plant of one's own"
            if metric.scope == "axis"
            else metric.name,
        }
        for metric in METRICS.values()
    ]


def risks() -> Rows:
    """Risk measures over scenarios."""
    return [{"risk": name, "definition": risk.definition, "level": risk.has_level} for name, risk in RISKS.items()]


def references() -> Rows:
    """References and their parameters."""
    REFERENCES.ask_packages()
    return [
        {
            "reference": name,
            "about": (kind.__doc__ or "").strip().splitlines()[0],
            "parameters": ", ".join(f"{p.name} [{p.unit}]" for p in parameters(kind)) or "none",
        }
        for name, kind in REFERENCES.items()
    ]


def signals() -> Rows:
    """Signals that channels of a plant of one's own follow, and that disturb it."""
    return [
        {
            "signal": name,
            "about": entry.meaning,
            "follows": "no, it is random" if entry.random else "yes",
            "parameters": ", ".join(f"{field.name} = {field.default:g}" for field in fields(entry)),
        }
        for name, entry in SIGNALS.items()
    ]


def margins() -> Rows:
    """Stability margins that a [[margin]] may ask for."""
    return [
        {
            "quantity": name,
            "unit": entry.limit_unit,
            "limit": entry.sense,
            "axis": "none" if entry.is_multiloop else "axis or group",
            "meaning": entry.meaning,
        }
        for name, entry in LIMITABLE.items()
    ]


def searches() -> Rows:
    """Searches that [search] algorithm may ask for."""
    return [
        {"search": AUTOMATIC, "objectives": "1 or more", "about": "usual: one of these, by the size of the study"},
        *[{"search": name, "objectives": entry.objectives, "about": entry.about} for name, entry in ALGORITHMS.items()],
    ]


def studies() -> Rows:
    """The shipped studies by name, and by path those in this folder and in ./studies."""
    from tuner.study.files import shipped_studies

    shipped = shipped_studies()
    local = [path for path in sorted([*Path("studies").glob("*.toml"), *Path().glob("*.toml")]) if path.is_file()]
    files = {**shipped, **{str(path): path for path in local if path.resolve() not in shipped.values()}}
    rows = []
    for name, path in files.items():
        try:
            table = toml_table(read_input_text(path, "utf-8-sig"), path)
        except (InputError, OSError, UnicodeDecodeError):
            # What lies in a folder need not be a study, nor TOML.
            continue
        if {"scenario", "objective"} <= set(table) or "base" in table:
            row = {"study": name, "title": table.get("title", ""), "seed": table.get("seed"), "file": str(path)}
            rows.append({**row, "shipped": name in shipped})
    return rows


def targets() -> Rows:
    """Targets of `tuner export`."""
    from tuner.exchange.registry import exporters

    return [
        {
            "target": entry.name,
            "title": entry.title,
            "attitude": ", ".join(entry.attitude_laws) or "every law",
            "position": ", ".join(entry.position_laws) or "every law",
            "options": _options(entry.options),
            "experimental": entry.experimental or "",
        }
        for entry in exporters().values()
    ]


def _options(options: Iterable[Any]) -> str:
    """Return options as text: name, what it is, default or that it is required."""
    return "; ".join(
        f"{o.name}{'' if not o.choices else f' ({chr(124).join(o.choices)})'}: {o.about}, "
        f"{'required' if o.default is None else f'default {o.default}'}"
        for o in options
    )


def sources() -> Rows:
    """Parameter files that `tuner import` reads."""
    from tuner.exchange.registry import importers

    return [
        {"source": entry.name, "title": entry.title, "options": _options(entry.options)}
        for entry in importers().values()
    ]


def installed_extensions() -> Rows:
    """Extensions of the tool, and what they add."""
    return [
        {
            "extension": record.name,
            "about": record.about,
            "commands": ", ".join(record.commands),
            "names in Python": ", ".join(f"tuner.{name}" for name in record.api),
            "requires": ", ".join(record.requires),
        }
        for record in extensions().values()
    ]


LISTINGS: dict[str, Callable[[], Rows]] = {
    "airframes": airframes, "extensions": installed_extensions, "laws": laws, "margins": margins, "metrics": metrics,
    "references": references, "risks": risks, "searches": searches, "signals": signals, "sources": sources, "studies": studies,
    "targets": targets,
}  # fmt: skip
"""Listings of the core; those of extensions are in their records."""


@cache
def listings() -> dict[str, Callable[[], Rows]]:
    """Return the functions that list a kind, by kind in alphabetical order."""
    return dict(sorted((LISTINGS | objects("listings")).items()))


def catalogue(kind: str) -> "pd.DataFrame":
    """Return the entries of a kind.

    Args:
        kind: "airframes", "extensions", "firmwares", "laws", "margins", "metrics", "references", "risks", "searches", "signals",
            "sources", "studies", "targets" or "theorems".

    Returns:
        A row for each.

    Raises:
        UnknownNameError: There is no such kind.

    Examples:
        >>> tuner.catalogue("laws").query("gain == 'lambda'")["unit"].tolist()[0]
        's^-1'

    """
    return frame(rows_of(kind))


def about_of(kind: str) -> str:
    """Return the sentence that says what a kind is."""
    return (listings()[kind].__doc__ or "").splitlines()[0].rstrip(".")


def names_of(kind: str) -> list[str]:
    """Return the names of a kind's entries."""
    return list(dict.fromkeys(str(next(iter(row.values()))) for row in rows_of(kind)))


def rows_of(kind: str, containing: str = "") -> Rows:
    """Return the entry of a name, or all entries with a text.

    Case does not matter.
    """
    if kind not in listings():
        refuse_lacking("listings", kind)
        raise UnknownNameError("listing", kind, listings())
    rows, wanted = listings()[kind](), containing.casefold()
    named = [row for row in rows if str(next(iter(row.values()))).casefold() == wanted]
    return named or [row for row in rows if any(wanted in str(cell).casefold() for cell in row.values())]
