"""Every bad input: the error names the study file and the key, the nearest name where there is one, and what to do."""

from pathlib import Path

import pytest

from plant.errors import InputError, UnknownNameError
from tests.tuner.study.study_text import STUDY, changed, with_gains, write
from tuner.study.build import load_study

LAW = 'attitude = "hybrid"'
TILT = '"tilt.lambda" = { low = 1, high = 16 }'
ROLL = '"roll.k1" = 20.0'
AIR = 'intensity = "light"'
GUST = "[scenario.air.gust]\namplitude = 1\nstart = 1\n"
CVAR = 'risk = "cvar"'
SECOND = '\n[[scenario]]\nname = "calm"\nduration = 2.0\n'

# Old text, new text, key, what the message must say: names the key given, what is allowed or what to write.
BAD = [
    # misspelt keys, at every depth
    ("seed = 1", "sed = 1", "sed", "did you mean 'seed'?"),
    ("[search]", "[serach]", "serach", "did you mean 'search'?"),
    ('name = "hummingbird"', 'nam = "hummingbird"', "airframe.nam", "did you mean 'name'?"),
    (LAW, 'atitude = "hybrid"', "controller.atitude", "did you mean 'attitude'?"),
    (TILT, '"tilt.lambda" = { low = 1, hihg = 16 }', "gains.tilt.lambda.hihg", "did you mean 'high'?"),
    ("held_out = 8", "heldout = 8", "scenario[0].heldout", "did you mean 'held_out'?"),
    ("time = 0.5", "tme = 0.5", "scenario[0].reference.tme", "did you mean 'time'?"),
    (AIR, 'intensty = "light"', "scenario[0].air.intensty", "did you mean 'intensity'?"),
    (AIR, GUST + "lengh = 1", "scenario[0].air.gust.lengh", "did you mean 'length'?"),
    ("mass = 0.1", "mas = 0.1", "scenario[0].spread.mas", "did you mean 'mass'?"),
    ("[scenario.spread]", "[scenario.sensors]\nrates = 1\n[scenario.spread]", "scenario[0].sensors.rates", "'rate'"),
    ("[scenario.spread]", "[scenario.bands]\nsetling = 1\n[scenario.spread]", "scenario[0].bands.setling", "'settling'"),
    ("level = 0.9", "levl = 0.9", "objective[0].levl", "did you mean 'level'?"),
    ("max = 0.0", "maxx = 0.0", "constraint[0].maxx", "did you mean 'max'?"),
    ("population = 8", "popluation = 8", "search.popluation", "did you mean 'population'?"),
    ('rule = "knee"', 'rul = "knee"', "pick.rul", "did you mean 'rule'?"),
    # unknown names
    ('"hummingbird"', '"humingbird"', "airframe.name", "did you mean 'hummingbird'?"),
    ('"hummingbird"', '"quad.toml"', "airframe.name", "valid: crazyflie-pybullet"),
    ('"hybrid"', '"hybird"', "controller.attitude", "did you mean 'hybrid'?"),
    (LAW, LAW + '\nposition = "ladcr"', "controller.position", "did you mean 'ladrc'?"),
    (LAW, LAW + '\nattitude_rate = "gyro"', "controller.attitude_rate", "'measured', 'observer'"),
    ('kind = "steps"', 'kind = "step"', "scenario[0].reference.kind", "did you mean 'steps'?"),
    ('"light"', '"lihgt"', "scenario[0].air.intensity", "did you mean 'light'?"),
    (AIR, GUST + 'length = 1\ndirection = "up"', "scenario[0].air.gust.direction", "valid: u, v, w"),
    ('"itae.position"', '"itea.position"', "objective[0].metric", "did you mean 'itae'?"),
    ('"itae.position"', '"itae.positon"', "objective[0].metric", "did you mean 'itae.position'?"),
    ('metric = "failure"', 'metric = "failures"', "constraint[0].metric", "did you mean 'failure'?"),
    (CVAR, 'risk = "cvr"', "objective[0].risk", "did you mean 'cvar'?"),
    (CVAR, CVAR + '\nscenario = "gust"', "objective[0].scenario", "did you mean 'gusts'?"),
    ("population = 8", 'population = 8\nalgorithm = "nsga-2"', "search.algorithm", "did you mean 'nsga2'?"),
    ("population = 8", 'population = 8\ninitial = ["defalt"]', "search.initial", "did you mean 'default'?"),
    ("population = 8", 'population = 8\nstop = "convergd"', "search.stop", "did you mean 'converged'?"),
    ("population = 8", "population = 8\ninitial = []", "search.initial", 'write initial = ["default"]'),
    ('"knee"', '"kne"', "pick.rule", "did you mean 'knee'?"),
    ('"knee"', '"min:travl"', "pick.rule", "did you mean 'min:travel'?"),
    # wrong types
    ("seed = 1", "seed = true", "seed", "given true; this must be a whole number"),
    ("seed = 1", "seed = 1.0", "seed", "given 1.0; this must be a whole number"),
    ("seed = 1", "seed = -1", "seed", "this must be at least 0"),
    ('title = "Test"', "title = 3", "title", "a text in quotes"),
    ('"hummingbird"', '"hummingbird"\nallow_unphysical = "yes"', "airframe.allow_unphysical", "true or false"),
    (LAW, LAW + '\ncontrol_period = "4 ms"', "controller.control_period", "without unit and without quotes"),
    (LAW, LAW + "\ncontrol_period = true", "controller.control_period", "this must be a number"),
    (LAW, LAW + "\nlag_aware = 1", "controller.lag_aware", "this must be true or false"),
    (TILT, '"tilt.lambda" = { low = "1/s", high = 16 }', "gains.tilt.lambda.low", "without unit and without quotes"),
    (TILT, '"tilt.lambda" = { low = true, high = 16 }', "gains.tilt.lambda.low", "given true; this must be a number"),
    (ROLL, '"roll.k1" = true', "gains.roll.k1", "given true; this must be a finite number, or a table like"),
    (ROLL, '"roll.k1" = "20"', "gains.roll.k1", "this must be a finite number, or a table like"),
    (ROLL, '"roll.k1" = [1, 2]', "gains.roll.k1", "this must be a finite number, or a table like"),
    ("duration = 2.0", 'duration = "2 s"', "scenario[0].duration", "without unit and without quotes"),
    ("search = 4", "search = 4.0", "scenario[0].search", "this must be a whole number"),
    ("time = 0.5", 'time = "0.5 s"', "scenario[0].reference.time", "it must be a finite number in s"),
    (AIR, 'altitude = "10 m"', "scenario[0].air.altitude", "without unit and without quotes"),
    ('"light"', "true", "scenario[0].air.intensity", "a finite number or a text in quotes"),
    (AIR, GUST + "length = 1\ndirection = 3", "scenario[0].air.gust.direction", "a list of numbers or a text"),
    (AIR, "window = 3", "scenario[0].air.window", "this must be a list"),
    ("mass = 0.1", 'mass = "10 %"', "scenario[0].spread.mass", "without unit and without quotes"),
    ("max = 0.0", 'max = "0"', "constraint[0].max", "this must be a number"),
    ("population = 8", "population = 8.0", "search.population", "this must be a whole number"),
    ("population = 8", 'population = 8\ninitial = "default"', "search.initial", "this must be a list"),
    ("[[constraint]]", "[constraint]", "constraint", "double brackets: [[constraint]]"),
    # non-finite numbers
    (LAW, LAW + "\ncontrol_period = inf", "controller.control_period", "this must be a finite number"),
    (TILT, '"tilt.lambda" = { low = nan, high = 16 }', "gains.tilt.lambda.low", "this must be a finite number"),
    (TILT, '"tilt.lambda" = { low = 1, high = inf }', "gains.tilt.lambda.high", "this must be a finite number"),
    (ROLL, '"roll.k1" = nan', "gains.roll.k1", "a finite number"),
    ("x = 1.0", "x = nan", "scenario[0].reference.x", "it must be a finite number in m"),
    ('"light"', "nan", "scenario[0].air.intensity", "a finite number or a text in quotes"),
    ("max = 0.0", "max = inf", "constraint[0].max", "this must be a finite number"),
    # missing keys: the line to write
    ('title = "Test"', "", "title", 'write title = "'),
    ("seed = 1", "", "seed", "write seed = 2025"),
    ('[airframe]\nname = "hummingbird"', "", "airframe", 'write [airframe] with name = "hummingbird"'),
    ('name = "hummingbird"', "", "airframe", 'give either name = "hummingbird"'),
    ('name = "hummingbird"', 'name = "hummingbird"\nfile = "a.toml"', "airframe", "give either name"),
    ('[controller]\nattitude = "hybrid"', "", "controller", 'write [controller] with attitude = "hybrid"'),
    (LAW, "", "controller.attitude", 'write attitude = "hybrid"'),
    ('name = "gusts"', "", "scenario[0].name", 'write name = "gusts"'),
    ('name = "gusts"', 'name = " "', "scenario[0].name", 'name = "gusts"'),
    ('kind = "steps"', "", "scenario[0].reference.kind", "must be one of figure_eight"),
    ('kind = "steps"\nx = 1.0\ntime = 0.5', 'kind = "ramp"\nx_rate = 1', "scenario[0].reference.stop", "write stop = "),
    (AIR, GUST, "scenario[0].air.gust.length", "write length = 2.0  # s"),
    ('metric = "travel"', "", "objective[1].metric", 'write metric = "itae.position"'),
    ("level = 0.9", "", "objective[0].level", "for instance level = 0.9"),
    ("max = 0.0", "", "constraint[0].max", "write max = 0.0"),
    # values out of range
    (LAW, LAW + "\nplant_step = 1e-12", "controller.plant_step", "allowed: 1e-05 s to 0.1 s"),
    (LAW, LAW + "\ncontrol_period = 0.0045\nplant_step = 0.001", "controller.control_period", "multiple of plant_step = 0.001 s"),
    (LAW, LAW + "\nplant_step = 0.008", "controller.control_period", "multiple of plant_step = 0.008 s"),
    (LAW, LAW + "\ntilt_limit_deg = 75", "controller.tilt_limit_deg", "allowed: 3 to 60 deg"),
    ("[controller]", "[limits]\nposition = 0\n[controller]", "limits.position", "must be above 0 m"),
    ("[controller]", "[limits]\ntilt_deg = 95\n[controller]", "limits.tilt_deg", "allowed: 10 to below 90 deg"),
    ("duration = 2.0", "duration = 2.001", "scenario[0].duration", "multiple of controller.control_period = 0.004 s"),
    ("duration = 2.0", "duration = 0", "scenario[0].duration", "must last a finite, positive time"),
    ("duration = 2.0", "duration = 1e9", "scenario[0].duration", "up to 4000 s"),
    ("search = 4", "search = 0", "scenario[0].search", "this must be at least 1"),
    ("held_out = 8", "held_out = 1", "scenario[0].held_out", "this must be at least 2"),
    ("search = 4", "search = 4\nrecovery_from = 3.0", "scenario[0].recovery_from", "up to the duration of 2.0 s"),
    ("search = 4", "search = 4\nsteady_share = 0", "scenario[0].steady_share", "above 0, at most 1"),
    ("time = 0.5", "time = 5", "scenario[0].reference.time", "step earlier or fly longer"),
    ("x = 1.0", "roll_deg = 50", "scenario[0].reference.roll_deg", "at most 40 deg"),
    (AIR, "intensity = -1", "scenario[0].air.intensity", "at least 0"),
    (AIR, "altitude = 0", "scenario[0].air.altitude", "greater than 0"),
    (AIR, "window = [1.0]", "scenario[0].air.window", "give 2 numbers"),
    (AIR, "window = [1.0, 0.5]", "scenario[0].air.window", "end at least 0.5 s after start"),
    (AIR, GUST + "length = 0", "scenario[0].air.gust.length", "greater than 0"),
    (AIR, "[scenario.air.injection]\nangular_time = [1, 1]", "scenario[0].air.injection.angular_time", "give 3 numbers"),
    ("[scenario.spread]", "[scenario.sensors]\nrate = -1\n[scenario.spread]", "scenario[0].sensors.rate", "not negative"),
    ("[scenario.spread]", "[scenario.bands]\nposition = 0\n[scenario.spread]", "scenario[0].bands.position", "positive"),
    ("mass = 0.1", "mass = 0.6", "scenario[0].spread.mass", "allowed: 0 to 0.5"),
    ("level = 0.9", "level = 1.0", "objective[0].level", "between 0 and 1"),
    (CVAR, 'risk = "worst"', "objective[0].level", "leave it out"),
    ("population = 8", "population = 9", "search.population", "even and at least 8"),
    ("population = 8", "population = 6", "search.population", "even and at least 8"),
    ("generations = 2", "generations = 0", "search.generations", "this must be at least 1"),
    # numbers that cannot mean what they say
    ('title = "Test"', 'title = ""', "title", "write a title that says what this is"),
    ('title = "Test"', 'title = "   "', "title", "write a title that says what this is"),
    ('title = "Test"', f'title = "{"x" * 201}"', "title", "has 201 letters; allowed: up to 200"),
    ('title = "Test"', 'title = "\\u001b[31mred"', "title", "U+001B; a text is one line of letters that print"),
    ('title = "Test"', 'title = "\\u202etxet"', "title", "U+202E; a text is one line of letters that print"),
    ('name = "gusts"', 'name = "a\\nb"', "scenario[0].name", "U+000A; a text is one line of letters that print"),
    ("max = 0.0", "max = 2", "constraint[0].max", "given 2; 'failure' is 1 if the flight failed"),
    ("max = 0.0", "max = 2", "constraint[0].max", "allowed: 0 to 1"),
    ("max = 0.0", "max = -1", "constraint[0].max", "allowed: 0 to 1"),
    ('metric = "failure"\nmax = 0.0', 'metric = "travel"\nmax = 0', "constraint[0].max", "allowed: above 0 1/s"),
    ('metric = "failure"\nmax = 0.0', 'metric = "rms.yaw"\nmax = -0.1', "constraint[0].max", "allowed: above 0 rad"),
    ('metric = "failure"\nmax = 0.0', 'metric = "saturation"\nmax = 1.5', "constraint[0].max", "allowed: 0 to 1"),
    ('metric = "failure"\nmax = 0.0', 'metric = "overshoot.x"\nmax = -1', "constraint[0].max", "allowed: 0 %"),
    (AIR, "intensity = 1000", "scenario[0].air.intensity", "allowed: 0 to 60 m/s at 20 ft"),
    (AIR, AIR + "\nminimum_airspeed = 1000", "scenario[0].air.minimum_airspeed", "allowed: 0 to 100 m/s"),
    (AIR, AIR + "\nvehicle_speed = -1000", "scenario[0].air.vehicle_speed", "allowed: -100 to 100 m/s"),
    (AIR, AIR + "\nwind_direction_deg = 1000", "scenario[0].air.wind_direction_deg", "allowed: -360 to 360 deg"),
    (AIR, AIR + "\nspan = 1000", "scenario[0].air.span", "allowed: 0 to 10 m"),
    (AIR, "[scenario.air.gust]\namplitude = 1000\nstart = 1\nlength = 1", "scenario[0].air.gust.amplitude", "-60 to 60 m/s"),
    ("[scenario.spread]", "[scenario.sensors]\nattitude = 2\n[scenario.spread]", "scenario[0].sensors.attitude", "0 to 1 rad"),
    ("[scenario.spread]", "[scenario.bands]\nsettling = 2\n[scenario.spread]", "scenario[0].bands.settling", "0 to 1 of the"),
    ("[controller]", "[limits]\nposition = 1e5\n[controller]", "limits.position", "allowed: 0.001 to 1000 m"),
    ("x = 1.0", "x = 1e6", "scenario[0].reference.x", "leaps by 1e+06 m in one control period, and a flight ends 5 m off"),
    ("x = 1.0", "z = -5.1", "scenario[0].reference.z", "make the step smaller or the limit larger"),
    ('kind = "steps"\nx = 1.0\ntime = 0.5', 'kind = "ramp"\nx_rate = 1000\nstop = 1.5', "scenario[0].reference", "up to 150 m/s"),
    ("search = 4", "search = 4\nsteady_share = 1e-9", "scenario[0].steady_share", "allowed: 0.002, one control period, to 1"),
    # things that do not fit together
    ('[[objective]]\nmetric = "travel"', SECOND.replace("calm", "gusts"), "scenario[1].name", "change one of the two"),
    ('metric = "travel"', 'metric = "itae.position"\nrisk = "cvar"\nlevel = 0.9', "objective[1]", "leave one out"),
    ("max = 0.0", 'max = 0.0\n[[constraint]]\nmetric = "failure"\nmax = 0.1', "constraint[1]", "leave one out"),
    ('metric = "travel"', 'metric = "rise.z"', "objective[1].metric", "or add a step"),
    ('metric = "travel"', 'metric = "rise.x"\n' + SECOND, "objective[1].metric", '(scenario "calm")'),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "says"), BAD, ids=[f"{row[2]}: {row[1]!r:.40}" for row in BAD])
