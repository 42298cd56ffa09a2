"""Forty ways to have a stranger's code run: none of it runs unless the user names it.

Each way is what a stranger hands over, and what a user types. The code leaves a mark where it runs.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from plant.own_code import HAVE_RUN, run_own_code
from tests.tuner.extensions.fmu.fmus import write_archive
from tests.tuner.in_process import tuner as in_this_process
from tuner.text.errors import code_announced

ANNOUNCED = code_announced
STUDIES = Path(__file__).parents[3] / "studies"
RECORD = '{"format": "gainproof-run", "version": 3, "kind": "plant", "study": "inputs/x.toml", "digest": "0", '
RECORD += '"generations": 1, "model": "0"}'
LAW = 'title = "t"\n[law]\nfile = "evil.py"\n[airframe]\nname = "hummingbird"\n'
METRIC, REFERENCE = LAW.replace("[law]", "[metric]"), LAW.replace("[law]", "[reference]")


class Stranger:
    """A folder of a stranger's below which a user works. mark: the file that its code would leave."""

    def __init__(self, home: Path) -> None:
        self.home, self.mark = home, home / "it_ran"
        self.evil = f"__import__('pathlib').Path({str(self.mark)!r}).touch()\n"
        self.plant = self.evil + (STUDIES / "dc_motor.py").read_text()
        self.study = (STUDIES / "dc_motor.toml").read_text()

    def write(self, name: str, text: str) -> Path:
        file = self.home / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def folder(
        self, name: str = "r", record: str = "run.json", study: str | None = None, code: str | None = None
    ) -> None:
        """Write a results folder with its study and code."""
        if record:
            self.write(f"{name}/{record}", RECORD)
        self.write(f"{name}/inputs/x.toml", (study or self.study).replace("dc_motor.py", "evil.py"))
        self.write(f"{name}/inputs/evil.py", code or self.plant)

    def link(self, name: str, target: str) -> None:
        (self.home / name).parent.mkdir(parents=True, exist_ok=True)
        (self.home / name).symlink_to(target)


def results(record="run.json", **named):
    return lambda stranger: stranger.folder(record=record, **named)


def study_at(name, code, study=None):
    """A study of the user's folder that names code elsewhere in a results folder."""

    def make(stranger):
        stranger.folder()
        stranger.write(name, (study or stranger.study).replace("dc_motor.py", code))

    return make


def linked_folder(stranger):
    stranger.folder()
    stranger.link("inputs", "r/inputs")


def linked_study(stranger):
    stranger.folder()
    stranger.link("x.toml", "r/inputs/x.toml")
    stranger.link("evil.py", "r/inputs/evil.py")


def linked_code(stranger):
    stranger.folder()
    stranger.write("x.toml", stranger.study)
    stranger.link("dc_motor.py", "r/inputs/evil.py")


def linked_import(stranger):
    stranger.folder(code=stranger.evil)
    stranger.write("x.toml", stranger.study)
    stranger.write("dc_motor.py", "import helper\n" + (STUDIES / "dc_motor.py").read_text())
    stranger.link("helper.py", "r/inputs/evil.py")


def linked_outside(stranger):
    (outside := stranger.home.parent / "shared").mkdir(exist_ok=True)
    (outside / "evil.py").write_text(stranger.plant)
    stranger.write("x.toml", stranger.study)
    stranger.link("dc_motor.py", "../shared/evil.py")


def upwards(code):
    def make(stranger):
        (outside := stranger.home.parent / "shared").mkdir(exist_ok=True)
        (outside / "evil.py").write_text(stranger.plant)
        named = str(outside / "evil.py") if code == "ABSOLUTE" else code
        stranger.write("x.toml", stranger.study.replace("dc_motor.py", named))

    return make


def contest(stranger, code="evil.py"):
    base = f'title = "t"\nbase = "quickstart.toml"\n[[contender]]\nname = "a"\n[contender.law]\nfile = "{code}"\n'
    stranger.folder(study=base + '[[contender]]\nname = "b"\n')


def contest_base(stranger):
    stranger.folder()
    text = 'title = "t"\nbase = "r/inputs/x.toml"\n[[contender]]\nname = "a"\n[[contender]]\nname = "b"\n'
    stranger.write("c.toml", text)


