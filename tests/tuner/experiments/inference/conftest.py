"""A synthetic paper, and how to infer from it."""

from contextlib import nullcontext
from unittest.mock import patch

import pytest

from plant.quadrotor.scenarios import HELD_OUT
from tests.tuner.experiments.inference.asked import synthetic_paper, write
from tests.tuner.study.loading import load_inference
from tuner.experiments.inference.run import InferenceRun
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder

SMALL = {"search.population": 8, "search.generations": 2, "inference.flights": 8, "inference.held_out": 40}


def run(folder, text, threads=2, changes=None, figures=False):
    folder.mkdir()
    asked = load_inference(write(folder, text), changes)
    with nullcontext() if figures else patch("tuner.report.inference_figure.write_inference_figures"):
        return InferenceRun(
            asked, Folder.create(folder / "out"), Watcher(), threads=threads
        ).carry_out(), folder / "out"


@pytest.fixture(scope="session")
def paper():
    return synthetic_paper(HELD_OUT)