def test_a_bad_value_is_refused(old: str, new: str, key: str, says: str, tmp_path: Path):
    path = write(tmp_path, changed(old, new))
    with pytest.raises(InputError) as caught:
        load_study(path)
    error = caught.value
    assert (error.file, error.key) == (str(path), key)
    assert says in error.message
    assert str(error) == f"{path}: {key}: {error.message}"
    if "did you mean" in says:
        assert isinstance(error, UnknownNameError)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("max = 0.0", "max = 1"),
        ('metric = "failure"\nmax = 0.0', 'metric = "overshoot.x"\nmax = 0'),
        ('metric = "failure"\nmax = 0.0', 'metric = "recovery.x"\nmax = 0'),
        (AIR, "intensity = 60\nmean_wind = false"),
        ("x = 1.0", "x = 5.0"),
        ("[controller]", "[limits]\nposition = 20\n[controller]"),
        ("search = 4", "search = 4\nsteady_share = 0.002"),
        ('title = "Test"', f'title = "{"x" * 200}"'),
        ('title = "Test"', "title = \"Böe, 8 m/s: '*/ & <b>'\""),
        ("seed = 1", 'seed = 1\ndescription = """two\nlines\tand a tab"""'),
    ],
)
def test_what_is_just_allowed_is_read(old: str, new: str, tmp_path: Path):
    load_study(write(tmp_path, changed(old, new)))


