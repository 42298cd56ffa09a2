"""Every way a study can be wrong: one error that names file and key and says what to do."""

from pathlib import Path

import pytest

from plant.errors import InputError
from tuner.study.build import load_study

QUICKSTART = Path(__file__).parents[3] / "studies" / "quickstart.toml"

# Each case: what to replace in the quickstart, by what, the key named, and words that the message must hold.
CASES = {
    "misspelt table": ("[search]", "[serach]", "serach", "did you mean 'search'"),
    "misspelt key": ("population = 12", "populaton = 8", "search.populaton", "did you mean 'population'"),
    "misspelt scenario key": ("altitude = 10.0", "altitud = 10.0", "scenario[0].air.altitud", "did you mean 'altitude'"),
    "misspelt reference key": ("yaw_deg = 20.0", "yaw_dge = 20.0", "scenario[0].reference.yaw_dge", "did you mean 'yaw_deg'"),
    "misspelt objective key": ("level = 0.8", "levle = 0.8", "objective[0].levle", "did you mean 'level'"),
    "misspelt gain option": ("{ high = 30 }", "{ hihg = 30 }", "gains.attitude.k2.hihg", "did you mean 'high'"),
    "no seed": ("seed = 2025", "", "seed", "write seed = 2025"),
    "no attitude law": ('attitude = "hybrid"', "", "controller.attitude", 'write attitude = "hybrid"'),
    "text for a number": ("duration = 8.0", 'duration = "8 s"', "scenario[0].duration", "must be a number"),
    "bool for a number": ("altitude = 10.0", "altitude = true", "scenario[0].air.altitude", "must be a number"),
    "number for a flag": ("delay = true", "delay = 1", "controller.delay", "true or false"),
    "float for a count": ("population = 12", "population = 8.5", "search.population", "whole number"),
    "negative seed": ("seed = 2025", "seed = -1", "seed", "at least 0"),
    "infinite": ("duration = 8.0", "duration = inf", "scenario[0].duration", "finite"),
    "nan": ("mass = 0.05", "mass = nan", "scenario[0].spread.mass", "finite"),
    "no flights": ("search = 8 ", "search = 0 ", "scenario[0].search", "at least 1"),
    "odd population": ("population = 12", "population = 9", "search.population", "even"),
    "lower above upper": ("{ high = 30 }", "{ low = 40, high = 30 }", "gains.attitude.k2", "lower end must be below"),
    "empty range": ("{ high = 30 }", "{ low = 30, high = 30 }", "gains.attitude.k2", "fix the gain"),
    "log from zero": ("{ high = 30 }", '{ low = 0, high = 30, scale = "log" }', "gains.attitude.k2", "log scale"),
    "unknown scale": ("{ high = 30 }", '{ scale = "cubic" }', "gains.attitude.k2", "'linear', 'log'"),
    "negative gain": ("{ high = 30 }", "-1.0", "gains.attitude.k2", "at least 0"),
    "zero where excluded": ('"attitude.lambda" = {}', '"attitude.lambda" = 0.0', "gains.attitude.lambda", "above 0"),
    "unknown gain": ('"attitude.k1"', '"attitude.k7"', "gains.attitude.k7", "unknown gain 'k7'"),
    "unknown axis": ('"attitude.k1"', '"atitude.k1"', "gains.atitude.k1", "did you mean 'attitude'"),
    "gain given twice": ('"attitude.k1" = {}', '"roll.k1" = {}\n"roll.k1 " = 3', "gains.roll.k1 ", "unknown gain"),
    "overlapping groups": ('"attitude.k1" = {}', '"tilt.k1" = 1.0\n"attitude.k1" = 2.0\n"roll.k1" = 3.0\n"pitch.k1" = { tie = "nobody.k1" }', "gains.pitch.k1", "nobody.k1"),
    "tie to a fixed gain": ('"attitude.k1" = {}', '"roll.k1" = 2.0\n"pitch.k1" = { tie = "roll.k1" }', "gains.pitch.k1", "fixed, not searched"),
    "tie in a circle": ('"attitude.k1" = {}', '"roll.k1" = { tie = "pitch.k1" }\n"pitch.k1" = { tie = "roll.k1" }', "gains.roll.k1", "circle"),
    "tie with a range": ('"attitude.k1" = {}', '"roll.k1" = {}\n"pitch.k1" = { tie = "roll.k1", low = 1 }', "gains.pitch.k1", "no range of its own"),
    "unstable observer": ('"attitude.omega_o" = {}', '"attitude.omega_o" = { high = 600 }', "gains.attitude.omega_o", "75 rad/s"),
    "period no multiple": ("control_period = 0.004", "control_period = 0.0035\nplant_step = 0.001", "controller.control_period", "multiple of plant_step"),
    "duration no multiple": ("duration = 8.0", "duration = 8.001", "scenario[0].duration", "multiple of controller.control_period"),
    "period zero": ("control_period = 0.004", "control_period = 0.0", "controller.control_period", "1e-05 s to 0.1 s"),
    "plant step too long": ("control_period = 0.004", "control_period = 0.02\nplant_step = 0.02", "controller.plant_step", "up to 0.01 s"),
    "gust after the flight": ("mean_wind = true", "gust = { amplitude = 3.0, start = 9.0, length = 1.0 }", "scenario[0].air.gust.start", "ends at 8 s"),
    "window after the flight": ("mean_wind = true", "window = [8.0, 12.0]", "scenario[0].air.window", "ends at 8 s"),
    "unknown law": ('attitude = "hybrid"', 'attitude = "hybird"', "controller.attitude", "did you mean 'hybrid'"),
    "unknown airframe": ('name = "hummingbird"', 'name = "humingbird"', "airframe.name", "did you mean 'hummingbird'"),
    "airframe file missing": ('name = "hummingbird"            #', 'file = "no_such.toml" #', None, "no_such.toml"),
    "unphysical airframe": ('name = "hummingbird"', 'name = "paper-literal"', None, "allow_unphysical"),
    "unknown metric": ('metric = "itae.position"', 'metric = "itea.position"', "objective[0].metric", "did you mean 'itae'"),
    "unknown axis of a metric": ('metric = "itae.position"', 'metric = "itae.positon"', "objective[0].metric", "did you mean 'itae.position'"),
    "unknown risk": ('risk = "cvar"', 'risk = "cvra"', "objective[0].risk", "did you mean 'cvar'"),
    "level out of range": ("level = 0.8", "level = 1.8", "objective[0].level", "1.8"),
    "overshoot without a step": ('metric = "itae.position"', 'metric = "overshoot.tilt"', "objective[0].metric", "needs a step"),
    "unknown scenario": ("level = 0.8", 'level = 0.8\nscenario = "steps in gust"', "objective[0].scenario", "did you mean 'steps in gusts'"),
    "unknown reference": ('kind = "steps"', 'kind = "step"', "scenario[0].reference.kind", "did you mean 'steps'"),
    "late step": ("time = 0.5", "time = 9.5", "scenario[0].reference.time", "9.5"),
    "unknown intensity": ('intensity = "light"', 'intensity = "modest"', "scenario[0].air.intensity", "did you mean 'moderate'"),
    "negative altitude": ("altitude = 10.0", "altitude = -10.0", "scenario[0].air.altitude", "-10"),
    "spread too wide": ("mass = 0.05", "mass = 0.9", "scenario[0].spread.mass", "0 to 0.5"),
    "unknown pick": ('rule = "knee"', 'rule = "knie"', "pick.rule", "did you mean 'knee'"),
    "pick of no objective": ('rule = "knee"', 'rule = "min:effort"', "pick.rule", "min:travel"),
    "unknown algorithm": ("population = 12", 'population = 8\nalgorithm = "nsga-2"', "search.algorithm", "did you mean 'nsga2'"),
    "objective twice": ("", "", "objective[1]", "twice"),
    "infinite constraint": ("max = 0.02", "max = inf", "constraint[1].max", "finite"),
    "key of another table": ("seed = 2025", 'seed = 2025\npopulation = 8', "population", "a key of [search]"),
    "negative share that matters": ("seed = 2025", "seed = 2025\nrelevant = -0.01", "relevant", "at least 0"),
    "all of a value as what matters": ("seed = 2025", "seed = 2025\nrelevant = 1.0", "relevant", "below 1"),
    "share that matters in words": ("seed = 2025", 'seed = 2025\nrelevant = "2 %"', "relevant", "given '2 %'"),
    "control characters": ("seed = 2025", 'seed = 2025\n"a\\nb\\u001b[31m" = 1', "a\nb\x1b[31m", "unknown key 'a\\nb\\x1b[31m'"),
    "empty key": ("seed = 2025", 'seed = 2025\n"" = 1', '""', "unknown key ''"),
    "too many flights": ("search = 8 ", "search = 2000000 ", "scenario[0].search", "at most 1,000,000"),
    "too large a population": ("population = 12", "population = 1000000000", "search.population", "up to 10,000"),
    "too many candidates": ("generations = 12", "generations = 1000000000", "search.generations", "up to 1,000,000"),
    "too long a run": ("duration = 8.0                  # s\nsearch = 8 ", "duration = 120.0\nsearch = 900000 ", "search", "plant steps in all"),
    "a step to nowhere": ("x = 1.0", "x = 1e300", "scenario[0].reference.x", "a size from 1e-09 to 1e+06"),
    "a span of nothing": ("altitude = 10.0", "altitude = 10.0\nspan = 1e-301", "scenario[0].air.span", "a size from 1e-09"),
    "a number of 400 digits": ("duration = 8.0", "duration = 1" + 400 * "0", None, "more than 300 digits"),
    "a number of 5000 digits": ("duration = 8.0", "duration = 1" + 5000 * "0", None, "more than 300 digits"),
    "deep nesting": ("seed = 2025", "seed = " + 9999 * "[", None, "nested deeper than 16 levels"),
    "nesting": ("seed = 2025", "seed = " + 20 * "[" + 20 * "]", None, "nested deeper than 16 levels"),
    "syntax": ("seed = 2025", "seed = = 2025", None, "line"),
}  # fmt: skip


