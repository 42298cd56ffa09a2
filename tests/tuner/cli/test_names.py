"""Studies by name, copies of studies, completion, the version, `python -m tuner`, and files that hide our packages."""

import json
import os
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

from plant.errors import InputError, UnknownNameError
from plant.law_registry import LAWS
from plant.laws.law_text import law_text
from tests.tuner.in_process import called, tuner
from tests.tuner.study.study_text import STUDY, changed
from tuner.study.build import load_study
from tuner.study.files import SHIPPED, shipped_studies, study_file
from tuner.study.kinds import load_any
from tuner.study.template import copied_study
from tuner.text.toml_text import with_paths

ROOT = Path(__file__).parents[3]
QUICKSTART = SHIPPED / "quickstart.toml"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_path_wins_over_a_file_of_the_name_and_that_over_a_shipped_study(here):
    assert study_file(Path("quickstart")) == QUICKSTART
    (here / "quickstart").mkdir()
    assert study_file(Path("quickstart")) == QUICKSTART
    (here / "quickstart.toml").write_text(STUDY)
    assert study_file(Path("quickstart")) == Path("quickstart.toml")
    (here / "quickstart").rmdir()
    (here / "quickstart").write_text(STUDY)
    assert study_file(Path("quickstart")) == Path("quickstart")


def test_what_is_no_study_is_told_with_the_nearest(here):
    with pytest.raises(UnknownNameError, match="unknown study 'quikstart'; did you mean 'quickstart'"):
        study_file(Path("quikstart"))
    for missing in ("studies/f450.toml", "f450.toml"):
        with pytest.raises(InputError, match=f"^{missing}: there is no such file; `f450` alone"):
            study_file(Path(missing))
    # Nothing is known of this one: who reads it says what is wrong.
    assert study_file(Path("nowhere.toml")) == Path("nowhere.toml")


@pytest.mark.parametrize(
    "words",
    [
        ["run"],
        ["design"],
        ["plan"],
        ["sensitivity"],
        ["check"],
        ["new", "mine", "--from"],
        ["fly", "--law", "pid", "--study"],
        ["margins", "--law", "pid", "--study"],
        ["theory", "gains.json", "--study"],
        ["check", "gains.json", "--requirements"],
        ["rejudge", "results", "--out", "other", "--study"],
        ["compare", "gains.json", "--study"],
    ],
    ids=lambda words: " ".join(words),
)
def test_every_command_takes_a_study_by_name(here, words, monkeypatch, capsys):
    code, out, error = tuner(monkeypatch, capsys, *words, "quikstart")
    assert (code, out) == (2, "") and "did you mean 'quickstart'" in error and error.count("\n") == 1


@pytest.mark.parametrize("path", shipped_studies().values(), ids=lambda path: path.stem)
def test_a_copy_of_a_shipped_study_is_the_study_with_its_comments(here, path):
    copy, original = copied_study(path, here / "mine.toml"), path.read_text()

    def away(name):
        return name if name.endswith(".py") else Path(os.path.relpath(path.parent / name, here)).as_posix()

    moved = with_paths(tomllib.loads(original), away)
    assert tomllib.loads(copy) == moved
    assert copy.count("#") == original.count("#")
    assert f"studies/{path.name}" not in copy and "tuner run mine.toml" in copy


def test_code_of_a_shipped_study_is_copied_along_and_never_written_over(here, monkeypatch, capsys):
    assert [tuner(monkeypatch, capsys, "new", name, "--from", "own_law")[0] for name in ("mine", "second")] == [0, 0]
    assert load_study(here / "mine.toml").digest() == load_study(SHIPPED / "own_law.toml").digest()
    own = here / "own_law" / "mae.py"
    own.write_text(own.read_text() + "# mine\n")
    code, _, error = tuner(monkeypatch, capsys, "new", "third", "--from", "own_law")
    assert code == 2 and "mae.py exists already and was not touched" in error
    assert own.read_text().endswith("# mine\n") and not (here / "third.toml").exists()


def test_an_own_study_is_copied_with_its_paths_and_comments(here):
    (here / "far").mkdir()
    own = changed('name = "hummingbird"', 'file = "quad.toml"')
    (here / "quad.toml").write_text((ROOT / "plant" / "quadrotor" / "airframes" / "iris.toml").read_text())
    (here / "own.toml").write_text(f"# Run it with `tuner run own.toml`; results land in results/own.\n{own}")
    copy = here / "far" / "copy.toml"
    copy.write_text(copied_study(here / "own.toml", copy))
    first, *others = copy.read_text().splitlines()
    assert first == "# Run it with `tuner run copy.toml`; results land in results/copy."
    assert 'file = "../quad.toml"' in others
    assert load_study(copy).digest() == load_study(here / "own.toml").digest()


def test_a_path_that_text_cannot_replace_is_refused(here):
    (here / "far").mkdir()
    (here / "own.toml").write_text(changed('name = "hummingbird"', "file = 'quad.toml'"))
    with pytest.raises(InputError, match="copy the file and change them by hand"):
        copied_study(here / "own.toml", here / "far" / "copy.toml")