def contest_nested(stranger):
    stranger.folder("r/contenders/a")
    stranger.write("r/run.json", RECORD.replace('"plant"', '"contest"'))


def fmu(recorded):
    def make(stranger):
        text = stranger.study.replace('file = "dc_motor.py"', 'fmu = "evil.fmu"')
        stranger.folder(study=text, record="run.json" if recorded else "summary.json")
        write_archive(
            stranger.home / "r/inputs/evil.fmu", {"modelDescription.xml": b"<a/>", "binaries/linux64/a.so": b"x"}
        )

    return make


def packaged(stranger):
    """An installed package, as a search path with the working folder would see it, that offers a law."""
    stranger.write("evil_pack.py", stranger.evil + "LAW = None\n")
    stranger.write("evil_pack-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: evil-pack\nVersion: 1.0\n")
    stranger.write("evil_pack-1.0.dist-info/entry_points.txt", "[gainproof.laws]\nevil = evil_pack:LAW\n")


def shadows(name):
    return lambda stranger: stranger.write(name, stranger.evil)


def airframe_beside(stranger):
    stranger.folder(study='title = "t"\n[airframe]\nfile = "evil.py"\n')


def default_beside(stranger):
    stranger.folder(study='title = "t"\n[airframe]\nname = "hummingbird"\n[controller]\ndefault = "evil.py"\n')


def gains_beside(stranger):
    stranger.folder()
    stranger.write("r/gains.json", '{"format": "gainproof-plant-gains", "version": "0.1"}')


