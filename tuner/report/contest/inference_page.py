"""report.html of an inference: what its open values must have been, and which printed numbers nothing reproduces."""

from pathlib import Path
from string import Template
from typing import Any

from tuner.documents.inference import Inference, load_inference
from tuner.report.contest.inference_section import cells_table, misfits_table, ratios_table, unknowns_table
from tuner.report.contest.provenance import environment_facts
from tuner.report.page import asset, page_section, put_page
from tuner.report.prose import counted, listing
from tuner.store.document import read_text
from tuner.store.environment import Environment
from tuner.text.markup import Markup, described, element, join, safe
from tuner.text.numbers import count, duration, per_cent, significant

AIDS = {
    "cells": "Printed numbers against held-out flights at the inferred setting: median with the central 95 % of flights. "
    "A number is reproduced where it lies inside these; before: the same with the values that the study started from.",
    "unknowns": "Diamond: inferred; square: before; thick bar: what fits about as well; thin bar: how far the printed numbers, "
    "being one draw, tell the value (68 %).",
    "ratios": "Two contenders in the same air: what one printed number over another asks of a single flight.",
    "misfits": "The factor by which our medians typically miss the printed numbers. The other settings are those that no "
    "setting beats in every kind of number at once.",
}


def write_inference_page(folder: Path) -> Path:
    """Write report.html into a folder with an inference; StoreError where a file is missing or damaged."""
    inference = load_inference(folder / "inference.json")
    environment = Environment.read(folder / "environment.json")
    study = read_text(folder / "study.toml")
    return put_page(folder, page(inference, environment, study))


def inference_parts(inference: Inference) -> list[tuple[str, str, Markup]]:
    """Return the sections of an inference: key, heading, content; those without content are left out."""
    parts = [
        ("cells", "Printed numbers, reproduced or not", cells_table(inference)),
        ("unknowns", "Open values", unknowns_table(inference)),
        ("ratios", "Ratios between contenders", ratios_table(inference)),
        ("misfits", "Misfit", misfits_table(inference)),
    ]
    return [
        (key, name, join((element("p", AIDS[key], class_="aid"), element("div", content, class_="wide"))))
        for key, name, content in parts
        if content
    ]


def page(inference: Inference, environment: dict[str, Any], study: str) -> str:
    """Return the page of an inference; it has no figures that need a script."""
    document = inference.document
    parts = [*inference_parts(inference), ("provenance", "Provenance", _provenance(inference, environment, study))]
    description = document.get("description")
    words = element("ul", *[element("li", sentence) for sentence in inference.words], class_="words")
    return Template(asset("page.html")).substitute(
        kind="inference report",
        title=safe(document["title"]),
        ending=Markup(),
        description=element("p", str(description)) if description else "",
        paragraph=safe(_asked(inference)),
        figures=join((words, described(_key_figures(inference), class_="figures"))),
        warnings="",
        navigation=join(element("li", element("a", name, href=f"#{key}")) for key, name, _ in parts),
        sections=join(page_section(*part) for part in parts),
        data="{}",
        style="\n".join((asset("page.css"), asset("contest/contest.css"))),
        script="",
        plotly="",
    )


def _asked(inference: Inference) -> str:
    cells, unknowns = len(inference.cells), len(inference.unknowns)
    return (
        f"{counted(unknowns, 'open value').capitalize()} were searched so that {listing(inference.contenders)} meet "
        f"{counted(cells, 'printed number')}. Angles are in rad throughout, as in printed numbers and in study files."
    )


def _key_figures(inference: Inference) -> list[tuple[str, str]]:
    default, inferred = inference.misfits[:2]
    cells = len(inference.cells)
    never = sum(cell.by == "nowhere" for cell in inference.cells)
    return [
        ("Numbers inside, inferred", f"{inferred.inside} of {cells}"),
        ("Numbers inside, before", f"{default.inside} of {cells}"),
        ("Inside under no setting", count(never)),
        ("Settings tried", count(inference.document["settings"]["tried"])),
        ("Flights", count(inference.document["flights"])),
        ("Wall time", duration(inference.document["wall_seconds"])),
    ]


def _provenance(inference: Inference, environment: dict[str, Any], study: str) -> Markup:
    document, settings = inference.document, inference.document["settings"]
    facts = [
        ("Study", str(document.get("study", ""))),
        ("Seed", significant(document["seed"], 15)),
        ("Flights of a setting", f"{count(settings['flights'])} of each contender and scenario, {count(settings['held_out'])} "
         "held out"),
        ("Fits about as well", f"misfit within {per_cent(settings['near'])} of the least"),
        *environment_facts(environment),
    ]  # fmt: skip
    text = element("details", element("summary", "Study file as given"), element("pre", study, tabindex="0"))
    return join((described(facts, class_="facts"), text))
