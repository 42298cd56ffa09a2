"""Figures of a contest for a paper: all there, of the size of a page, and with the numbers of the folder in them."""

import json
from typing import Any

import numpy as np
import pytest

from plant.errors import StoreError
from tests.tables import read_frame, write_frame
from tests.tuner.extensions.contests.report.fabricate_contest import ALL, Made, answer, asked, fabricate
from tests.tuner.extensions.contests.report.reading_contest import content, front_rows, shown_rows_of
from tests.tuner.report.test_report_figures import pdf_box, png_size
from tuner.documents.opening import open_results
from tuner.extensions.contests.figures import FIGURES, published_figure
from tuner.extensions.contests.run import write_contest_figures
from tuner.report.charts.look import INKS
from tuner.report.charts.paper import style
from tuner.report.comparison import time_figures
from tuner.report.comparison.figures import differences_figure, fronts_figure
from tuner.report.comparison.signals import rate
from tuner.report.comparison.time_figures import BEYOND
from tuner.report.labels import compared_label


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return fabricate(tmp_path_factory.mktemp("figures") / "made-up", Made(names=ALL))


@pytest.fixture(scope="module")
def contest(folder):
    return open_results(folder)


def panels(figure):
    return [ax for ax in figure.axes if ax.get_visible()]


def across(line):
    """Where a line runs, as numbers."""
    return np.asarray(line.get_xdata(), dtype=float)


def up(line):
    """How high a line runs, as numbers."""
    return np.asarray(line.get_ydata(), dtype=float)


def note(figure: Any):
    """The text at the foot of a figure."""
    return figure._supxlabel.get_text()


def titled(ax: Any):
    """The title of a legend."""
    return ax.get_legend().get_title().get_text()


def lines(ax):
    """Lines of an axis by their label, those without left out."""
    return {line.get_label(): line for line in ax.get_lines() if not str(line.get_label()).startswith("_")}


OF_QUADROTORS = [name for name in FIGURES if name != "responses"]


@pytest.mark.slow
def test_every_figure_is_a_png_and_a_pdf_of_one_size(folder):
    files = write_contest_figures(folder)
    assert [file.name for file in files] == [f"{name}.{ending}" for name in OF_QUADROTORS for ending in ("png", "pdf")]
    for file in files:
        assert file.parent == folder / "figures" and file.stat().st_size > 5000
        if file.suffix == ".png":
            width, height = png_size(file)
            # 7.1 in at 200 dots/in, a single front 0.85 of that; a PDF point is 1/72 in.
            assert width == (1207 if file.stem == "front" else 1420)
            assert pdf_box(file.with_suffix(".pdf")) == pytest.approx([width * 72 / 200, height * 72 / 200], abs=0.5)


def test_same_folder_same_bytes_and_nothing_without_data(tmp_path):
    bare = ("traces.npz", "responses.npz", "wind.npz", "fronts.csv")
    folder = fabricate(tmp_path / "made-up", Made(names=ALL[:2]), without=bare, published=[])
    first = {file.name: file.read_bytes() for file in write_contest_figures(folder)}
    assert {file.name: file.read_bytes() for file in write_contest_figures(folder)} == first
    assert list(first) == ["differences.png", "differences.pdf"]


def test_unwritable_place_is_named(made):
    (made / "figures").write_text("in the way")
    with pytest.raises(StoreError, match="figures"):
        write_contest_figures(made)


SHOWN = {
    "08_position": ("gusts", ("x", "y", "z"), lambda value, reference: value),
    "09_attitude": ("level", ("roll", "pitch", "yaw"), lambda value, reference: value),
    "10_position_error": ("gusts", ("x", "y", "z"), lambda value, reference: value - reference),
    "11_attitude_error": ("level", ("roll", "pitch", "yaw"), lambda value, reference: value - reference),
}


