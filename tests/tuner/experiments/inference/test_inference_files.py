"""Inference files: what they become, and that every mistake names file and key."""

from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError
from tests.tuner.experiments.inference.asked import CELLS, STUDY, TRUTH, cell, changed, plain_table, write
from tests.tuner.study.loading import load_inference
from tuner.study.build import study_from_table
from tuner.study.kinds import kind_of_layers, load_any
from tuner.study.layers import read_layers

STUDIES = Path(__file__).parents[4] / "studies"
K2 = 'set = ["contender.soft.gains.attitude.k2"]'
SIGMA = 'set = ["scenario.0.air.injection.angular_sigma.0"]'


def load(tmp_path, text=STUDY + CELLS, **overrides):
    return load_inference(write(tmp_path, text), {key.replace("__", "."): value for key, value in overrides.items()})


def test_what_a_file_becomes(tmp_path):
    asked = load(tmp_path)
    assert kind_of_layers(read_layers(asked.path)).name == "inference"
    assert [(u.variable.name, u.unit, u.default) for u in asked.unknowns] == [
        ("intensity", "rad/s2", 1.0),
        ("k2 of soft", "1/s", 1.5),
    ]
    assert [kind.name for kind in asked.kinds] == ["peak", "settling"]
    assert asked.kind_of.tolist() == [0, 0, 1, 1]
    assert [(r.first, r.second) for r in asked.ratios] == [(0, 1), (2, 3)]
    assert (asked.flights, asked.held_out, asked.near) == (32, 96, 0.1)


def test_a_setting_is_what_a_person_would_have_written(tmp_path):
    studies = load(tmp_path).studies(np.array([TRUTH["intensity"], TRUTH["k2 of soft"]]))
    for name, study in studies.items():
        by_hand = study_from_table(Path("plain.toml"), plain_table(name, TRUTH["intensity"], TRUTH["k2 of soft"]))
        assert study.digest() == by_hand.digest()


def test_a_key_that_is_not_given_starts_from_its_default(tmp_path):
    asked = load(
        tmp_path, changed(K2, 'set = ["contender.soft.gains.attitude.delta"]').replace("low = 0.5", "low = 0.05")
    )
    assert asked.unknowns[1].default == 0.1
    band = changed(SIGMA, 'set = ["scenario.0.bands.settling"]').replace(
        "low = 0.2\nhigh = 20.0", "low = 0.01\nhigh = 1.0"
    )
    asked = load(tmp_path, band)
    assert asked.unknowns[0].default == 0.05


def test_gains_that_all_share_start_from_what_the_law_has(tmp_path):
    text = changed('"attitude.lambda" = 2.0\n"attitude.k1" = 0.0\n"attitude.k2" = 1.5\n', "")
    text = changed("[contender.gains]\n\n", "\n", text)
    asked = load(tmp_path, changed(K2, 'set = ["gains.attitude.k2"]', text))
    assert asked.unknowns[1].default == 5.0
    assert asked.unknowns[1].places == (("gains", "attitude.k2"),)


def test_contenders_can_be_left_out_with_what_only_they_have(tmp_path):
    both = changed(K2, 'set = ["contender.soft.gains.attitude.k2", "contender.stiff v1.0.gains.attitude.lambda"]')
    both = changed('"attitude.lambda" = 6.0', '"attitude.lambda" = 1.5', both)
    asked = load(tmp_path, both, inference__contenders=["stiff v1.0"])
    assert [c.contender for c in asked.cells] == ["stiff v1.0"] * 2
    assert asked.unknowns[1].flown == (("contender", 0, "gains", "attitude.lambda"),)
    assert len(asked.unknowns[1].places) == 2
    assert asked.ratios == ()
    with pytest.raises(InputError, match=r"unknown\[1\].set: 'k2 of soft' sets only contenders that are left out"):
        load(tmp_path, inference__contenders=["stiff v1.0"])


def test_the_file_may_lie_over_another(tmp_path):
    write(tmp_path)
    (tmp_path / "over.toml").write_text('base = "asked.toml"\n[inference]\nflights = 16\n')
    asked = load_inference(tmp_path / "over.toml")
    assert (asked.flights, asked.held_out) == (16, 96)


