"""No argument of any tool leads out of the root, by whatever name: 20 files and folders outside in five forms."""

import json
import os
import re
import sys
from functools import cache
from pathlib import Path

import anyio
import pytest

from plant.errors import InputError
from tuner.cli.app import TextKind
from tuner.extensions.agents import child
from tuner.extensions.agents.answers import meaning_of
from tuner.extensions.agents.places import check_place
from tuner.extensions.agents.tools import RESULTS, command_line, commands, parameters_of

SECRET = "secret of somebody else"
NAMES = (
    "secret", "secret.toml", "gains.json", "run", "run/gains.json", "log15", "log.csv", "log.bin", "log.ulg", "quad.param",
    "quad.params", "diff_all.txt", "a=b", "a=b.toml", "x=1/study.toml", "--set=a", "mapping.toml", "a b.toml", "\u00e9.toml",
    "results",
)  # fmt: skip
"""Names outside; those without an ending are folders where another one lies below them."""
FORMS = ("absolute", "upwards", "link", "with =", "with @")
PLACES = [
    (name, label) for name in commands() for label, each in parameters_of(name).items() if each.type in (str, Path)
]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A folder with the root beside what lies outside; the root holds links to all of it."""
    home = tmp_path_factory.mktemp("agents").resolve()
    (home / "root" / "a=b").mkdir(parents=True)
    for name in NAMES:
        file = home / "outside" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if name in ("run", "results"):
            file.mkdir(exist_ok=True)
        elif not file.exists():
            file.write_text(SECRET)
    (home / "outside" / "results" / "gains.json").write_text(SECRET)
    for i, name in enumerate(NAMES):
        (home / "root" / f"link{i}").symlink_to(home / "outside" / name)
        (home / "root" / f"k=link{i}").symlink_to(home / "outside" / name)
    return home


def texts_for(home, i, name, form):
    """Texts that name the file outside in this form, for a call in the root."""
    outside = home / "outside" / name
    return {
        "absolute": [str(outside), f"/{outside}"],
        "upwards": [f"../outside/{name}", f"a=b/../../outside/{name}"],
        "link": [f"link{i}", f"./a=b/../link{i}"],
        "with =": [f"k=link{i}", f"../outside/{name}=1", f"{outside}=1"],
        "with @": [f"link{i}@70:76", f"{outside}@1:2", f"../outside/{name}@0:1.5", f"k=link{i}@1:2"],
    }[form]


def call_with(name, label, text):
    """Arguments of a call of a tool that give this text and, of all others, what is required."""
    given = {}
    for key, each in parameters_of(name).items():
        if key == label or each.is_required:
            value = text if key == label else "mine"
            given[key] = [value] if each.is_list else value
    if label == "containing":
        given["what"] = "laws"
    return given


def opened_by(text, kind):
    """All names that a command opens for a text that was let through, and those in a value of --set."""
    part = re.fullmatch(r"(.+)@[0-9.]+:[0-9.]+", text)
    value = text.partition("=")[2]
    return [text, f"{text}.toml", *([part[1]] if part and kind is TextKind.LOG else ())] + (
        [value] if kind is TextKind.CHANGE else []
    )


def is_secret(place, home):
    """Whether the system itself comes out of the root by a name."""
    try:
        found = os.stat(place)
    except OSError:
        return False
    return (found.st_dev, found.st_ino) in nodes_outside(home)


@cache
def nodes_outside(home):
    """Device and inode of all that lies outside of the root."""
    return {(each.stat().st_dev, each.stat().st_ino) for each in [home / "outside", *(home / "outside").rglob("*")]}


def accepted(home, name, label, form):
    """Texts of a form that a tool takes."""
    for i, outside in enumerate(NAMES):
        for text in texts_for(home, i, outside, form):
            kind = parameters_of(name)[label].kind
            given = f"vehicle.airframe={text}" if kind is TextKind.CHANGE else text
            try:
                command_line(name, call_with(name, label, given), home / "root")
            except InputError:
                continue
            yield given, kind


@pytest.mark.parametrize(
    "form", [pytest.param(form, marks=() if form == "upwards" else pytest.mark.slow) for form in FORMS]
)
def test_no_text_of_any_argument_is_let_through_that_the_system_follows_out_of_the_root(form, home):
    refused = 0
    for name, label in PLACES:
        taken = list(accepted(home, name, label, form))
        refused += sum(len(texts_for(home, i, each, form)) for i, each in enumerate(NAMES)) - len(taken)
        for text, kind in taken:
            for place in opened_by(text, kind):
                assert not is_secret(home / "root" / place, home), (name, label, text)
        if form in ("absolute", "upwards", "link"):
            assert not taken, (name, label, taken)
    assert refused > 20 * len(PLACES)


@pytest.mark.parametrize("folder", ["", "inner", "inner/deep"])
def test_a_folder_with_a_link_that_leaves_the_root_is_refused_and_one_with_a_link_inside_is_not(folder, tmp_path):
    root = (tmp_path / "root").resolve()
    (root / "run" / folder).mkdir(parents=True)
    (root / "mine.toml").write_text("")
    (root / "run" / folder / "kept").symlink_to(root / "mine.toml")
    assert command_line("show", {"results": "run"}, root)[-1] == "run"
    (root / "run" / folder / "flights").symlink_to(tmp_path)
    with pytest.raises(InputError, match="in which .*flights leads outside of"):
        command_line("show", {"results": "run"}, root)


def test_links_in_circles_and_links_to_nowhere_are_no_end(tmp_path):
    root = tmp_path.resolve()
    (root / "a").symlink_to(root / "b")
    (root / "b").symlink_to(root / "a")
    (root / "run").mkdir()
    (root / "run" / "again").symlink_to(root / "run")
    for text in ("a", "b/c", "run", "run/again/again"):
        check_place(text, "file", root)
    (root / "away").symlink_to(root.parent / "nobody")
    with pytest.raises(InputError, match="lies outside"):
        check_place("away", "file", root)


@pytest.mark.parametrize(
    ("name", "given", "link"),
    [
        ("run", {"study": "quickstart"}, RESULTS),
        ("autotune", {"logs": ["log"], "vehicle": "x.params", "airframe": "racer5"}, "autotune"),
        ("design", {"study": "quickstart"}, "gains.json"),
        ("import", {"parameters": "x.params", "from": "px4", "airframe": "iris"}, "vehicle.json"),
        ("export", {"gains": "mine/gains.json", "to": "c99"}, "mine/export"),
        ("new", {"name": "mine_too"}, "mine_too.toml"),
        ("new", {"name": "name", "out": "mine"}, "mine/name.toml"),
    ],
)
def test_a_place_that_a_call_does_not_name_is_followed_too(name, given, link, tmp_path):
    root = (tmp_path / "root").resolve()
    (root / "mine").mkdir(parents=True)
    assert command_line(name, given, root)
    (root / link).symlink_to(tmp_path)
    with pytest.raises(InputError, match="outside of"):
        command_line(name, given, root)


def test_names_in_a_change_are_followed_from_the_folder_of_the_study(tmp_path):
    root = (tmp_path / "root").resolve()
    (root / "sub").mkdir(parents=True)
    (root / "sub" / "away").symlink_to(tmp_path)
    given = {"study": "sub/mine.toml", "set": ["vehicle.airframe=away/x.toml"]}
    with pytest.raises(InputError, match="set: given 'away/x.toml', which lies outside"):
        command_line("run", given, root)


OURS = (sys.executable, "uname")
"""Programs of the tool: the process of figures, begun before a study is read, and what Python's `platform` starts."""
LISTENED = """import os, sys, atexit
opened = []
def listen(event, arguments):
    if event in ("open", "os.listdir", "os.scandir", "os.mkdir", "os.rename", "os.remove", "subprocess.Popen"):
        opened.append([event, str(arguments[0])])
sys.addaudithook(listen)
import json
atexit.register(lambda: json.dump(opened, open(os.environ["TUNER_TEST_OPENED"], "w")))
"""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "label"), PLACES)
def test_a_command_that_runs_opens_and_writes_nothing_outside(name, label, home, tmp_path, monkeypatch):
    monkeypatch.setenv("TUNER_TEST_OPENED", str(tmp_path / "opened.json"))
    monkeypatch.setattr(child, "python_command", listening(child.python_command))
    before = sorted((str(each), each.lstat().st_mtime_ns) for each in (home / "outside").rglob("*"))
    for form in FORMS:
        for given, _ in list(accepted(home, name, label, form))[:1]:
            arguments = command_line(name, call_with(name, label, given), home / "root")
            outcome = anyio.run(child.run_command, arguments, home / "root", False, no_progress)
            assert SECRET not in json.dumps(outcome)
            assert meaning_of(outcome) in ("done", "refused: bad input"), outcome
            for event, place in json.loads((tmp_path / "opened.json").read_text()):
                assert not is_secret(home / "root" / place, home), (event, place)
                assert event != "subprocess.Popen" or place in OURS, place
    assert before == sorted((str(each), each.lstat().st_mtime_ns) for each in (home / "outside").rglob("*"))


def listening(python_command):
    """The command of a Python whose opened files are noted."""

    def command(program, *arguments, **options):
        made = python_command(program, *arguments, **options)
        made[made.index("-c") + 1] = f"{LISTENED}\n{made[made.index('-c') + 1]}"
        return made

    return command


async def no_progress(stage, done, total):
    """Take progress."""