# [gains] by itself: lines, key inside [gains], what the message must say.
BAD_GAINS = [
    ('"roll.k9" = 20', "roll.k9", "valid: delta, k1, k2, lambda, omega_o"),
    ('"roll.lamda" = 20', "roll.lamda", "did you mean 'lambda'?"),
    ('"rol.k1" = 20', "rol.k1", "did you mean 'roll'?"),
    ('"position.k1" = 5', "position.k1", "valid: omega_c, omega_o, zeta"),
    ("roll.k1 = 20.0", "roll.k1", 'in quotes: "roll.k1" = 20.0'),
    ("[gains.roll]\nk1 = 20.0", "roll.k1", 'in quotes: "roll.k1" = 20.0'),
    ('"roll.lambda" = { low = 15, high = 1 }', "roll.lambda", "lower end must be below the upper end"),
    ('"roll.lambda" = { low = 2, high = 2 }', "roll.lambda", "fix the gain if you mean one value"),
    ('"roll.lambda" = { low = 25 }', "roll.lambda", "[25.0, 20.0]; the lower end must be below"),
    ('"roll.lambda" = { low = 0, high = 2 }', "roll.lambda", 'above 0: raise it, or write scale = "linear"'),
    ('"roll.lambda" = { scale = "lin" }', "roll.lambda", "allowed: 'linear', 'log'"),
    ('"roll.lambda" = { low = 0, scale = "linear" }', "roll.lambda", "must be above 0 s^-1"),
    ('"roll.k1" = { low = -1 }', "roll.k1", "must be at least 0 rad^(1/2) s^(-3/2)"),
    ('"roll.lambda" = 0', "roll.lambda", "must be above 0 s^-1"),
    ('"x.zeta" = -0.5', "x.zeta", "must be at least 0 1"),
    ('"roll.k1" = { tie = "roll.k2" }\n"roll.k2" = 5', "roll.k1", "write roll.k1 = 5.0 instead"),
    ('"roll.k1" = { tie = "roll.kk2" }\n"roll.k2" = {}', "roll.k1", "did you mean 'roll.k2'?"),
    ('"roll.k1" = { tie = "pitch.k1" }', "roll.k1", "unknown entry of [gains] to tie to 'pitch.k1'"),
    ('"roll.k1" = { tie = "roll.k1" }', "roll.k1", "roll.k1 -> roll.k1"),
    ('"roll.k1" = { tie = "yaw.k1" }\n"yaw.k1" = { tie = "roll.k1" }', "roll.k1", "in a circle: roll.k1 -> yaw.k1 -> roll"),
    ('"roll.k1" = { tie = "yaw.k1", low = 1 }\n"yaw.k1" = {}', "roll.k1", "leave low, high and scale out"),
    ('"tilt.k1" = 5\n"tilt.k1" = 6', None, 'correct this line: "tilt.k1" = 6'),
]  # fmt: skip


