"""Lines of a program that does not keep to the form: each is refused with one line that says what to do, and nothing is lost."""

import json
import random
from io import BytesIO
from types import SimpleNamespace

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.scenarios import SEARCH
from tests.tuner.extensions.trials.bench import bowls, line, made
from tuner.extensions.trials.answers import MAX_LINE_BYTES
from tuner.extensions.trials.asking import ask, lines_of, tell
from tuner.extensions.trials.problem import TrialProblem
from tuner.extensions.trials.record import REQUESTS_FILE, RESULTS_FILE, Answer, TrialRecord


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    """A run that has asked, its folder, and the trials."""
    folder = tmp_path_factory.mktemp("hostile")
    study = bowls(folder)
    return folder / "out", [trial.content() for trial in ask(study, folder / "out").trials]


def refusal(out, given):
    """Return the error of a line that is refused; nothing on record changes."""
    before = [(out / name).read_bytes() if (out / name).exists() else b"" for name in (REQUESTS_FILE, RESULTS_FILE)]
    told = tell(out, [given], "lines")
    assert (told.n_accepted, len(told.rejected)) == (0, 1), given[:200]
    assert [
        (out / name).read_bytes() if (out / name).exists() else b"" for name in (REQUESTS_FILE, RESULTS_FILE)
    ] == before
    text = str(told.rejected[0])
    assert text.isprintable()
    assert len(text) < 700
    return text


ID = "p0000-search-000"
WRONG = [
    ({"id": ID}, "has no metrics; tell"),
    ({"metrics": {"left": 1.0, "right": 1.0}}, "has no id"),
    ({"id": 3, "metrics": {}}, "has the id 3"),
    ({"id": "p9999-search-000", "metrics": {"left": 1.0, "right": 1.0}}, "unknown id 'p9999-search-000'"),
    ({"id": ID, "metrics": {"left": 1.0}}, "'right' is missing; tell left, right"),
    ({"id": ID, "metrics": {"left": 1.0, "rihgt": 1.0}}, "unknown metric 'rihgt'; did you mean 'right'"),
    ({"id": ID, "metrics": {"left": float("nan"), "right": 1.0}}, "'left' is nan; allowed: a finite number, 0 or more"),
    ({"id": ID, "metrics": {"left": float("inf"), "right": 1.0}}, "'left' is inf"),
    ({"id": ID, "metrics": {"left": -1.0, "right": 1.0}}, "'left' is -1"),
    ({"id": ID, "metrics": {"left": "1.0", "right": 1.0}}, "'left' is \"1.0\""),
    ({"id": ID, "metrics": {"left": True, "right": 1.0}}, "'left' is true"),
    ({"id": ID, "metrics": {"left": None, "right": 1.0}}, "'left' is null"),
    ({"id": ID, "metrics": {"left": 10**400, "right": 1.0}}, "'left' is too large"),
    ({"id": ID, "metrics": [1.0, 1.0]}, "'metrics' is [1.0, 1.0]"),
    ({"id": ID, "failed": "yes"}, "'failed' is \"yes\"; allowed: true or false"),
    ({"id": ID, "failed": True, "reason": 3}, "'reason' is 3; allowed: a text"),
    ({"id": ID, "failed": True, "metrics": {"left": 1.0, "right": 1.0}}, "leave one of the two out"),
    ({"id": ID, "metrisc": {}}, "unknown key 'metrisc'; did you mean 'metrics'"),
    ({"id": ID, "seed": 1, "metrics": {"left": 1.0, "right": 1.0}}, "'seed' is 1, and asked was"),
    ({"id": ID, "variables": {"x": 0.0}, "metrics": {"left": 1.0, "right": 1.0}}, "tell what that trial gave"),
]


@pytest.mark.parametrize(("given", "said"), WRONG, ids=[said[:30] for _, said in WRONG])
def test_a_wrong_line_is_refused_with_what_is_allowed(begun, given, said):
    text = refusal(begun[0], json.dumps(given))
    assert said in text
    assert text.startswith("lines, line 1: ")
    if given.get("id") == ID:
        assert ID in text


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (b"hello", "'hello' is not JSON"),
        (b"\xff\xfe{}", "is not UTF-8 text"),
        (b"[1, 2]", "given [1, 2]; each line is"),
        (b"null", "given null"),
        (b'{"id": "a", "id": "b"}', "the key 'id' occurs twice"),
        (b"[" * 100_000, "is not JSON"),
        (b"9" * 5000, "is not JSON"),
        (b'{"id": "' + b"a" * MAX_LINE_BYTES + b'"}', f"is longer than {MAX_LINE_BYTES:,} bytes"),
        (b'{"id": "\\u001b[2J\\u202e"}', "unknown id"),
    ],
    ids=lambda value: repr(value)[:30],
)
def test_what_is_no_answer_at_all_is_refused(begun, given, said):
    assert said in refusal(begun[0], given)


