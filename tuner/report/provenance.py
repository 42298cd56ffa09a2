"""Origin of the numbers: study, seed, versions, machine, the air that was flown, and what the words mean."""

import shlex
from collections.abc import Iterable, Sequence
from math import degrees

from tuner.documents.comparison_document import QuantityRow
from tuner.documents.parts import PlantStep
from tuner.documents.resolved import Resolved, ResolvedSearch
from tuner.documents.summary import ComparedRow
from tuner.documents.tuning import TuningFolder
from tuner.report.answer_section import metric_anchor
from tuner.report.page import collapsible, collapsible_text, wide
from tuner.report.words import law_title, laws_of
from tuner.search.names import CONVERGED
from tuner.store.environment import Environment
from tuner.study.step_costs import cost_text
from tuner.text.markup import Markup, coded, described, element, join, table
from tuner.text.numbers import MISSING, count, duration, significant
from tuner.text.units import marked_up

# Keys of the environment that are told in words; the rest are versions of packages.
LISTED = ("platform", "cpu", "simd", "threads", "started", "command", "commit", "resumed")
AIR = (
    ("Specification", "spec", ""),
    ("Intensity", "intensity", ""),
    ("Altitude", "altitude", "m"),
    ("Mean wind", "mean_wind", "m/s"),
    ("Airspeed V_eff", "airspeed", "m/s"),
    ("σ_u / V_eff", "frozen_field_ratio", ""),
    ("Trim tilt", "trim_tilt", "deg"),
    ("Trim thrust / weight", "trim_thrust", ""),
)
RULE_TEXT = (
    "the interval of the difference lies on one side of zero, and the difference exceeds what matters: 2 % of the value compared "
    "with, or the study's `relevant`. No practical difference: the interval lies within that. Not distinguishable: neither."
)
"""The rule of `objectives.risk.differences` in words."""
AXES, TRIPLES = "uvw", ("length", "sigma", "tau")
WORDS = (
    ("Held-out", "simulated in scenarios that the search never saw, the same for every point."),
    ("Confirmation", "default and tuned, simulated in further scenarios that had no part in the selection."),
    (
        "95 % interval",
        "bootstrap over scenarios: it covers the sampling of scenarios, not errors of the model.",
    ),
    (
        "Tuned − default",
        "paired over the same scenarios, so its interval is narrower than those of the two values suggest.",
    ),
    ("Better, worse", RULE_TEXT),
    (
        "Satisfied, violated",
        "the upper end of the interval satisfies the limit, or the value violates it; else not certain.",
    ),
    (
        "Front",
        "feasible points that no other feasible point dominates.",
    ),
    (
        "Hypervolume",
        "share of the box between zero and 1.1 times the default's values that the search's feasible front dominates.",
    ),
    ("Feasible", "every limit is satisfied."),
)


def provenance_section(results: TuningFolder) -> Markup:
    """Return the section without its heading."""
    return join(
        (
            run_facts(results),
            element(
                "div",
                *([collapsible("Turbulence", wide(air_table(results)))] if results.document.air else []),
                collapsible("Definitions", definitions(results)),
                collapsible_text("Study file", results.study_text),
                collapsible_text("Study file with all defaults", resolved_text(results)),
                class_="foldings",
            ),
        )
    )


def run_facts(results: TuningFolder) -> Markup:
    """Return study, seed, machine, command and versions."""
    resolved, environment, summary = results.resolved, results.environment, results.document
    command, *about = environment_facts(environment)
    facts = [
        ("Study", join((summary.study, " (digest ", element("code", resolved.digest or MISSING), ")"))),
        ("Seed", str(resolved.seed)),
        *_flown(resolved, summary.plant_step),
        ("Search", _search(resolved.search)),
        ("Pick rule", summary.pick.rule),
        _flights(results),
        command,
        ("To reproduce it", _reproduced(results)),
        *about,
    ]
    return described(facts, class_="facts columns")


def _flown(resolved: Resolved, step: PlantStep | None) -> list[tuple[str, str]]:
    """Return vehicle or plant, laws and steps; nothing where another program made the trials."""
    airframe, controller, plant = resolved.airframe, resolved.controller, resolved.plant
    laws = "; ".join(f"{law_title(law)} ({loop})" for law, loop in laws_of(resolved))
    if airframe is None or controller is None:
        if plant is None:
            return []
        title, period = plant.title or plant.name, plant.control_period
        return [("Plant", title), ("Laws", laws), ("Control period", _period(period, step))]
    period = controller.control_period
    return [
        ("Airframe", airframe.title or airframe.name),
        ("Laws", laws),
        ("Control period", _period(period, step)),
        ("Control step", (cost_text(controller.position, controller.attitude, period) if period else "") or MISSING),
    ]


