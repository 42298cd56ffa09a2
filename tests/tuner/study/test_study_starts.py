"""`search.starts`: points of earlier runs, matched gain by gain, and a study that keeps them when the runs are gone."""

import csv
import json
import shutil
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from plant.law_registry import law
from plant.texts import PlainTable
from tests.tuner.conftest import QUICKSTART, SMALL
from tests.tuner.extensions.contests.experiments.contest_text import CONTEST
from tests.tuner.extensions.trials.bench import BOWLS, TITLE, bowls
from tests.tuner.study.loading import load_contest
from tests.tuner.study.study_text import STUDY, changed, write
from tuner.study.build import load_study
from tuner.study.earlier_front import FrontTable
from tuner.study.kinds import load_any, load_gains_study
from tuner.study.shipped_fronts import shipped_fronts
from tuner.study.starts import MAX_POINTS, spread_order
from tuner.text.toml_text import toml_text, with_paths

ANGLE = QUICKSTART.parent / "dc_motor.toml"


@pytest.fixture
def earlier(small_run, tmp_path):
    """A results folder to be spoilt."""
    return shutil.copytree(small_run[1], tmp_path / "earlier", ignore=shutil.ignore_patterns("flights", "figures"))


def starting(*starts, **changes):
    return load_study(QUICKSTART, {**SMALL, **changes, "search.starts": [str(start) for start in starts]})


def front_of(folder):
    with open(folder / "front.csv", newline="") as file:
        return [row for row in csv.DictReader(file) if row["role"] != "default"]


def write_gains(study, folder, row=None):
    file = folder / "gains.json"
    file.write_text(json.dumps(study.gains_document(study.default_row if row is None else row, {})))
    return file


def test_every_point_of_the_front_is_taken_by_variable(earlier):
    (found,) = starting(earlier).search.starts
    wanted = [
        {name[5:]: float(value) for name, value in row.items() if name[:5] == "gain:"} for row in front_of(earlier)
    ]
    assert len(found.points) == len(wanted) and all(point in wanted for point in map(dict, found.points))


def test_points_come_in_the_order_of_what_they_add():
    values = np.array([[0.2, 0.8], [0.5, 0.5], [0.8, 0.2], [0.49, 0.53], [0.52, 0.48]])
    front = FrontTable((("a",),), np.zeros((5, 1)), values, np.array([1.0, 1.0]))
    order = spread_order(front).tolist()
    assert sorted(order) == [0, 1, 2, 3, 4] and sorted(order[:3]) == [0, 1, 2]


def test_of_a_large_front_so_many_points_are_kept():
    x = np.linspace(0.1, 0.9, 3 * MAX_POINTS)
    values = np.stack([x, 1.0 - x], axis=1)
    order = spread_order(FrontTable((("a",),), np.zeros((len(x), 1)), values, np.array([1.0, 1.0])))
    assert len(order) == len(set(order.tolist())) == MAX_POINTS


def test_a_run_that_recommended_nothing_is_a_start_too(earlier):
    points = starting(earlier).search.starts[0].points
    (earlier / "gains.json").rename(earlier / "infeasible.json")
    assert starting(earlier).search.starts[0].points == points


def test_gains_of_a_file_are_one_point(tmp_path):
    study = load_study(QUICKSTART, SMALL)
    row = np.array(study.default_row)
    row[[gain.address == "roll.k2" for gain in study.system.gains].index(True)] = 7.0
    found = starting(write_gains(study, tmp_path, row))
    assert len(found.search.starts[0].points) == 1
    values = found.space.values(found.search.starts[0].units(found.space))[0]
    assert values[[each.name for each in found.space.variables].index("attitude.k2")] == pytest.approx(7.0, rel=1e-12)
    assert found.start_texts == [f"The search starts from {tmp_path / 'gains.json'} (1 point)."]


def test_a_path_is_found_from_the_study_and_from_the_working_directory(earlier, tmp_path, monkeypatch):
    beside = tmp_path / "study" / "quickstart.toml"
    beside.parent.mkdir()
    shutil.copy(QUICKSTART, beside)
    points = starting(earlier).search.starts[0].points
    assert load_study(beside, {**SMALL, "search.starts": ["../earlier"]}).search.starts[0].points == points
    monkeypatch.chdir(tmp_path)
    assert load_study(QUICKSTART, {**SMALL, "search.starts": ["earlier"]}).search.starts[0].points == points