@pytest.mark.parametrize(("lines", "key", "says"), BAD_GAINS)
def test_a_bad_gain_is_refused(lines: str, key: str | None, says: str, tmp_path: Path):
    path = write(tmp_path, with_gains(lines))
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert (caught.value.file, caught.value.key) == (str(path), None if key is None else f"gains.{key}")
    assert says in caught.value.message


def test_overlapping_groups_of_one_size_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    # No two of today's groups of one size overlap, so one is added.
    from plant.quadrotor.gains import GROUPS

    monkeypatch.setitem(GROUPS, "level", ("pitch", "yaw"))
    with pytest.raises(InputError, match=r"'pitch.k1' is given by '.*' too; leave one out"):
        load_study(write(tmp_path, with_gains('"tilt.k1" = 5\n"level.k1" = 6')))


# 0.3 / 0.004 s = 75 rad/s; 0.3 / 0.005 s = 60 rad/s, below the 75 rad/s at which the usual range ends.
@pytest.mark.parametrize(
    ("period", "line", "largest", "says"),
    [
        (0.004, '"roll.omega_o" = 75.1', 75, "given 75.1 rad/s for roll.omega_o"),
        (0.004, '"roll.omega_o" = { high = 75.1 }', 75, "given 75.1 rad/s"),
        (0.004, '"roll.omega_o" = { low = 76, high = 80 }', 75, "given 76 rad/s"),
        (0.004, '"x.omega_o" = {}\n"roll.omega_o" = { tie = "x.omega_o" }\n"y.omega_o" = 80', 75, "given 80 rad/s"),
        (0.005, '"attitude.omega_o" = {}', 60, "the usual range ends at 75 rad/s"),
        (0.05, '"tilt.omega_o" = 5', 6, "the default is 10 rad/s for yaw.omega_o"),
    ],
)
def test_an_observer_too_fast_for_the_period_is_refused(
    period: float, line: str, largest: float, says: str, tmp_path: Path
):
    path = write(tmp_path, changed(LAW, f"{LAW}\ncontrol_period = {period}", with_gains(line)))
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert says in caught.value.message
    assert f"the largest allowed value is {largest} rad/s" in caught.value.message
    assert (caught.value.key or "").endswith(".omega_o")