def written(tmp_path, old, new):
    text = QUICKSTART.read_text()
    assert old in text, "the case no longer fits the quickstart"
    file = tmp_path / "study.toml"
    file.write_text(text.replace(old, new, 1))
    return file


@pytest.mark.parametrize("case", CASES)
def test_message_names_file_key_and_way_out(case, tmp_path):
    old, new, key, words = CASES[case]
    if case == "objective twice":
        old, new = 'metric = "travel"               # 1/s, how', 'metric = "itae.position"\nlevel = 0.8 #'
        text = QUICKSTART.read_text().replace('risk = "mean"', 'risk = "cvar"', 1)
        file = tmp_path / "study.toml"
        file.write_text(text.replace(old, new, 1))
    else:
        file = written(tmp_path, old, new)
    with pytest.raises(InputError) as caught:
        load_study(file)
    error = caught.value
    assert error.file is not None
    if key is not None:
        assert error.key == key
        assert str(file) in str(error)
    assert words in str(error)


def test_missing_file_says_how_to_make_one(tmp_path):
    with pytest.raises(InputError, match="tuner new"):
        load_study(tmp_path / "nothing.toml")


def test_the_unchanged_study_loads():
    assert load_study(QUICKSTART).title.startswith("Quickstart")


def test_what_matters_is_part_of_a_digest_only_where_it_is_not_usual(tmp_path):
    usual = load_study(QUICKSTART)
    given, other = (load_study(QUICKSTART, {"relevant": share}) for share in (0.02, 0.1))
    assert usual.digest() == given.digest() != other.digest()
    assert other.resolved()["relevant"] == 0.1