# What a stranger hands over, and what a user types.
CHECK = ("check", "r/inputs/x.toml")
WAYS = {
    "check": (results(), CHECK), "run": (results(), ("run", "r/inputs/x.toml", "--out", "o")),
    "plan": (results(), ("plan", "r/inputs/x.toml")), "resume": (results(), ("resume", "r")), "verify": (results(), ("verify", "r")),
    "rejudge": (results(), ("rejudge", "r", "--out", "o")), "report": (results(), ("report", "r")), "show": (results(), ("show", "r")),
    "compare": (results(), ("compare", "r", "r")), "sensitivity": (results(), ("sensitivity", "r/inputs/x.toml")),
    "design": (results(), ("design", "r/inputs/x.toml")), "theory": (results(), ("theory", "r/gains.json")),
    "reuse": (results(), ("run", "quickstart", "--reuse", "r", "--set", "search.population=3")),
    "export": (gains_beside, ("export", "r/gains.json", "--to", "c99")), "margins": (gains_beside, ("margins", "r/gains.json")),
    "fly": (gains_beside, ("fly", "r/gains.json")), "validate": (gains_beside, ("validate", "r/gains.json")),
    "law": (results(study=LAW), CHECK), "metric": (results(study=METRIC), CHECK), "reference": (results(study=REFERENCE), CHECK),
    "copied study": (results(), ("new", "n", "--from", "r/inputs/x.toml")),
    "copied study without run.json": (results(""), ("new", "n", "--from", "r/inputs/x.toml")),
    "no run.json but manifest.json": (results("manifest.json"), CHECK), "but resolved.json": (results("resolved.json"), CHECK),
    "but environment.json": (results("environment.json"), CHECK), "but summary.json": (results("summary.json"), CHECK),
    "but flights": (results("flights/a-1.npz"), CHECK), "but contest.json": (results("contest.json"), CHECK),
    "named from a study beside": (study_at("x.toml", "r/inputs/evil.py"), ("check", "x.toml")),
    "named round about": (study_at("x.toml", "r/../r/inputs/../inputs/evil.py"), ("check", "x.toml")),
    "named from deep below": (study_at("a/b/x.toml", "../../r/inputs/evil.py"), ("check", "a/b/x.toml")),
    "linked folder": (linked_folder, ("check", "inputs/x.toml")), "linked study": (linked_study, ("check", "x.toml")),
    "linked code": (linked_code, ("check", "x.toml")), "linked import": (linked_import, ("check", "x.toml")),
    "link to a shared folder": (linked_outside, ("check", "x.toml")), "upwards": (upwards("../shared/evil.py"), ("check", "x.toml")),
    "an absolute path": (upwards("ABSOLUTE"), ("check", "x.toml")), "contest": (contest, CHECK),
    "code of a contender that lies elsewhere": (lambda each: contest(each, "../inputs/evil.py"), CHECK),
    "base of a contest": (contest_base, ("check", "c.toml")), "contender": (contest_nested, ("resume", "r/contenders/a")),
    "FMU": (fmu(True), CHECK), "FMU without run.json": (fmu(False), CHECK), "airframe": (airframe_beside, CHECK),
    "default gains": (default_beside, CHECK),
}  # fmt: skip
PROCESSES = {
    "entry point": (packaged, ("list", "laws", "evil")), "rich.py": (shadows("rich.py"), ("list", "laws")),
    "numpy.py": (shadows("numpy.py"), ("list", "laws")), "plant/__init__.py": (shadows("plant/__init__.py"), ("list", "laws")),
    "sitecustomize.py": (shadows("sitecustomize.py"), ("list", "laws")),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_nothing_of_a_stranger_runs_that_the_user_has_not_named(way, tmp_path, monkeypatch, capsys):
    (home := tmp_path / "work").mkdir()
    make, words = WAYS[way]
    make(stranger := Stranger(home))
    monkeypatch.chdir(home)
    _, _, err = in_this_process(monkeypatch, capsys, *words)
    assert not stranger.mark.exists() and not HAVE_RUN and "Traceback" not in err, err
    if (home / "n.toml").exists():
        in_this_process(monkeypatch, capsys, "check", "n.toml")
        assert not stranger.mark.exists()


@pytest.mark.parametrize(
    "way", [pytest.param(way, marks=() if way == "numpy.py" else pytest.mark.slow) for way in PROCESSES]
)
def test_nothing_in_the_working_folder_is_imported(way, tmp_path):
    make, words = PROCESSES[way]
    make(stranger := Stranger(tmp_path))
    done = subprocess.run(
        [sys.executable, "-m", "tuner", *words], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert not stranger.mark.exists() and "Traceback" not in done.stderr, done.stderr


def test_the_ways_lead_to_the_code_where_the_user_names_it(tmp_path, monkeypatch, capsys):
    """Else all of the above would pass for nothing."""
    monkeypatch.chdir(tmp_path)
    results()(stranger := Stranger(tmp_path))
    code, _, err = in_this_process(monkeypatch, capsys, "check", "r/inputs/x.toml", "--code", "r/inputs/evil.py")
    assert stranger.mark.exists() and code == 0, err
    stranger.mark.unlink()
    assert (
        in_this_process(monkeypatch, capsys, "new", "n", "--from", "r/inputs/x.toml", "--code", "r/inputs/evil.py")[0]
        == 0
    )


def test_code_that_a_study_names_is_named_with_its_digest_before_it_runs(tmp_path, monkeypatch):
    shutil.copy(STUDIES / "dc_motor.py", tmp_path / "dc_motor.py")
    (tmp_path / "helper.py").write_text("")
    (tmp_path / "main.py").write_text("import helper\nraise ValueError('it has run')\n")
    heard: list[str] = []
    monkeypatch.setattr("plant.own_code.ANNOUNCEMENTS", [lambda digest, sentence: heard.append(sentence)])
    with pytest.raises(Exception, match="it has run"):
        run_own_code(tmp_path / "main.py", tmp_path / "x.toml")
    assert len(heard) == 1 and all(name in heard[0] for name in ("main.py", "helper.py", "x.toml", "digest"))
    run_own_code(tmp_path / "dc_motor.py", tmp_path / "x.toml")
    run_own_code(tmp_path / "dc_motor.py", tmp_path / "y.toml")
    assert len(heard) == 2, "once for a digest"


def test_the_line_stands_once_for_a_user(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("tuner.text.errors.code_announced", ANNOUNCED)
    monkeypatch.setenv("TUNER_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    for name in ("dc_motor.py", "dc_motor.toml"):
        shutil.copy(STUDIES / name, tmp_path / name)
    (tmp_path / "dc_motor.py").write_text((tmp_path / "dc_motor.py").read_text() + "# mine\n")
    lines = []
    for _ in range(2):
        HAVE_RUN.clear()
        code, _, err = in_this_process(monkeypatch, capsys, "check", "dc_motor.toml")
        assert code == 0
        lines.append([line for line in err.splitlines() if "runs code" in line])
    assert [len(each) for each in lines] == [1, 0] and "dc_motor.py (digest " in lines[0][0]