def _flights(results: TuningFolder) -> tuple[str, str]:
    summary = results.document
    if summary.wall_seconds is None:
        return "Trials", f"{count(summary.flights)}, run by another program: asked.jsonl and told.jsonl"
    return "Flights", f"{count(summary.flights)} in {duration(summary.wall_seconds)}"


def environment_facts(environment: Environment) -> list[tuple[str, str]]:
    """Return command, time, machine, versions and commit of a run, from environment.json."""
    facts = environment.content()
    versions = ", ".join(f"{name} {value}" for name, value in facts.items() if name not in LISTED and value)
    rows = [
        ("Command", element("code", environment.command or MISSING)),
        ("Started", environment.started or MISSING),
        ("Machine", _machine(environment)),
        ("Versions", versions or MISSING),
    ]
    return [*rows, ("Commit", element("code", environment.commit))] if environment.commit else rows


def air_table(results: TuningFolder) -> Markup:
    """Return the air of each scenario: airspeed, scale lengths, intensities, time constants, and trim in its mean wind."""
    rows = []
    for stored in results.document.air:
        tilt = None if stored.trim_tilt is None else degrees(stored.trim_tilt)
        entry = stored.model_copy(update={"trim_tilt": tilt})
        axes = [" / ".join(significant(getattr(entry, f"{name}_{axis}"), 3) for axis in AXES) for name in TRIPLES]
        rows.append([entry.scenario, *[_cell(getattr(entry, key)) for _, key, _ in AIR], *axes])
    head = ["Scenario", *[f"{name} [{unit}]" if unit else name for name, _, unit in AIR]]
    head += ("Lengths u / v / w [m]", "σ u / v / w [m/s]", "τ u / v / w [s]")
    return table(head, rows, class_="air stacked")


def definitions(results: TuningFolder) -> Markup:
    """Return definitions of metrics and of the words of the report."""
    return glossary(results.quantities, WORDS)


def glossary(quantities: Sequence[QuantityRow | ComparedRow], words: Iterable[tuple[str, str]]) -> Markup:
    """Return the definition of the metric behind each quantity, once each, then terms with their meanings."""
    listed = [
        element(
            "div",
            element("dt", element("code", name)),
            element("dd", coded(entry.definition), _in_unit(entry.unit)),
            id=metric_anchor(name),
        )
        for name, entry in {entry.metric: entry for entry in quantities}.items()
    ]
    terms = [element("div", element("dt", term), element("dd", meaning)) for term, meaning in words]
    return element("dl", *listed, *terms, class_="facts")


def resolved_text(results: TuningFolder) -> str:
    """Return every value of the study, defaults included, as JSON."""
    return results.resolved.text().rstrip()


def _in_unit(unit: str) -> Markup:
    return join((" [", marked_up(unit), "]")) if unit else Markup()


def _period(period: float | None, plant_step: PlantStep | None) -> str:
    """Return the control period [s] in words, and the steps of the plant where they are known."""
    if period is None:
        return MISSING
    return "; plant: ".join([f"{significant(period)} s", *([plant_step.words] if plant_step else [])])


def _search(search: ResolvedSearch) -> str:
    sizes = (search.generations, "generations"), (search.population, "candidates each")
    size = " of ".join(f"{number} {noun}" for number, noun in sizes if number is not None)
    most = "at most " if size and search.stop == CONVERGED else ""
    return ", ".join(filter(None, [search.algorithm, f"{most}{size}"]))


def _machine(environment: Environment) -> str:
    threads = f"{environment.threads} threads" if environment.threads else None
    return ", ".join(filter(None, [environment.cpu, threads, environment.simd, environment.platform])) or MISSING


def _reproduced(results: TuningFolder) -> Markup:
    """Return the commands that check this folder and that fly it once more."""
    name = shlex.quote(results.home.name or ".")
    if results.is_external:
        rerun = element("code", f"tuner ask {name}/study.toml --out again")
        return join((rerun, ", told the lines of ", element("code", f"{name}/told.jsonl")))
    rerun, check = f"tuner run {name}/study.toml --out again", f"tuner verify {name}"
    return join(
        (element("code", rerun), ", or ", element("code", check), "; any number of threads gives the same bits")
    )


def _cell(value: object) -> str:
    return significant(value, 3) if isinstance(value, (int, float)) else str(MISSING if value is None else value)