def test_what_leaves_the_ranges_is_clipped_and_counted(earlier):
    values = [float(row["gain:attitude.lambda"]) for row in front_of(earlier)]
    high = 0.5 * (min(values) + max(values))
    study = starting(earlier, **{"gains.attitude.lambda": {"low": 0.5, "high": high}})
    column = [each.name for each in study.space.variables].index("attitude.lambda")
    beyond = sum(value > high for value in values)
    assert np.sum(study.search.starts[0].units(study.space)[:, column] == 1.0) == beyond > 0
    assert (
        study.start_texts[1] == f"{beyond} of these points are clipped into the ranges of the study: attitude.lambda."
    )


def test_a_gain_that_was_not_searched_starts_at_its_default(earlier):
    study = starting(earlier, **{"gains.attitude.delta": {}})
    column = [each.name for each in study.space.variables].index("attitude.delta")
    default = study.space.point(study.default_row)[column]
    assert np.all(study.search.starts[0].units(study.space)[:, column] == default)
    assert study.start_texts[1] == f"{earlier} says nothing of attitude.delta, which there starts at the default."


def test_one_law_in_common_is_enough(earlier):
    others = {"position.kp": {}, "position.kd": {}}
    kept = {"attitude.lambda": {}, "attitude.k2": {}}
    study = starting(earlier, **{"controller.position": "pid", "gains": {**kept, **others}})
    assert all(set(point) == set(kept) for point in study.search.starts[0].points)
    assert "says nothing of position.kp and position.kd" in study.start_texts[1]


def test_other_laws_are_refused(earlier):
    with pytest.raises(InputError) as refused:
        starting(earlier, **{"controller.position": "pid", "controller.attitude": "pid", "gains": {"attitude.kp": {}}})
    assert refused.value.key == "search.starts[0]"
    assert "its laws are hybrid (attitude) and ladrc (position), those of this study pid (attitude) and pid" in str(
        refused.value
    )


def test_none_of_the_searched_gains_is_refused(earlier):
    with pytest.raises(InputError, match=r"it searched none of the gains of this study \(attitude.delta\)"):
        starting(earlier, gains={"attitude.delta": {}})


def damage_front(folder, change):
    lines = (folder / "front.csv").read_text().splitlines()
    (folder / "front.csv").write_text("\n".join(change(lines)) + "\n")


DAMAGED = [
    (lambda folder: (folder / "gains.json").unlink(), "holds no gains.json: it is no folder of a finished tuning run"),
    (lambda folder: (folder / "front.csv").unlink(), "front.csv: there is no such file"),
    (lambda folder: damage_front(folder, lambda lines: lines[:2]), "holds no point besides the default"),
    (
        lambda folder: damage_front(folder, lambda lines: [lines[0].replace("gain:", "g:"), *lines[1:]]),
        "is damaged, or of another",
    ),
    (
        lambda folder: damage_front(folder, lambda lines: [line.replace("True,1", "True", 1) for line in lines]),
        "is damaged",
    ),
    (
        lambda folder: damage_front(folder, lambda lines: [*lines, lines[-1].replace(".", "x")]),
        "is damaged: could not convert",
    ),
    (lambda folder: damage_front(folder, lambda lines: [*lines, lines[-1].replace("0.", "nan", 3)]), "is damaged"),
    (lambda folder: (folder / "resolved.json").write_text("{"), "resolved.json"),
    (lambda folder: (folder / "resolved.json").write_text("{}"), "it lists no searched gains"),
    (lambda folder: (folder / "gains.json").write_text("{}"), "this must be 'gainproof-gains'"),
]


@pytest.mark.parametrize(("spoil", "message"), DAMAGED)
def test_a_damaged_folder_is_refused_in_a_sentence(earlier, spoil, message):
    spoil(earlier)
    with pytest.raises(InputError) as refused:
        starting(earlier)
    assert message in str(refused.value) and str(refused.value).startswith(f"{QUICKSTART}: search.starts[0]: ")
    assert "\n" not in str(refused.value)