@pytest.mark.parametrize("period", [0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007])
def test_the_largest_observer_named_is_allowed(period: float, tmp_path: Path):
    # The printed limit has six digits, so a hair less than it must pass too; 1e-6 relative.
    line = f'"attitude.omega_o" = {0.3 / period}\n"position.omega_o" = {0.3 / period * (1 - 1e-6)}'
    text = changed("duration = 2.0", f"duration = {1000 * period}", with_gains(line))
    load_study(write(tmp_path, changed(LAW, f"{LAW}\ncontrol_period = {period}", text)))


def test_an_ambiguous_pick_rule_names_its_choices(tmp_path: Path):
    twice = '[[objective]]\nmetric = "rms.x"\n\n[[objective]]\nmetric = "rms.x"\nrisk = "worst"\n\n[[constraint]]'
    ambiguous = changed("[[constraint]]", twice)
    with pytest.raises(InputError) as caught:
        load_study(write(tmp_path, changed('"knee"', '"min:rms.x"', ambiguous)))
    assert caught.value.key == "pick.rule"
    assert 'write "min:mean(rms.x)" or "min:worst(rms.x)"' in caught.value.message
    assert load_study(write(tmp_path, changed('"knee"', '"min:worst(rms.x)"', ambiguous))).pick == "min:worst(rms.x)"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[search]", "[search", "at line 43, column 8); correct this line: [search"),
        ("seed = 1", "seed = 1\nseed = 2", "at line 3, column 9); correct this line: seed = 2"),
        ('title = "Test"', "title = Test", "at line 1, column 9); correct this line: title = Test"),
    ],
)
def test_a_syntax_error_shows_line_and_column(old: str, new: str, says: str, tmp_path: Path):
    path = write(tmp_path, changed(old, new))
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert caught.value.file == str(path)
    assert says in caught.value.message