def test_a_base_beside_the_file_wins_over_a_shipped_one(here):
    (here / "mine.toml").write_text('base = "contest.toml"\n')
    assert load_any(here / "mine.toml").title == load_any(SHIPPED / "contest.toml").title
    (here / "contest.toml").write_text('base = "paper_table3.toml"\ntitle = "ours"\n')
    assert load_any(here / "mine.toml").title == "ours"


def test_what_lies_about_does_not_hinder_the_list(here, monkeypatch, capsys):
    (here / "broken.toml").write_text("= 3")
    (here / "other.toml").write_bytes(b"\xff\xfe")
    (here / "project.toml").write_text("[project]\n")
    (here / "mine.toml").write_text(STUDY)
    os.mkfifo(here / "pipe.toml")
    rows = json.loads(tuner(monkeypatch, capsys, "list", "studies", "--json")[1])
    assert [row["study"] for row in rows if not row["shipped"]] == ["mine.toml"]


@pytest.mark.parametrize(
    ("words", "kept"),
    [(["laws", "LINEAR ADRC"], "ladrc"), (["metrics", "settl"], "settling"), (["airframes", "Iris"], "iris")],
)
def test_a_filter_keeps_the_rows_that_hold_it(words, kept, monkeypatch, capsys):
    every = json.loads(tuner(monkeypatch, capsys, "list", words[0], "--json")[1])
    some = json.loads(tuner(monkeypatch, capsys, "list", *words, "--json")[1])
    assert some == [
        row for row in every if words[1].lower() in json.dumps(list(row.values()), ensure_ascii=False).lower()
    ]
    assert 0 < len(some) < len(every) and any(kept in row.values() for row in some)


@pytest.mark.parametrize("law", [*LAWS])
def test_a_law_by_its_name_is_alone_with_its_equations(law, monkeypatch, capsys):
    rows = json.loads(tuner(monkeypatch, capsys, "list", "laws", law.upper(), "--json")[1])
    assert {row["law"] for row in rows} == {law}
    text = law_text(LAWS[law])
    assert f"{text.equations}\n{text.use}\n" in tuner(monkeypatch, capsys, "list", "laws", law)[1]


def test_a_filter_that_nothing_holds_says_so(monkeypatch, capsys):
    assert tuner(monkeypatch, capsys, "list", "laws", "zzz") == (0, "No laws with 'zzz'.\n", "")


def test_the_version(monkeypatch, capsys):
    assert tuner(monkeypatch, capsys, "--version") == (0, f"{version('gainproof')}\n", "")


def python(*arguments, cwd, **environment):
    given = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    words = [sys.executable, *arguments]
    return subprocess.run(words, cwd=cwd, env=given, capture_output=True, text=True, timeout=300, check=False)


def test_the_package_runs_as_a_module(tmp_path):
    done = python("-m", "tuner", "list", "risks", "--json", cwd=tmp_path)
    assert done.returncode == 0 and "cvar" in {row["risk"] for row in json.loads(done.stdout)}
    assert python("-m", "tuner", "--help", cwd=tmp_path).stdout.startswith("Usage: tuner ")


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (["run", "qui"], ["quickstart"]),
        (["new", "mine", "--from", "f4"], ["f450"]),
        (["fly", "--law", "hybrid_t"], ["hybrid_true_sta"]),
        (["margins", "--airframe", "ir"], ["iris"]),
        (["export", "gains.json", "--to", "cr"], ["crazyflie"]),
        (["import", "file", "--from", "px"], ["px4"]),
        (["list", "theo"], ["theorems"]),
        (["sens"], ["sensitivity"]),
        (["check", "mi"], ["mine.toml"]),
    ],
    ids=" ".join,
)
def test_the_shell_completes_names(here, words, offered, monkeypatch):
    (here / "mine.toml").write_text(STUDY)
    monkeypatch.setenv("_TUNER_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", " ".join(["tuner", *words]))
    monkeypatch.setenv("COMP_CWORD", str(len(words)))
    _, out, errors = called()
    assert (out.split(), errors) == (offered, "")


@pytest.mark.parametrize("name", ["plant.py", "objectives.py", "plant/__init__.py", "objectives/__init__.py"])
def test_a_file_that_hides_a_package_of_ours_is_named(tmp_path, name):
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text("mass = 1.0\n")
    done = python("-c", "import tuner.experiments.tuning.run", cwd=tmp_path)
    package = Path(name).parts[0].removesuffix(".py")
    last = done.stderr.splitlines()[-1]
    assert (
        last
        == f"ImportError: {file} hides the package '{package}' of gainproof; rename that file, or start in another folder"
    )
    # As a module the message stands alone.
    done = python("-m", "tuner", "list", "risks", cwd=tmp_path)
    assert done.returncode != 0 and str(file) in done.stderr and done.stderr.count("\n") == 1
    # A script that has its own module loaded already is told the same.
    done = python("-c", f"import {package}, tuner", cwd=tmp_path)
    assert last == done.stderr.splitlines()[-1]


@pytest.mark.parametrize(
    "name", ["plant/notes.txt", *(pytest.param(name, marks=pytest.mark.slow) for name in ("studies.py", "cli.py"))]
)
def test_other_files_hide_nothing(tmp_path, name):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("raise SystemExit\n")
    done = python("-c", "import tuner.study", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
