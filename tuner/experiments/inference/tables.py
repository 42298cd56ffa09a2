"""Tables of an inference's folder (generations/NNNN.npz, candidates.npz) and the study with inferred values."""

import os
from copy import deepcopy

import numpy as np

from tuner.experiments.inference.findings import Findings
from tuner.experiments.inference.misfit import EvaluatedSettings
from tuner.store.columns import Columns
from tuner.store.folder import Folder
from tuner.study.contest_schema import INFERENCE_TABLES
from tuner.study.inference import Inference
from tuner.study.unknown_paths import put_at
from tuner.text.toml_text import with_paths


def settings_table(inference: Inference, settings: EvaluatedSettings, first: int) -> Columns:
    """Return settings as a table, a row for each; first: number of the first of them.

    candidate; origin: number of the generation, -1 for those flown around the best; unknown:NAME; misfit:KIND and misfit
    (over all kinds); median:CELL and percentile:CELL of the published value among the flights; inside: number of cells
    inside; failures.
    """
    columns: Columns = {"candidate": first + np.arange(len(settings.values)), "origin": settings.origin}
    columns |= {f"unknown:{u.variable.name}": settings.values[:, i] for i, u in enumerate(inference.unknowns)}
    misfits = settings.misfits(inference)
    columns |= {f"misfit:{kind.name}": misfits[:, i] for i, kind in enumerate(inference.kinds)}
    columns |= {"misfit": settings.overall(inference)}
    columns |= {f"median:{cell.label}": settings.median[:, i] for i, cell in enumerate(inference.cells)}
    columns |= {f"percentile:{cell.label}": settings.percentile[:, i] for i, cell in enumerate(inference.cells)}
    columns |= {"inside": settings.inside.sum(axis=1), "failures": settings.failures.mean(axis=1)}
    return columns


def candidates_table(findings: Findings) -> Columns:
    """Return all settings that were flown; role: "default", "inferred" or nothing; front: whether it was checked."""
    table = settings_table(findings.inference, findings.settings, 0)
    candidate = table.pop("candidate")
    roles = np.full(len(candidate), "", dtype=object)
    roles[0], roles[findings.chosen] = "default", "inferred"
    return {"candidate": candidate, "role": roles, "front": np.isin(np.arange(len(roles)), findings.shown), **table}


def with_values(inference: Inference, values: np.ndarray, folder: Folder) -> Columns:
    """Return the contest's content with values of the unknowns: paths relative to the folder."""
    table = deepcopy(inference.table)
    for unknown, value in zip(inference.unknowns, values, strict=True):
        for place in unknown.places:
            put_at(table, place, float(value))
    for key in INFERENCE_TABLES:
        table.pop(key, None)
    home, base_path = inference.path.parent.resolve(), folder.path.resolve()
    return with_paths(table, lambda name: os.path.relpath(home / name, base_path))
