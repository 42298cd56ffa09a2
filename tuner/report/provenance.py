"""Where the numbers come from: study, seed, versions, machine, the air that was flown, and what the words mean."""

import shlex
from math import degrees

from tuner.documents.results import Results
from tuner.report.answer_section import metric_anchor
from tuner.report.page import folded, folded_text, wide
from tuner.report.prose import law_title
from tuner.store.environment import Environment
from tuner.study.processor_cost.cost import told
from tuner.text.markup import Markup, coded, described, element, join, table
from tuner.text.numbers import MISSING, count, duration, significant
from tuner.text.units import marked_up

# Keys of the environment that are told in words; the rest are versions of packages.
TOLD = ("platform", "cpu", "simd", "threads", "started", "command", "commit")
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
AXES, TRIPLES = "uvw", ("length", "sigma", "tau")
WORDS = (
    ("Held-out", "flown on scenarios that the search never saw; the same ones for every point."),
    ("Confirmation", "default and tuned, flown once more on scenarios that had no part in the choice."),
    (
        "95 % interval",
        "bootstrap over scenarios: it covers which scenarios happened to be drawn, not errors of the model.",
    ),
    (
        "Tuned − default",
        "paired: both points meet the same scenarios, so its interval is narrower than those of the two suggest.",
    ),
    ("Better, worse", "the whole interval of the difference lies below, or above, zero; else no clear difference."),
    ("Kept, broken", "the tuned value respects the limit, or does not."),
    (
        "Front",
        "points that keep every constraint and that no other such point beats in one objective without losing another.",
    ),
    (
        "Hypervolume",
        "share of the box between zero and 1.1 times the default's values that the search's feasible front dominates.",
    ),
    ("Feasible", "no constraint and no requirement is broken."),
)


def provenance_section(results: Results) -> Markup:
    """Return the section without its heading."""
    return join(
        (
            run_facts(results),
            element(
                "div",
                folded("The air that was flown", wide(air_table(results))),
                folded("What the words mean", definitions(results)),
                folded_text("Study file as given", results.study),
                folded_text("Every value, defaults included", resolved_text(results)),
                class_="foldings",
            ),
        )
    )


def run_facts(results: Results) -> Markup:
    """Return study, seed, machine, command and versions."""
    resolved, environment = results.resolved, results.environment
    controller, search = resolved["controller"], resolved["search"]
    versions = ", ".join(f"{name} {value}" for name, value in environment.items() if name not in TOLD and value)
    facts = [
        ("Study", join((results.summary["study"], " (digest ", element("code", resolved.get("digest", MISSING)), ")"))),
        ("Seed", str(resolved["seed"])),
        ("Airframe", f"{resolved['airframe'].get('title') or resolved['airframe']['name']}"),
        ("Position law", law_title(controller["position"])),
        ("Attitude law", law_title(controller["attitude"])),
        ("Control period", _with_unit(controller.get("control_period"), "s")),
        ("Control step", _control_step(controller)),
        ("Search", _search(search)),
        ("Pick rule", results.summary["pick"]["rule"]),
        ("Flights", f"{count(results.summary['flights'])} in {duration(results.summary['wall_seconds'])}"),
        ("Command", element("code", str(environment.get("command", MISSING)))),
        ("To reproduce it", _reproduced(results)),
        ("Started", str(environment.get("started", MISSING))),
        ("Machine", _machine(environment)),
        ("Versions", versions),
    ]
    if environment.get("commit"):
        facts.append(("Commit", element("code", str(environment["commit"]))))
    return described(facts, class_="facts columns")


def air_table(results: Results) -> Markup:
    """Return the air of each scenario: airspeed, scale lengths, intensities, time constants, and trim in its mean wind."""
    rows = []
    for found in results.summary["air"]:
        entry = {**found, "trim_tilt": degrees(found["trim_tilt"])} if "trim_tilt" in found else found
        axes = [" / ".join(significant(entry.get(f"{name}_{axis}"), 3) for axis in AXES) for name in TRIPLES]
        rows.append([str(entry["scenario"]), *[_cell(entry.get(key)) for _, key, _ in AIR], *axes])
    head = ["Scenario", *[f"{name} [{unit}]" if unit else name for name, _, unit in AIR]]
    head += ["Lengths u / v / w [m]", "σ u / v / w [m/s]", "τ u / v / w [s]"]
    return table(head, rows, class_="air stacked")


def definitions(results: Results) -> Markup:
    """Return what each metric measures and what the words of the report mean."""
    metrics = {entry.metric: entry for entry in results.quantities}
    listed = join(
        element(
            "div",
            element("dt", element("code", name)),
            element("dd", coded(entry.definition), _in_unit(entry.unit)),
            id=metric_anchor(name),
        )
        for name, entry in metrics.items()
    )
    words = join(element("div", element("dt", term), element("dd", meaning)) for term, meaning in WORDS)
    return element("dl", listed, words, class_="facts")


def resolved_text(results: Results) -> str:
    """Return every value of the study, defaults included, as JSON."""
    return results.resolved.text().rstrip()


def _in_unit(unit: str) -> Markup:
    return join((" [", marked_up(unit), "]")) if unit else Markup()


def _control_step(controller: dict[str, object]) -> str:
    period, laws = controller.get("control_period"), [str(controller[loop]) for loop in ("position", "attitude")]
    return told(laws[0], laws[1], period) or MISSING if isinstance(period, (int, float)) else MISSING


def _search(search: dict[str, object]) -> str:
    size = [f"{search[key]} {noun}" for key, noun in (("generations", "generations"), ("population", "candidates each"))
            if key in search]  # fmt: skip
    return ", ".join([str(search["algorithm"]), " of ".join(size)]) if size else str(search["algorithm"])


def _machine(environment: Environment) -> str:
    names = [str(environment[key]) for key in ("cpu", "simd", "platform") if environment.get(key)]
    if environment.get("threads"):
        names.insert(1, f"{environment['threads']} threads")
    return ", ".join(names) or MISSING


def _reproduced(results: Results) -> Markup:
    """Return the commands that check this folder and that fly it once more."""
    name = shlex.quote(results.folder.name or ".")
    again, check = f"tuner run {name}/study.toml --out again", f"tuner verify {name}"
    return join(
        (element("code", again), ", or ", element("code", check), "; any number of threads gives the same bits")
    )


def _with_unit(value: object, unit: str) -> str:
    return f"{significant(value)} {unit}" if isinstance(value, (int, float)) else MISSING


def _cell(value: object) -> str:
    return significant(value, 3) if isinstance(value, (int, float)) else str(MISSING if value is None else value)