GIVEN = [
    ("nowhere", "search.starts[0]", "there is no results folder or gains.json nowhere"),
    (3, "search.starts[0]", "a path in quotes, or a table"),
    ({"points": []}, "search.starts[0].points", "given no point"),
    ({"points": [{}]}, "search.starts[0].points", "given no point"),
    (
        {"points": [{"attitude.lambada": 3.0}]},
        "search.starts[0].points[0].attitude.lambada",
        "did you mean 'attitude.lambda'",
    ),
    ({"points": [{"attitude.lambda": "3"}]}, "search.starts[0].points[0].attitude.lambda", "a number"),
    ({"points": [{"attitude.lambda": float("nan")}]}, "search.starts[0].points[0].attitude.lambda", "finite"),
    ({"point": []}, "search.starts[0].point", "did you mean 'points'"),
]


@pytest.mark.parametrize(("given", "key", "message"), GIVEN)
def test_an_entry_that_is_no_start_is_refused(given, key, message):
    with pytest.raises(InputError) as refused:
        load_study(QUICKSTART, {"search.starts": [given]})
    assert refused.value.key == key and message in str(refused.value)


def test_points_may_be_given_by_themselves():
    points = [{"attitude.lambda": 4.0}, {"attitude.lambda": 6, "position.zeta": 1.5}]
    study = load_study(QUICKSTART, {"search.starts": [{"points": points}]})
    rows = study.space.values(study.search.starts[0].units(study.space))
    names = [each.name for each in study.space.variables]
    assert rows[:, names.index("attitude.lambda")] == pytest.approx([4.0, 6.0])
    assert rows[:, names.index("position.zeta")] == pytest.approx([1.0, 1.5])
    assert study.start_texts[0] == "The search starts from the study (2 points)."


def test_the_study_keeps_the_points_when_the_folder_is_gone(earlier, tmp_path):
    study = starting(earlier)
    kept = tmp_path / "elsewhere" / "kept.toml"
    kept.parent.mkdir()
    kept.write_text(toml_text(study.content))
    shutil.rmtree(earlier)
    again = load_study(kept)
    assert again.digest() == study.digest() and again.search.starts == study.search.starts
    assert again.start_texts == study.start_texts and again.resolved()["search"] == study.resolved()["search"]


def test_searches_with_the_same_starts_are_the_same_search(earlier):
    search, again = starting(earlier).search, starting(earlier).search
    assert search == again and len({search, again}) == 1 and search != load_study(QUICKSTART, SMALL).search


def test_the_digest_holds_the_points_and_not_the_place(earlier):
    study = starting(earlier)
    moved = earlier.rename(earlier.with_name("moved"))
    assert starting(moved).digest() == study.digest() != load_study(QUICKSTART, SMALL).digest()
    assert starting().digest() == load_study(QUICKSTART, SMALL).digest()
    document = json.loads((moved / "resolved.json").read_text())
    assert "starts" not in document["search"]
    rows = (moved / "front.csv").read_text().splitlines()
    (moved / "front.csv").write_text("\n".join(rows[:-1]) + "\n")
    assert starting(moved).digest() != study.digest()


def test_gains_of_a_firmware_keep_their_acceleration_on_another_vehicle(tmp_path):
    gains = {"gains": {"tilt.p": {}, "tilt.angle_p": {}}, "margin": []}
    study = load_study(QUICKSTART.parent / "px4.toml", {**gains, "airframe": {"name": "f450"}})
    other = load_study(
        QUICKSTART.parent / "px4.toml",
        {**gains, "airframe": {"name": "iris"}, "search.starts": [str(write_gains(study, tmp_path))]},
    )
    (point,) = other.search.starts[0].points

    def of(one, address):
        return dict(zip([gain.address for gain in one.system.gains], one.default_row.tolist(), strict=True))[address]

    assert of(study, "roll.authority") != pytest.approx(of(other, "roll.authority"), rel=0.05)
    assert point["tilt.p"] * of(other, "roll.authority") == pytest.approx(
        of(study, "roll.p") * of(study, "roll.authority")
    )
    assert point["tilt.angle_p"] == of(study, "roll.angle_p")