def test_a_missing_study_says_how_to_get_one(tmp_path: Path):
    with pytest.raises(InputError, match="there is no such file; `tuner new NAME` writes one") as caught:
        load_study(tmp_path / "none.toml")
    assert caught.value.file == str(tmp_path / "none.toml")


def test_a_folder_or_a_binary_file_is_no_study(tmp_path: Path):
    with pytest.raises(InputError, match="cannot be read"):
        load_study(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"title = \xff")
    with pytest.raises(InputError, match="save it as UTF-8"):
        load_study(tmp_path / "binary.toml")


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('name = "hummingbird"', 'file = "none.toml"', "airframe.file"),
        (
            'kind = "steps"\nx = 1.0\ntime = 0.5',
            'kind = "waypoints"\npath = "none.csv"',
            "scenario[0].reference.path",
        ),
    ],
)
def test_a_missing_file_beside_the_study_is_named_with_its_key(old: str, new: str, key: str, tmp_path: Path):
    path = write(tmp_path, changed(old, new))
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert (caught.value.file, caught.value.key) == (str(path), key)
    assert f"there is no file {tmp_path / 'none'}" in caught.value.message
    assert "relative to the study file" in caught.value.message


def test_an_error_in_a_file_beside_the_study_names_that_file(tmp_path: Path):
    (tmp_path / "points.csv").write_text("t,x,y,z\n0,0,0,0\n1,1,zero,0\n", encoding="utf-8")
    text = changed('kind = "steps"\nx = 1.0\ntime = 0.5', 'kind = "waypoints"\npath = "points.csv"')
    with pytest.raises(InputError) as caught:
        load_study(write(tmp_path, text))
    assert (caught.value.file, caught.value.key) == (str(tmp_path / "points.csv"), "line 3")