def test_every_inference_among_the_studies_loads():
    settings = [
        path for path in sorted(STUDIES.glob("*.toml")) if kind_of_layers(read_layers(path)).name == "inference"
    ]
    assert [path.name for path in settings] == ["paper_inference.toml"]
    asked = load_inference(settings[0])
    assert len(asked.cells) == 18
    assert [kind.name for kind in asked.kinds] == ["peak", "settling"]


def unknown(**changes):
    """A further [[unknown]] with some keys changed; None leaves one out."""
    keys = {
        "name": '"third"',
        "unit": '"1/s"',
        "set": '["contender.soft.gains.attitude.lambda"]',
        "low": 1.0,
        "high": 9.0,
    }
    given = {key: value for key, value in {**keys, **changes}.items() if value is not None}
    return STUDY + "\n[[unknown]]\n" + "".join(f"{key} = {value}\n" for key, value in given.items()) + CELLS


THIRD = r"asked.toml: unknown\[2\]"
WRONG = {
    "no unit": (unknown(unit=None), THIRD + r".unit: this key is required and missing"),
    "misspelt key": (unknown(hihg=2.0), THIRD + r".hihg: unknown key 'hihg'; did you mean 'high'\?"),
    "low is a text": (unknown(low='"1"'), THIRD + r".low: given '1'; this must be a number"),
    "empty name": (unknown(name='" "'), THIRD + r'.name: given an empty name; write for instance name = "k2"'),
    "same name": (unknown(name='"intensity"'), THIRD + r".name: 'intensity' is unknown\[0\] too; change one name"),
    "sets nothing": (unknown(set="[]"), THIRD + r".set: given an empty list; write for instance set = "),
    "turned round": (unknown(low=9.0, high=1.0), THIRD + r": given \[9.0, 1.0\]; the lower end must be below"),
    "unknown scale": (unknown(scale='"cubic"'), THIRD + r": given scale 'cubic'; allowed: 'linear', 'log'"),
    "log from zero": (unknown(low=0.0, scale='"log"'), THIRD + r": given \[0.0, 9.0\]; a log scale needs a lower end above 0"),
    "no such table": (
        unknown(set='["search.population"]'), THIRD + r".set\[0\]: unknown table to look for an unknown in 'search'; .*valid: contender",
    ),
    "no such contender": (
        unknown(set='["contender.sotf.gains.attitude.k2"]'), THIRD + r".set\[0\]: unknown contender 'sotf'; did you mean 'soft'\?",
    ),
    "no such entry": (unknown(set='["scenario.1.duration"]'), THIRD + r".set\[0\]: '1' is no entry of the list 'scenario'; allowed: 0 to 0"),
    "leads to a table": (unknown(set='["scenario.0.air"]'), THIRD + r".set\[0\]: 'scenario.0.air' leads to a table; .*there is: intensity"),
    "no such gain": (
        unknown(set='["contender.soft.gains.attitude.k9"]'), THIRD + r".set\[0\]: unknown gain 'attitude.k9'; .*valid: pitch.delta",
    ),
    "no such key": (unknown(set='["scenario.0.bands.atitude"]'), THIRD + r".set\[0\]: there is no 'scenario.0.bands.atitude', and no default"),
    "in a table that is not there": (unknown(set='["scenario.0.air.gust.amplitude"]'), THIRD + r".set\[0\]: there is no 'scenario.0.air.gust"),
    "in a list that is not there": (
        unknown(set='["scenario.0.air.injection.acceleration_time.0"]'), THIRD + r".set\[0\]: there is no 'scenario.0.air.injection.acc",
    ),
    "no such key on the way": (unknown(set='["scenario.0.band.attitude"]'), THIRD + r".set\[0\]: there is no 'scenario.0.band.attitude'"),
    "a text": (unknown(set='["controller.attitude"]'), THIRD + r".set\[0\]: 'controller.attitude' holds 'hybrid'; an unknown is a number"),
    "a switch": (unknown(set='["controller.delay"]'), THIRD + r".set\[0\]: 'controller.delay' holds False; an unknown is a number"),
    "set before": (
        unknown(set='["contender.soft.gains.attitude.k2"]'), THIRD + r".set\[0\]: 'contender.soft.gains.attitude.k2' is set by 'k2 of soft' already",
    ),
    "set twice": (
        unknown(set='["contender.soft.gains.attitude.lambda", "contender.soft.gains.attitude.lambda"]'),
        THIRD + r".set\[1\]: 'contender.soft.gains.attitude.lambda' is set by 'third' already",
    ),
    "two starts": (
        unknown(set='["contender.soft.gains.attitude.lambda", "contender.stiff v1.0.gains.attitude.lambda"]'),
        THIRD + r".set\[1\]: 'contender.stiff v1.0.gains.attitude.lambda' stands at 6 and 'contender.soft.gains.attitude.lambda' at 2; one",
    ),
    "start outside": (
        unknown(low=3.0), THIRD + r".set\[0\]: 'contender.soft.gains.attitude.lambda' stands at 2 1/s, outside of low = 3 to high = 9",
    ),
    "start above": (unknown(high=1.5), THIRD + r".set\[0\]: .* stands at 2 1/s, outside of low = 1 to high = 1.5"),
    "end not allowed": (
        unknown(set='["contender.soft.gains.attitude.omega_o"]', high=500.0),
        THIRD + r".high: given 500, which the study does not take: contender\[0\].gains.attitude.omega_o: given 500 rad/s",
    ),
    "moves no cell": (
        unknown(set='["contender.stiff v1.0.gains.attitude.lambda"]').replace(CELLS, cell("soft", "peak.roll", 0.5)),
        THIRD + r".set: no contender with a published cell flies differently whatever 'third' is",
    ),
    "gains of nobody": (
        unknown(set='["gains.attitude.lambda"]'), THIRD + r".set\[0\]: 'gains.attitude.lambda' moves nothing: every contender has gains",
    ),
    "nothing published": (STUDY, r"asked.toml: published: nothing is published of these contenders; give at least one"),
    "published twice": (STUDY + CELLS + cell("soft", "peak.roll", 1.0), r"published\[4\]: 'peak.roll soft@level' is published twice"),
    "published zero": (STUDY + cell("soft", "peak.roll", 0.0), r"published\[0\].*0"),
    "published negative": (STUDY + cell("soft", "peak.roll", -0.5), r"published\[0\].*-0.5"),
    "searched gain": (
        changed('"attitude.lambda" = 6.0', '"attitude.lambda" = {}'),
        r"contender\[1\].gains: contender 'stiff v1.0' searches attitude.lambda; an inference flies gains as given",
    ),
    "unknown contender chosen": (
        changed("flights = 32", 'flights = 32\ncontenders = ["soft", "stif"]'), r"inference.contenders\[1\]: unknown contender 'stif'",
    ),
    "few flights": (changed("flights = 32", "flights = 4"), r"inference.flights: given 4; this must be at least 8"),
    "few held out": (changed("held_out = 96", "held_out = 8"), r"inference.held_out: given 8; this must be at least 40"),
    "near zero": (changed("held_out = 96", "near = 0.0"), r"inference.near: given 0.0"),
    "misspelt setting": (changed("held_out = 96", "heldout = 96"), r"inference.heldout: unknown key 'heldout'; did you mean 'held_out'"),
    "single table": (
        changed('[[unknown]]\nname = "k2 of soft"', '[unknown2]\nname = "k2 of soft"'), r"unknown2: unknown key 'unknown2'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_every_mistake_names_file_and_key(tmp_path, what):
    text, message = WRONG[what]
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path, text)
    assert caught.value.file == str(tmp_path / "asked.toml")


def test_a_contest_without_unknowns_is_no_inference(tmp_path):
    text = STUDY.split("[[unknown]]")[0] + CELLS
    path = write(tmp_path, text)
    assert load_any(path).kind == "contest"


def test_gains_that_would_be_lost_are_not_made(tmp_path):
    text = changed('[contender.gains]\n"attitude.lambda" = 2.0\n"attitude.k1" = 0.0\n"attitude.k2" = 1.5\n', "")
    text = changed("[limits]", '[gains]\n"attitude.k2" = 1.5\n\n[limits]', text)
    with pytest.raises(
        InputError, match=r"unknown\[1\].set\[0\]: 'soft' has no gains of its own .*write gains.attitude.k2"
    ):
        load(tmp_path, text)


def test_gains_of_a_group_with_different_values_have_no_one_default(tmp_path):
    text = changed('"attitude.k2" = 1.5', '"roll.k2" = 1.5')
    with pytest.raises(InputError, match=r"'contender.soft.gains.attitude.k2' stands for gains of different values"):
        load(tmp_path, text)