def test_gains_in_volts_become_accelerations_where_b0_is_stated(tmp_path):
    study = load_gains_study(ANGLE, "a test")
    starts = {"search.starts": [str(write_gains(study, tmp_path))]}
    assert dict(load_gains_study(ANGLE, "a test", starts).search.starts[0].points[0])["angle.kp"] == 10.0
    wide = {"low": 1.0, "high": 1e6}
    other = load_gains_study(
        ANGLE,
        "a test",
        {**starts, "channel.0.b0": 2000.0, "gains.angle.kp": wide, "gains.angle.ki": wide, "gains.angle.kd": wide},
    )
    assert dict(other.search.starts[0].points[0]) == pytest.approx(
        {"angle.kp": 2e4, "angle.ki": 2e4, "angle.kd": 400.0}
    )


def test_channels_of_another_plant_are_refused(tmp_path):
    heater = load_any(QUICKSTART.parent / "heater.toml")
    with pytest.raises(InputError, match=r"its channels are temperature \(pid\), those of this study angle \(pid\)"):
        load_any(ANGLE, {"search.starts": [str(write_gains(heater, tmp_path))]})


def test_gains_of_a_quadrotor_are_no_start_of_a_plant(small_run):
    with pytest.raises(InputError, match="holds no gains of a plant of one's own"):
        load_any(ANGLE, {"search.starts": [str(small_run[1])]})


def test_trials_start_from_values_of_the_same_variables(tmp_path):
    values = {"x": {"value": 0.25, "unit": "m"}, "z": {"value": 3.0, "unit": "1"}}
    file = tmp_path / "gains.json"
    file.write_text(json.dumps({"format": "gainproof-variables", "version": 1, "gains": values}))
    study = bowls(tmp_path, {"search.starts": ["gains.json"]})
    assert [dict(point) for point in study.search.starts[0].points] == [{"x": 0.25}]
    file.write_text(json.dumps({"format": "gainproof-variables", "version": 1, "gains": {"z": values["z"]}}))
    with pytest.raises(InputError, match="its variables are z, those of this study x and y"):
        bowls(tmp_path, {"search.starts": ["gains.json"]}, TITLE + BOWLS)


def test_a_contest_keeps_the_points_of_each_contender(tmp_path):
    file = tmp_path / "contest.toml"
    file.write_text(CONTEST)
    plain = load_contest(file)
    gains = write_gains(plain.contenders[0].study, tmp_path)
    contest = load_contest(file, {"contender.0.search.starts": ["gains.json"]})
    kept = tmp_path / "kept.toml"
    kept.write_text(toml_text(contest.content))
    gains.unlink()
    again = load_contest(kept)
    assert contest.contenders[0].study.search.starts and not contest.contenders[1].study.search.starts
    assert again.digest() == contest.digest() != plain.digest()
    assert [entry.study.search.starts for entry in again.contenders] == [
        e.study.search.starts for e in contest.contenders
    ]


def test_starts_of_all_contenders_are_kept_by_each(tmp_path):
    file = tmp_path / "contest.toml"
    file.write_text(CONTEST)
    gains = write_gains(load_contest(file).contenders[0].study, tmp_path)
    contest = load_contest(file, {"search.starts": ["gains.json"]})
    gains.unlink()
    kept = tmp_path / "kept.toml"
    kept.write_text(toml_text(contest.content))
    assert contest.contenders[0].study.search.starts and "starts" not in str(contest.content["search"])
    assert load_contest(kept).digest() == contest.digest()


def test_an_unknown_variable_is_the_error_of_names():
    with pytest.raises(UnknownNameError):
        load_study(QUICKSTART, {"search.starts": [{"points": [{"roll.lambda": 4.0}]}]})


PAIRS = list(shipped_fronts())


@pytest.mark.parametrize("pair", PAIRS, ids="/".join)
def test_a_shipped_front_lies_in_the_usual_ranges_of_its_laws(pair):
    attitude, position = pair
    points = shipped_fronts()[pair].points
    axes = {"roll": "attitude", "x": "position"}
    gains = {
        f"{axes[axis]}.{gain}": {} for axis, _, gain in (name.partition(".") for name in points[0]) if axis in axes
    }
    laws = {"controller.attitude": attitude, "controller.position": position, "gains": gains}
    study = load_study(QUICKSTART, {**SMALL, **laws, "search.starts": ["shipped"]})
    (found,) = study.search.starts
    assert len(found.points) == 24 and all(set(point) == set(gains) for point in found.points)
    assert {name.partition(".")[2] for name in gains} <= {
        gain.name.rstrip("_") for each in pair for gain in law(each).gains
    }
    assert study.start_texts == [f"The search starts from the shipped front of {attitude}/{position} (24 points)."]