def test_an_unphysical_airframe_needs_the_study_to_allow_it(tmp_path: Path):
    with pytest.raises(InputError, match="triangle inequality.*allow_unphysical = true"):
        load_study(write(tmp_path, changed('"hummingbird"', '"paper-literal"')))
    load_study(write(tmp_path, changed('"hummingbird"', '"paper-literal"\nallow_unphysical = true')))


def test_the_study_that_all_these_start_from_is_good(tmp_path: Path):
    load_study(write(tmp_path, STUDY))


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("search.generatons", 3, "did you mean 'generations'?"),
        ("serach.generations", 3, "did you mean 'search'?"),
        ("scenario.1.search", 8, "'1' is no entry of this list; allowed: 0 to 0"),
        ("scenario.first.search", 8, "'first' is no entry of this list"),
        ("title.text", "x", "'title' is a value, not a table"),
        ("search.generations", "three", "this must be a whole number"),
        ("gains.roll.k9", 3, "did you mean 'k"),
        ("gains.tilt.lambda.hihg", 3, "did you mean 'high'?"),
    ],
)
def test_a_bad_override_is_refused(key: str, value: str | int, says: str, tmp_path: Path):
    path = write(tmp_path, STUDY)
    with pytest.raises(InputError) as caught:
        load_study(path, {key: value})
    assert caught.value.file == str(path)
    assert says in caught.value.message
