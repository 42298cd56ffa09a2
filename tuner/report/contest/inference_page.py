"""report.html of an inference: what its open values must have been, and which printed numbers nothing reproduces."""

from tuner.documents.inference_document import InferenceDocument
from tuner.report.contest.inference_section import cells_table, misfits_table, ratios_table, unknowns_table
from tuner.report.page import Page, Section, aid, collapsible_text, wide
from tuner.report.provenance import environment_facts
from tuner.store.environment import Environment
from tuner.text.markup import Markup, described, element, join
from tuner.text.numbers import count, duration, per_cent, significant
from tuner.text.sentences import counted, listing

AIDS = {
    "cells": "Printed numbers against held-out flights at the inferred setting: median with the central 95 % of flights. "
    "A number is reproduced where it lies inside these; before: the same with the values that the study started from.",
    "unknowns": "Diamond: inferred; square: before; thick bar: values that fit about as well; thin bar: 68 % interval, as the "
    "printed numbers are one draw.",
    "ratios": "Two contenders in the same air: ratio of two printed numbers against that of single flights.",
    "misfits": "The factor by which our medians typically miss the printed numbers. The other settings are those that no "
    "setting beats in every kind of number at once.",
}


def inference_parts(inference: InferenceDocument) -> list[Section]:
    """Return the sections of an inference; those without content are left out."""
    parts = (
        ("cells", "Printed numbers, reproduced or not", cells_table(inference)),
        ("unknowns", "Open values", unknowns_table(inference)),
        ("ratios", "Ratios between contenders", ratios_table(inference)),
        ("misfits", "Misfit", misfits_table(inference)),
    )
    return [Section(key, name, join((aid(AIDS[key]), wide(content)))) for key, name, content in parts if content]


def inference_page(inference: InferenceDocument, environment: Environment, study: str) -> Page:
    """Return the page of an inference, given in shown units; it has no charts that need a script."""
    words = element("ul", *[element("li", sentence) for sentence in inference.words], class_="words")
    provenance = Section("provenance", "Provenance", _provenance(inference, environment, study))
    return Page(
        kind="inference report",
        title=inference.title,
        lead=join(
            (
                element("p", _answer(inference), class_="answer"),
                element("p", _lead(inference), class_="lead"),
                element("p", inference.description, class_="aid") if inference.description else "",
                words,
            )
        ),
        opening=described(_key_figures(inference), class_="figures"),
        sections=[*inference_parts(inference), provenance],
        data={},
    )


def _answer(inference: InferenceDocument) -> str:
    cells, inferred, before = len(inference.cells), inference.misfit.inferred.inside, inference.misfit.default.inside
    never = sum(cell.by == "nowhere" for cell in inference.cells)
    lacking = (
        f" {counted(never, 'number').capitalize()} {'is' if never == 1 else 'are'} reproduced by no setting tried."
    )
    return f"The inferred values reproduce {inferred} of {cells} printed numbers (before: {before}).{lacking if never else ''}"


def _lead(inference: InferenceDocument) -> str:
    cells, unknowns = len(inference.cells), len(inference.unknowns)
    return (
        f"{counted(unknowns, 'open value').capitalize()} were searched so that {listing(inference.contenders)} meet "
        f"{counted(cells, 'printed number')}. Angles are in degrees."
    )


def _key_figures(inference: InferenceDocument) -> list[tuple[str, str]]:
    return [
        ("Settings tried", count(inference.settings.tried)),
        ("Flights", count(inference.flights)),
        ("Wall time", duration(inference.wall_seconds)),
    ]


def _provenance(inference: InferenceDocument, environment: Environment, study: str) -> Markup:
    settings = inference.settings
    facts = [
        ("Study", inference.study),
        ("Seed", significant(inference.seed, 15)),
        (
            "Flights of a setting",
            f"{count(settings.flights)} of each contender and scenario, {count(settings.held_out)} held out",
        ),
        ("Fits about as well", f"misfit within {per_cent(settings.near)} of the least"),
        *environment_facts(environment),
    ]
    return join((described(facts, class_="facts columns"), collapsible_text("Study file", study)))
