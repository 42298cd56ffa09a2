"""Limits on rare losses in the page: their probabilities, the curves, and how to fly the most likely lost flight."""

import shlex

from plant.input_files import read_input_text
from plant.texts import toml_table
from tuner.documents.tail import LimitedTail
from tuner.documents.tuning import DEFAULT, TUNED, TuningFolder
from tuner.extensions.tails.panels import limited_panels
from tuner.extensions.tails.words import counted_line, event_line, mode_line
from tuner.report.charts.look import legend, role_look
from tuner.report.charts.web import grid
from tuner.report.page import aid
from tuner.store.inputs import read_record
from tuner.study.own_code import code_named
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import per_cent

AID = (
    "Lines: probability that a flight reaches a demand over capacity (1: the loss); bands: {confidence} intervals. At 1: "
    "share of the confirmation flights that were lost, or its upper bound (triangle) where none was. Dashed: the limit."
)
POINT_AID = "The first command repeats the estimate and seeks the most likely lost flight, the second one flies it."


def tail_section(results: TuningFolder) -> Markup:
    """Return the limits on rare losses under a heading; nothing where the study has none."""
    tails = [tail for row in results.document.compared for tail in row.tails]
    if not tails:
        return Markup()
    lines = [line for tail in tails for line in _lines(tail, results.shown_as)]
    looks = [(DEFAULT, role_look(DEFAULT)), (results.shown_as, role_look(TUNED))]
    commands = [command for tail in tails if tail.tuned.probability > 0.0 for command in _commands(results, tail)]
    return join(
        (
            element("h3", "Rare losses"),
            element("ul", *[element("li", line) for line in lines], class_="notes"),
            aid(AID.format(confidence=per_cent(tails[0].confidence))),
            legend(looks),
            grid(limited_panels(results), "axis-grid"),
            *([aid(POINT_AID)] if commands else []),
            *[element("pre", element("code", command)) for command in commands],
        )
    )


def _lines(tail: LimitedTail, shown_as: str) -> list[str]:
    """Return the lines of the point shown and of the default."""
    modes = [mode_line(mode) for mode in tail.tuned.modes if mode.probability.value > 0.0]
    tuned = "; ".join([event_line(tail.tuned, tail.smallest), *modes])
    return [f"{tail.scenario}, {shown_as}, {tuned}", f"{tail.scenario}, default, {counted_line(tail.default)}"]


def _commands(results: TuningFolder, tail: LimitedTail) -> list[str]:
    """Return the commands that seek a design point and fly it."""
    folder, study = shlex.quote(results.home.name or "."), read_record(results.home).study
    file = results.home / study
    scenarios = enumerate(results.resolved.scenario)
    number = next((i for i, entry in scenarios if entry.get("name") == tail.scenario), 0)
    out = f"tail-{number}" if number else "tail"
    code = [f"--code {folder}/inputs/{name}" for name in code_named(toml_table(read_input_text(file), file))]
    of_flight = [f"--study {folder}/{study}", *([f"--scenario {number}"] if number else []), *code]
    gains = " ".join([f"{folder}/{results.document.gains_file}", *of_flight])
    return [
        f"tuner tail {gains} --event {tail.tuned.event} --to {tail.smallest:g} --width {tail.width:g} --out {out}",
        f"tuner fly {gains} --flight {out}/point-1 --plot {out}/point-1.png",
    ]
