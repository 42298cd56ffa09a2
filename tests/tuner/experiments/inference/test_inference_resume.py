"""An inference that was stopped goes on where it was and ends in the same bits."""

import json

import pytest

import tuner.report.inference_figure
from tests.tuner.experiments.inference.asked import STUDY, published_medians, write
from tests.tuner.experiments.inference.conftest import SMALL
from tests.tuner.study.loading import load_inference
from tuner.experiments.again.resume import reopen
from tuner.experiments.inference.run import InferenceRun
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder

TIMES = ("wall_seconds", "seconds")


class Listener(Watcher):
    def __init__(self):
        self.told = []

    def on_warning(self, text):
        self.told.append(text)


def results(folder):
    settings = {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
        and file.suffix in (".npz", ".toml", ".json")
        and file.name not in ("environment.json", "manifest.json")
    }
    document = json.loads(settings.pop("inference.json"))
    return settings, {key: value for key, value in document.items() if key not in TIMES}


@pytest.fixture
def without_figures(monkeypatch):
    monkeypatch.setattr(tuner.report.inference_figure, "write_inference_figures", lambda folder: None)


def test_a_damaged_generation_is_flown_again_and_nothing_else(paper, tmp_path, without_figures, monkeypatch):
    asked = load_inference(write(tmp_path, STUDY + published_medians(paper)), SMALL)
    InferenceRun(asked, Folder.create(tmp_path / "out"), Watcher(), threads=2).carry_out()
    expected = results(tmp_path / "out")
    flights = sorted((tmp_path / "out" / "flights").glob("search-*.npz"))
    assert len(flights) > 2
    content = bytearray(flights[1].read_bytes())
    content[100] ^= 1
    flights[1].write_bytes(content)
    made = []
    from tuner.experiments.inference.flying import SettingFlyer

    original = SettingFlyer._fly_missing
    monkeypatch.setattr(
        SettingFlyer,
        "_fly_missing",
        lambda self, values, *rest: made.append(len(values)) or original(self, values, *rest),
    )
    inference, folder = reopen(tmp_path / "out", None)
    listener = Listener()
    InferenceRun(inference, folder, listener, threads=1).carry_out()
    assert sum(made) == 8 and len(listener.told) == 1 and flights[1].name in listener.told[0]
    flights[1].with_suffix(".damaged").unlink()
    assert results(tmp_path / "out") == expected