def test_pairs_of_the_quickstart_and_of_pid_are_shipped():
    assert {("hybrid", "ladrc"), ("pid", "pid"), ("ladrc", "ladrc")} <= set(PAIRS)


def starts_in(content: Any) -> Any:
    return content["search"]["starts"]


def without_key(text=STUDY):
    return changed("starts = []\n", "", text)


def test_a_search_begins_from_the_shipped_front_unless_the_study_says_otherwise(tmp_path):
    path = write(tmp_path, without_key())
    study = load_study(path)
    named, none = (load_study(path, {"search.starts": entries}) for entries in (["shipped"], []))
    assert [entry.origin for entry in study.search.starts] == ["the shipped front of hybrid/ladrc"]
    assert none.search.starts == () and named.digest() == study.digest() != none.digest()
    assert named.search == study.search and none.search == load_study(write(tmp_path, STUDY)).search


def test_the_inputs_of_a_run_hold_the_points_of_the_shipped_front(tmp_path):
    study = load_study(write(tmp_path, without_key()))
    kept = tmp_path / "kept.toml"
    kept.write_text(toml_text(study.content))
    (entry,) = starts_in(study.content)
    assert load_study(kept).digest() == study.digest() and len(entry["points"]) == 24


NONE_USUAL = {
    "no model searches": {"search.algorithm": "nsga2"},
    "no front of the laws": {"controller.attitude": "px4", "gains": {"tilt.p": {}}},
    "no gain of the front": {"gains": {"attitude.delta": {}}},
}


@pytest.mark.parametrize("changes", NONE_USUAL.values(), ids=NONE_USUAL)
def test_searches_without_a_shipped_front_begin_from_none(changes, tmp_path):
    study = load_study(write(tmp_path, without_key()), changes)
    assert study.search.starts == () and study.start_texts == [] and starts_in(study.content) == []


def test_a_shipped_front_without_the_searched_gains_is_refused_by_name():
    with pytest.raises(InputError, match=r"has none of the gains of this study \(attitude.delta\); leave starts out"):
        load_study(QUICKSTART, {"gains": {"attitude.delta": {}}, "search.starts": ["shipped"]})


def contest_of(tmp_path, *positions):
    contenders = "".join(
        f"""
[[contender]]
name = "{position}"
controller = {{ attitude = "hybrid", position = "{position}" }}
gains = {{ "tilt.omega_o" = {{}} }}
"""
        for position in positions
    )
    return load_contest(write(tmp_path, without_key() + contenders))


def test_contenders_begin_from_shipped_fronts_where_all_have_one(tmp_path):
    contest = contest_of(tmp_path, "ladrc", "pid")
    assert [len(contender.study.search.starts) for contender in contest.contenders] == [1, 1]
    uneven = contest_of(tmp_path, "ladrc", "supertwisting")
    assert [contender.study.search.starts for contender in uneven.contenders] == [(), ()]
    kept = tmp_path / "kept.toml"
    kept.write_text(toml_text(uneven.content))
    assert load_contest(kept).digest() == uneven.digest()
    assert all(starts_in(contender.raw) == [] for contender in uneven.contenders)


def test_a_pair_without_a_shipped_front_is_refused():
    with pytest.raises(InputError, match="no front of px4/pid comes with the tool; there are those of .*hybrid/ladrc"):
        load_study(
            QUICKSTART,
            {
                "controller.attitude": "px4",
                "controller.position": "pid",
                "gains": {"tilt.p": {}},
                "search.starts": ["shipped"],
            },
        )


def test_no_front_of_plants_is_shipped():
    with pytest.raises(InputError, match="fronts of quadrotors' laws alone come with the tool"):
        load_any(ANGLE, {"search.starts": ["shipped"]})


def test_shipped_is_no_path():
    table: PlainTable = {"search": {"starts": ["shipped", "results/first"]}}
    assert with_paths(table, lambda path: f"moved/{path}")["search"] == {"starts": ["shipped", "moved/results/first"]}