def spoiled(draw, good):
    """Return a good line with some of its bytes changed, left out, doubled or cut off."""
    content = bytearray(good.encode())
    for _ in range(draw.randint(1, 4)):
        place = draw.randrange(len(content))
        match draw.randrange(5):
            case 0:
                content[place] = draw.randrange(256)
            case 1:
                del content[place]
            case 2:
                content[place:place] = content[draw.randrange(place + 1) : place]
            case 3:
                content[place:] = b""
            case _:
                content[place:place] = bytes(draw.randrange(256) for _ in range(draw.randint(1, 20)))
        if not content:
            break
    return bytes(content).replace(b"\n", b" ")


def test_two_hundred_spoiled_lines_are_refused_and_the_good_ones_taken(tmp_path):
    """A spoiled line may still be one that tells something, with another number for instance: then it is taken, and as it says."""
    study, out = bowls(tmp_path), tmp_path / "out"
    trials = [trial.content() for trial in ask(study, out).trials]
    draw, kept = random.Random(5), []
    lines = [spoiled(draw, line(draw.choice(trials), made)) for _ in range(200)]
    told = tell(out, lines, "lines")
    blank = sum(not given.strip() for given in lines)
    assert told.n_accepted + told.n_duplicates + len(told.rejected) + blank == 200
    assert len(told.rejected) > 150
    for error in told.rejected:
        assert isinstance(error, InputError)
        assert str(error).isprintable()
        assert len(str(error)) < 700
    rest = [line(trial.content(), made) for trial in ask(study, out).trials[: told.n_pending]]
    assert tell(out, rest, "lines").rejected == []
    kept = [json.loads(entry) for entry in (out / RESULTS_FILE).read_text().splitlines()]
    assert len(kept) == 16 == len({entry["id"] for entry in kept})


def test_told_twice_is_ignored_and_told_otherwise_refused(tmp_path):
    study, out = bowls(tmp_path), tmp_path / "out"
    trial = ask(study, out).trials[0].content()
    good = line(trial, made)
    assert tell(out, [good], "lines").n_accepted == 1
    before = (out / RESULTS_FILE).read_bytes()
    told = tell(out, [good, json.dumps({**trial, "metrics": made(trial)})], "lines")
    assert (told.n_accepted, told.n_duplicates, told.rejected) == (0, 2, [])
    other = refusal(out, json.dumps({"id": trial["id"], "metrics": {"left": 1.0, "right": 2.0}}))
    assert f"{trial['id']}: was submitted before as" in other
    assert "the first result stays" in other
    assert (out / RESULTS_FILE).read_bytes() == before


def test_late_is_what_was_given_up_before(tmp_path):
    """A trial of which nothing came is told to have failed, so that the run goes on; what comes after all is refused."""
    study, out = bowls(tmp_path), tmp_path / "out"
    trials = [trial.content() for trial in ask(study, out).trials]
    given_up = json.dumps({"id": trials[0]["id"], "failed": True, "reason": "no answer for an hour"})
    assert tell(out, [given_up, *[line(trial, made) for trial in trials[1:]]], "lines").n_accepted == 16
    following = ask(study, out).trials
    assert trials[0]["id"] not in {trial.id for trial in following}
    late = refusal(out, line(trials[0], made))
    assert f"{trials[0]['id']}: was submitted before as failed (no answer for an hour), and now as" in late
    assert ask(study, out).trials == following


def test_of_a_line_that_is_too_long_one_part_is_given_and_the_next_line_whole():
    source = BytesIO(b"x" * (3 * MAX_LINE_BYTES) + b"\nnext\n" + b"y" * (MAX_LINE_BYTES + 5) + b"\nlast")
    lines = list(lines_of(source))
    assert [line[:4] for line in lines] == [b"xxxx", b"next", b"yyyy", b"last"]


def test_candidates_keep_their_numbers_where_survivors_make_more_trials(tmp_path):
    study = bowls(tmp_path)
    (tmp_path / "r").mkdir()
    record, batch = TrialRecord(tmp_path / "r"), SimpleNamespace(stream=SEARCH)

    def answer(trials):
        for trial in trials:
            record.tell(answer_of(trial))

    problem = TrialProblem(study, record, answer)
    flown = np.empty((0, 0))
    for rows, first, last in (([[0.1, 0.2], [0.3, 0.4]], 0, 1), ([[0.3, 0.4]], 1, 2), ([[0.5, 0.6]], 0, 1)):
        problem.scored(np.array(rows), flown, batch, first, last)  # pyright: ignore[reportArgumentType]
    assert list(record.trials) == ["p0000-search-000", "p0001-search-000", "p0001-search-001", "p0002-search-000"]


def answer_of(trial):
    return Answer(id=trial.id, metrics=made(trial.content()))
