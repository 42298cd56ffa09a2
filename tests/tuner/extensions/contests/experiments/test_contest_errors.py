"""What can be wrong with a contest file: each error names the file and the key that a person has to change."""

import pytest

from plant.errors import InputError
from tests.tuner.extensions.contests.experiments.contest_text import CONTEST, changed, write
from tuner.study.kinds import load_any

SHARED = CONTEST.split("[[contender]]", 1)[0]
FAULTS = {
    "empty list": (None, f"contender = []\n{SHARED}", "contender", r"at least one \[\[contender\]\]"),
    "single brackets": (None, f'{SHARED}[contender]\nname = "PID"\n', "contender", r"\[\[contender\]\]"),
    "no name": ('name = "LADRC"\n', "", "contender[2].name", "required and missing"),
    "empty name": ('name = "LADRC"', 'name = " "', "contender[2].name", "with a letter or digit"),
    "same name": ('name = "LADRC"', 'name = "pid!"', "contender[2].name", r"'PID' of contender\[0\]"),
    "own seed": ('name = "LADRC"\n', 'name = "LADRC"\nseed = 4\n', "contender[2].seed", "same for all"),
    "own scenario": (
        "[[published]]\ncontender = \"PID\"", '[[contender.scenario]]\nname = "x"\n[[published]]\ncontender = "PID"',
        "contender[2].scenario", "same for all",
    ),
    "own objective": ('name = "LADRC"\n', 'name = "LADRC"\nobjective = []\n', "contender[2].objective", "same for all"),
    "own constraint": ('name = "LADRC"\n', 'name = "LADRC"\nconstraint = []\n', "contender[2].constraint", "same for all"),
    "probability": (
        'metric = "failure"\nmax = 0.0', 'metric = "failure"\nrisk = "probability"\nmax = 0.01', "constraint[0].risk",
        'in a contest write risk = "mean"',
    ),
    "misspelt table": (
        'airframe = { name = "f450" }', 'airfram = { name = "f450" }', "contender[2].airfram", "did you mean 'airframe'",
    ),
    "table as value": ('airframe = { name = "f450" }', 'airframe = "f450"', "contender[2].airframe", "must be a table"),
    "unknown law": (
        'controller = { attitude = "ladrc" }', 'controller = { attitude = "ladcr" }', "contender[2].controller.attitude",
        "did you mean 'ladrc'",
    ),
    "unknown airframe": ('name = "f450"', 'name = "f405"', "contender[2].airframe.name", "did you mean 'f450'"),
    "gain of another law": (
        '"attitude.omega_c" = 0.3', '"attitude.kp" = 6.0', "contender[2].gains.attitude.kp", "unknown gain 'kp'",
    ),
    "gain out of range": (
        '"attitude.omega_c" = 0.3', '"attitude.omega_c" = -6.0', "contender[2].gains.attitude.omega_c", "above 0",
    ),
    "unquoted gain": (
        '"attitude.kd" = 14.0', "attitude.kd = 14.0", "contender[0].gains.attitude.kd", "write it in quotes",
    ),
    "empty range": ("high = 200.0", "high = 10.0", "contender[0].gains.attitude.kp", "below the upper end"),
    "own period": (
        'attitude = "pid", position = "pid"', 'attitude = "pid", position = "pid", control_period = 0.002',
        "contender[0].controller.control_period", "same for all",
    ),
    "shared scenario": ("duration = 1.2", "duration = -1.2", "scenario[1].duration", "positive"),
    "shared gain that a contender inherits": (
        '"attitude.lambda" = 7.0', '"attitude.lambdaa" = 7.0', "gains.attitude.lambdaa", "unknown gain",
    ),
    "shared search": ("population = 8", "population = 9", "search.population", "must be even"),
    "missing title": ('title = "Test"\n', "", "title", "required and missing"),
    "top-level key": ("seed = 3", "seed = 3\nsede = 4", "sede", "did you mean 'seed'"),
    "published of nobody": ('contender = ["PID", "LADRC"]', 'contender = ["PID", "ADRC"]', "published[0].contender", "'LADRC'"),
    "published twice": ('contender = ["PID", "LADRC"]', 'contender = ["PID", "PID"]', "published[0].contender", "twice"),
    "published metric": ("value = 0.2", 'value = 0.2\nmetrik = "x"', "published[0].metrik", "did you mean 'metric'"),
    "published value": ("value = 0.2", 'value = "0.2"', "published[0].value", "a number"),
    "published without value": ("value = 0.2\n", "", "published[0].value", "required and missing"),
    "published scenario": (
        'scenario = "gusts"\nvalue = 0.2', 'scenario = "gust"\nvalue = 0.2', "published[0].scenario", "did you mean 'gusts'",
    ),
    "published metric without meaning": (
        'metric = "peak.roll"\nscenario = "gusts"\nvalue = 0.2', 'metric = "rise.yaw"\nscenario = "calm"\nvalue = 0.2',
        "published[0].metric", "needs a step",
    ),
    "claim of nobody": ('better = "LADRC"', 'better = "ADRC"', "claim[0].better", "did you mean 'LADRC'"),
    "claim against nobody": ('than = "PID"', 'than = "PI"', "claim[0].than", "did you mean 'PID'"),
    "claim against itself": ('than = "PID"', 'than = "LADRC"', "claim[0].than", "better than itself"),
    "claim in nothing": ('in = ["itae.position", "peak.roll", "rms.yaw"]', "in = []", "claim[0].in", "given an empty list"),
    "claim without in": ('in = ["itae.position", "peak.roll", "rms.yaw"]\n', "", "claim[0].in", "required and missing"),
    "claim metric": ('"rms.yaw"', '"rms.yav"', "claim[0].in", "did you mean 'rms.yaw'"),
    "claim scenario": ('text = "LADRC is better"', 'scenario = "storm"', "claim[0].scenario", "valid: calm, gusts"),
    "base is no text": ("seed = 3", "seed = 3\nbase = 4", "base", 'write base = "other.toml"'),
    "base is missing": ("seed = 3", 'seed = 3\nbase = "nowhere.toml"', "base", "there is no file"),
    "base is itself": ("seed = 3", 'seed = 3\nbase = "contest.toml"', "base", "in a circle"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_an_error_names_file_and_key(tmp_path, fault):
    old, new, key, words = FAULTS[fault]
    path = write(tmp_path, new if old is None else changed(old, new))
    with pytest.raises(InputError, match=words) as caught:
        load_any(path)
    assert (caught.value.file, caught.value.key) == (str(path), key)
    assert str(caught.value).startswith(f"{path}: {key}: ")


def test_an_error_in_a_base_names_the_base(tmp_path):
    shared = write(tmp_path, changed("population = 8", "population = 9", SHARED), "shared.toml")
    path = write(tmp_path, 'base = "shared.toml"\n[search]\ngenerations = 4\n[[contender]]\nname = "A"\n')
    with pytest.raises(InputError, match="must be even") as caught:
        load_any(path)
    assert (caught.value.file, caught.value.key) == (str(shared), "search.population")


def test_a_probability_in_a_base_is_refused_there(tmp_path):
    limit = 'metric = "failure"\nrisk = "probability"\nmax = 0.01'
    shared = write(tmp_path, changed('metric = "failure"\nmax = 0.0', limit, SHARED), "shared.toml")
    path = write(tmp_path, 'base = "shared.toml"\n[[contender]]\nname = "A"\n')
    with pytest.raises(InputError, match='given "probability"') as caught:
        load_any(path)
    assert (caught.value.file, caught.value.key) == (str(shared), "constraint[0].risk")


def test_an_error_in_what_lies_over_a_base_names_the_upper_file(tmp_path):
    write(tmp_path, SHARED, "shared.toml")
    path = write(tmp_path, 'base = "shared.toml"\n[search]\npopulation = 9\n[[contender]]\nname = "A"\n')
    with pytest.raises(InputError, match="must be even") as caught:
        load_any(path)
    assert (caught.value.file, caught.value.key) == (str(path), "search.population")


def test_a_circle_of_two_files_is_told(tmp_path):
    write(tmp_path, 'base = "contest.toml"\n', "other.toml")
    path = write(tmp_path, 'base = "other.toml"\n[[contender]]\nname = "A"\n')
    with pytest.raises(InputError, match="circle: .*contest.toml -> .*other.toml -> .*contest.toml"):
        load_any(path)
