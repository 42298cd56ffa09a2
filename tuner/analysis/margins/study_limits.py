"""A controller judged by the [[margin]] tables of a study."""

import numpy as np

from plant.errors import InputError
from tuner.analysis.margins.document import limited_row
from tuner.analysis.margins.limits import Limit
from tuner.documents.margins import LimitRow
from tuner.gains import Controller
from tuner.study.margins import MarginAnalysis, margin_requirement
from tuner.study.study import Study


def study_requirements(study: Study, controller: Controller) -> list[LimitRow] | None:
    """Return how gains stand to the [[margin]] tables of a study, on the study's vehicle; None where it has none.

    Raises InputError where the study is about other laws.
    """
    for loop in ("position", "attitude"):
        mine, its = (getattr(cascade, loop).name for cascade in (controller.cascade, study.system.cascade))
        if mine != its:
            raise InputError(
                f"the gains are for the {loop} law '{mine}', the study flies '{its}'", file=study.path, key="controller"
            )
    if not study.table.margin:
        return None
    specs = tuple(entry.spec for entry in study.scenarios)
    asked = tuple(margin_requirement(table, study.system.timing, specs) for table in study.table.margin)
    values = MarginAnalysis(asked, study.system, specs, study.path).values(np.array([controller.gains]))[0]
    return [
        limited_row(
            entry.label, entry.quantity, float(entry.quantity.from_limit(value)),
            Limit(entry.quantity.name, entry.quantity.sense, entry.limit), entry.hard,
        )
        for entry, value in zip(asked, values, strict=True)
    ]  # fmt: skip
