"""Figures for a paper: there, readable, of the size of a page, and the same bytes twice."""

import struct
from types import SimpleNamespace

import numpy as np
import pytest

from objectives.system import SIGNALS
from plant.errors import InputError, StoreError
from tests.tuner.report.fabricate import fabricate
from tuner.documents.tuning import TuningFolder
from tuner.report import write_figures
from tuner.report.figures import front_figure, write_responses
from tuner.report.sheets import fans_of, scenario_names


def png_size(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and data[-8:-4] == b"IEND"
    return struct.unpack(">II", data[16:24])


def pdf_box(path):
    data = path.read_bytes()
    assert data.startswith(b"%PDF-") and data.rstrip().endswith(b"%%EOF")
    box = data.split(b"/MediaBox [")[1].split(b"]")[0]
    return [float(number) for number in box.split()][2:]


def test_every_figure_is_a_png_and_a_pdf_of_one_size(tmp_path):
    files = write_figures(fabricate(tmp_path / "made-up", objectives=3))
    assert sorted(file.name for file in files) == [
        f"{name}.{ending}" for name in ("front", "progress", "responses") for ending in ("pdf", "png")
    ]
    for file in files:
        assert file.parent == tmp_path / "made-up" / "figures"
        if file.suffix == ".png":
            width, height = png_size(file)
            # 7.1 in at 200 dots/in; a PDF point is 1/72 in.
            assert width == 1420
            assert pdf_box(file.with_suffix(".pdf")) == pytest.approx([width * 72 / 200, height * 72 / 200], abs=0.5)


def test_same_folder_same_bytes(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=1, responses=False)
    first = {file.name: file.read_bytes() for file in write_figures(folder)}
    assert {file.name: file.read_bytes() for file in write_figures(folder)} == first
    assert "responses.png" not in first


@pytest.mark.parametrize(("objectives", "panels"), [(1, 1), (2, 1), (3, 3), (4, 6)])
def test_front_has_a_panel_for_each_pair_with_units(tmp_path, objectives, panels):
    results = TuningFolder(fabricate(tmp_path / "made-up", objectives=objectives, responses=False))
    axes = [ax for ax in front_figure(results).axes if ax.get_visible()]
    assert len(axes) == panels
    labels = [ax.get_xlabel() for ax in axes] + [ax.get_ylabel() for ax in axes]
    assert "position error (ITAE), worst 10 % [m]" in labels
    if objectives > 2:
        assert "tilt RMS error [°]" in labels


def test_names_of_responses_are_safe_and_unique():
    assert scenario_names("responses", ["../gusts"]) == {"responses": "../gusts"}
    named = scenario_names("spectrum", ["a b", "a/b", "a b", "µ"])
    assert named == {"spectrum-a-b": "a b", "spectrum-a-b-1": "a/b", "spectrum-2": "µ"}


def test_unwritable_place_is_named(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=1, responses=False)
    (folder / "figures").write_text("in the way")
    with pytest.raises(StoreError, match="figures"):
        write_figures(folder)


@pytest.fixture
def responses():
    """Responses as of `tuner.analysis.responses.responses_of`, of three flights: signal i of flight f is constant at i + f."""
    actual = np.arange(10.0) + np.arange(3.0)[:, None, None] + np.zeros((3, 50, 10))
    quantiles = SimpleNamespace(
        time=np.arange(50) * 0.02,
        actual=actual,
        reference=np.full_like(actual, 2.0),
        fans=lambda: np.quantile(actual, (0.05, 0.5, 0.95), axis=0),
        signals=tuple(SIGNALS),
        units=tuple(SIGNALS.values()),
    )
    return quantiles


def test_flown_responses_are_in_degrees(responses):
    fans = {fan.signal: fan for fan in fans_of(responses, "gusts")}
    # Yaw is signal 5: median 5 + 1, in rad inside.
    assert fans["yaw"].unit == "°" and fans["yaw"].median == pytest.approx(np.full(50, np.degrees(6.0)))
    assert fans["z"].unit == "m" and fans["z"].median == pytest.approx(np.full(50, 3.0))


def test_flown_responses_go_to_the_file_asked_for(responses, tmp_path):
    write_responses(responses, "gusts", tmp_path / "flown.png")
    assert png_size(tmp_path / "flown.png")[0] == 1420
    with pytest.raises(InputError, match="allowed endings"):
        write_responses(responses, "gusts", tmp_path / "flown.doc")
    with pytest.raises(InputError, match="cannot be written"):
        write_responses(responses, "gusts", tmp_path / "nowhere" / "flown.png")