@pytest.mark.parametrize("name", SHOWN)
def test_flight_0_of_every_contender_is_drawn_over_its_band(folder, contest, name):
    scenario, signals, shown = SHOWN[name]
    figure = FIGURES[name](contest)
    axes = panels(figure)
    assert len(axes) == 3 * len(contest.flown)
    for number, ax in enumerate(axes):
        signal, airframe = signals[number // 2], contest.flown[number % 2]
        flown = [entry.name for entry in contest.contenders if entry.airframe == airframe]
        assert list(lines(ax)) == flown and len(ax.collections) == len(flown)
        assert ax.get_ylabel().endswith("[m]" if signal in "xyz" else "[°]")
        for contender, band in zip(flown, ax.collections, strict=True):
            rows = shown_rows_of(folder, "traces.npz", contender=contender, scenario=scenario, signal=signal)
            wanted = shown(np.array(rows["value"]), np.array(rows["reference"]))
            assert up(lines(ax)[contender]) == pytest.approx(wanted)
            fan = shown_rows_of(folder, "responses.npz", point=contender, scenario=scenario, signal=signal)
            ends = [shown(np.array(fan[end]), np.array(fan["reference"])) for end in ("low", "high")]
            heights = np.asarray(band.get_paths()[0].vertices)[:, 1]
            assert (heights.min(), heights.max()) == pytest.approx((ends[0].min(), ends[1].max()))
    assert f"scenario {scenario}, flight 0; bands" in note(figure)
    assert [titled(ax) for ax in axes[:2]] == contest.flown


def test_the_reference_is_dotted_where_there_is_one(contest):
    held = panels(time_figures.positions(contest))
    assert all(len(ax.get_lines()) == len(lines(ax)) + 1 for ax in held)
    drawn = held[0].get_lines()[-1]
    time = across(drawn)
    assert up(drawn) == pytest.approx(asked("x", "gusts", time, "PID"))
    assert all(len(ax.get_lines()) == len(lines(ax)) for ax in panels(time_figures.position_errors(contest)))


def test_rates_follow_from_the_angles(contest):
    time = np.linspace(0.0, 10.0, 201)
    trace = contest.traces[0]._replace(time=time, value=np.sin(time))
    # Central differences over h: error at most h^2/6, at the ends h/2.
    assert rate(trace)[1:-1] == pytest.approx(np.cos(time)[1:-1], abs=0.05**2 / 6)
    figure = time_figures.angle_rates(contest)
    assert "by differences over 0.05 s" in note(figure)
    assert [ax.get_ylabel() for ax in panels(figure)[::2]] == [
        f"rate of {name} [°/s]" for name in ("roll", "pitch", "yaw")
    ]
    assert all(len(ax.collections) == 0 for ax in panels(figure))


def test_bands_far_wider_than_the_flight_do_not_press_it_flat(tmp_path):
    folder = fabricate(tmp_path / "made-up", Made(names=ALL[:1]))
    table = read_frame(folder / "responses.npz")
    table["high"] += 100.0
    table["low"] -= 100.0
    write_frame(folder / "responses.npz", table)
    for ax in panels(time_figures.positions(open_results(folder))):
        values = np.concatenate([up(line) for line in ax.get_lines()])
        span = values.max() - values.min()
        low, high = ax.get_ylim()
        assert values.max() < high < values.max() + 1.2 * (1.0 + BEYOND) * span
        assert values.min() > low > values.min() - 1.2 * (1.0 + BEYOND) * span


def test_what_disturbs_is_the_injection_or_else_the_wind(folder, contest):
    wind, turning = time_figures.position_disturbance(contest), time_figures.attitude_disturbance(contest)
    for figure, scenario, kind in ((wind, "gusts", "wind"), (turning, "level", "angular_acceleration")):
        for ax, axis in zip(panels(figure), "xyz", strict=True):
            air = shown_rows_of(folder, "wind.npz", scenario=scenario, signal=f"{kind}_{axis}")
            assert up(ax.get_lines()[0]) == pytest.approx(air["value"])
    assert panels(wind)[0].get_ylabel() == "wind x\n[m/s]"
    assert panels(turning)[0].get_ylabel() == "injected angular\nacceleration x\n[°/s²]"


def test_scenarios_are_chosen_by_what_they_hold(contest, tmp_path):
    assert (time_figures.held_scenario(contest), time_figures.levelled_scenario(contest)) == ("gusts", "level")
    folder = fabricate(tmp_path / "made-up")
    (folder / "study.toml").write_text("this is = not toml =")
    unknown = open_results(folder)
    assert (time_figures.held_scenario(unknown), time_figures.levelled_scenario(unknown)) == ("gusts", "gusts")


def test_errors_of_what_position_loops_ask_for_have_no_band(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    (folder / "study.toml").write_text('title = "one of many files"')
    figure = time_figures.angle_errors(open_results(folder))
    roll, _, yaw = panels(figure)
    assert len(roll.collections) == 0 and len(yaw.collections) == 3
    time = across(lines(roll)["ADRC"])
    wanted = np.degrees(answer("roll", "gusts", time, "ADRC") - asked("roll", "gusts", time, "ADRC"))
    assert up(lines(roll)["ADRC"]) == pytest.approx(wanted)


def test_contenders_differ_in_colour_line_and_mark(contest):
    for ax in panels(time_figures.positions(contest))[:2]:
        drawn: list[Any] = list(lines(ax).values())
        assert len({line.get_color() for line in drawn}) == len({line.get_marker() for line in drawn}) == len(drawn)
        assert len({str(line._unscaled_dash_pattern) for line in drawn}) == len(drawn)
        assert {line.get_color() for line in drawn} <= set(INKS.values())


@pytest.mark.parametrize("objectives", [1, 2, 3])
def test_fronts_stand_at_their_values_with_the_recommended_points_ringed(tmp_path, objectives):
    folder = fabricate(tmp_path / "made-up", Made(objectives=objectives))
    contest, rows = open_results(folder), front_rows(folder)
    with style():
        figure = fronts_figure(contest)
    axes, labels = panels(figure), content(folder)["fronts"]["objectives"]
    assert len(axes) == {1: 1, 2: 1, 3: 3}[objectives]
    assert axes[0].get_xlabel() == "position error (ITAE), worst 20 % [m]"
    containers: list[Any] = axes[0].containers
    for name, container in zip(contest.index, containers, strict=True):
        mine = [row for row in rows if row["contender"] == name]
        assert container.lines[0].get_xdata() == pytest.approx([float(row[f"value:{labels[0]}"]) for row in mine])
        for axis, bars in enumerate(container.lines[2]):
            ends = [[float(row[f"{end}:{labels[axis]}"]) for end in ("low", "high")] for row in mine]
            assert [part[:, axis].tolist() for part in bars.get_segments()] == [pytest.approx(pair) for pair in ends]
    rings = [line for line in axes[0].get_lines() if line.get_markersize() == 9 and len(across(line))]
    chosen = [float(row[f"value:{labels[0]}"]) for row in rows if row["recommended"] == "True"]
    assert [across(line)[0] for line in rings] == pytest.approx(chosen)


def test_printed_numbers_stand_where_they_are(folder, contest):
    axes, told = panels(published_figure(contest)), content(folder)["published"]
    for ax, metric in zip(axes, ("peak.roll", "settling.yaw"), strict=True):
        cells = [cell for cell in told if cell["metric"] == metric]
        pins = [line for line in ax.get_lines() if line.get_marker() == "v" and len(across(line))]
        assert [across(line)[0] for line in pins] == pytest.approx([cell["value"] for cell in cells])
        assert [line.get_markerfacecolor() != "white" for line in pins] == [cell["inside"] for cell in cells]
        bars = [across(line) for line in ax.get_lines() if len(across(line)) == 2]
        assert [list(bar) for bar in bars] == [pytest.approx([cell["p2_5"], cell["p97_5"]]) for cell in cells]
        assert [text.get_text().endswith("*") for text in ax.texts] == [cell["fitted"] for cell in cells]
    assert [label.get_text() for label in axes[0].get_yticklabels()] == list(contest.index)


def test_differences_stand_where_they_are(folder, contest):
    axes, told = panels(differences_figure(contest)), content(folder)["differences"]
    labels = list(dict.fromkeys(d["quantity"] for d in told if d["quantity"] != "mean(failure)"))
    laws = {entry.name: entry.laws for entry in contest.contenders}
    airframes = {entry.name: entry.airframe for entry in contest.contenders}
    assert len(axes) == len(labels)
    for ax, label in zip(axes, labels, strict=True):
        pairs = [
            d
            for d in told
            if d["quantity"] == label
            and (airframes[d["first"]] == airframes[d["second"]] or laws[d["first"]] == laws[d["second"]])
        ]
        marks = [line for line in ax.get_lines() if line.get_marker() == "D"]
        assert [across(line)[0] for line in marks] == pytest.approx([d["difference"] for d in pairs])
        assert [line.get_markerfacecolor() == "white" for line in marks] == [d["lower"] is None for d in pairs]
        assert ax.get_xlabel().startswith(
            compared_label(contest, label).removesuffix(f", {contest.quantity[label].scenario}")
        )
    names = [text.get_text() for text in axes[0].get_yticklabels()]
    assert names[0] == "ADRC − PID" and "ADRC (other) − PID" not in names


def test_hostile_names_are_only_text(tmp_path):
    made = Made(names=ALL[:2], tuned=False)
    folder = fabricate(tmp_path / "made-up", made, without=("traces.npz", "responses.npz", "wind.npz"))
    # matplotlib takes what stands between dollar signs for mathematics, and refuses what it does not understand.
    hostile = json.dumps("$\\frac$ ../<b>&$_$")
    text = (folder / "contest.json").read_text(encoding="utf-8")
    text = text.replace('"PID"', hostile).replace(': "level"', f": {hostile}")
    (folder / "contest.json").write_text(text, encoding="utf-8")
    assert [file.name for file in write_contest_figures(folder)][::2] == ["differences.png", "published.png"]
