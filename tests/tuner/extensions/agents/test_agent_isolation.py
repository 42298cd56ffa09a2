"""Commands of agents import nothing from the root, and a command that crashes is no verdict."""

import ast
import json
import os
import signal
import subprocess
import sys

import anyio
import pytest

from plant.python_process import HOME, SAFE_PATH, python_command, without_working_folder
from tests.tuner.extensions.agents.test_agent_places import no_progress
from tuner.documents.assessment import EXIT_CODES
from tuner.extensions.agents import child
from tuner.extensions.agents.answers import answer, meaning_of
from tuner.extensions.agents.child import Outcome, environment, run_command
from tuner.text.signals import CRASHED

MODULES = (
    "typing", "json", "re", "os", "enum", "dataclasses", "functools", "pathlib", "signal", "subprocess", "multiprocessing",
    "encodings", "warnings", "logging", "numpy", "scipy", "numba", "pandas", "matplotlib", "pydantic", "typer", "rich", "anyio",
    "tuner", "plant", "objectives", "sitecustomize", "usercustomize", "conftest", "yaml",
)  # fmt: skip
assert len(MODULES) == 30
TRAP = "open({file!r}, 'a').write(__name__ + '\\n')\n"


@pytest.fixture(params=["files", pytest.param("packages", marks=pytest.mark.slow)])
def trapped(request, tmp_path, monkeypatch):
    """A root full of modules that note that they ran, and the file of these notes; the environment names the root, too."""
    root, notes = tmp_path / "root", tmp_path / "ran"
    root.mkdir()
    for name in MODULES:
        file = root / f"{name}.py" if request.param == "files" else root / name / "__init__.py"
        file.parent.mkdir(exist_ok=True)
        file.write_text(TRAP.format(file=str(notes)))
    (root / "startup.pth").write_text(f"import os; {TRAP.format(file=str(notes))}")
    for program in ("gcc", "cc", "git", "python", "latex"):
        (root / program).write_text(f"#!/bin/sh\necho {program} >> {notes}\n")
        (root / program).chmod(0o755)
    for name, value in {
        "PYTHONPATH": f"{os.pathsep}{root}{os.pathsep}.",
        "PYTHONSTARTUP": str(root / "typing.py"),
        "PYTHONUSERBASE": str(root),
        "PATH": f"{os.pathsep}.{os.pathsep}{os.environ['PATH']}",
    }.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "path", ["", ".", str(root), *sys.path])
    return root, notes


def outcome_of(root, *arguments, allow_code=False):
    return anyio.run(run_command, [*arguments[:1], "--json", *arguments[1:]], root.resolve(), allow_code, no_progress)


def test_no_module_of_the_root_runs(trapped):
    root, notes = trapped
    for arguments in (("list", "targets"), ("new", "mine"), ("check", "--set=margin=[]", "mine.toml")):
        outcome = outcome_of(root, *arguments)
        assert outcome.code == 0, outcome
    assert not notes.exists(), notes.read_text()


@pytest.mark.slow
def test_no_module_of_the_root_runs_in_a_process_of_a_command_either(trapped):
    root, notes = trapped
    small = ("--set=search.generations=1", "--set=search.starts=[]")
    # Figures and margins are processes of the run, workers are those of a library.
    assert outcome_of(root, "run", *small, "--out=run", "quickstart").code in (0, 3)
    assert (root / "run" / "report.html").is_file()
    assert outcome_of(root, "run", *small, "--out=there", "--dask=local:1", "quickstart").code in (0, 3)
    assert outcome_of(root, "margins", "--law=hybrid", "--out=margins").code in (0, 1)
    exported = outcome_of(root, "export", "--to=fmi", "--flights=4", "--force", "--", "run/gains.json")
    assert exported.code in (0, 1), exported
    assert not notes.exists(), notes.read_text()


def test_the_modules_of_the_root_would_run_without_isolation(trapped):
    root, notes = trapped
    # Without codecs Python would end before it could note anything.
    (encodings,) = root.glob("encodings*")
    encodings.rename(root / "none")
    subprocess.run([sys.executable, "-c", "import typing"], cwd=root, check=False, capture_output=True)
    # Which of them Python imports first hangs on its version and on what is installed: functools, warnings, pathlib or re.
    ran = set(notes.read_text().split())
    assert ran and ran <= set(MODULES)


def test_processes_of_libraries_import_nothing_from_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    (tmp_path / "typing.py").write_text(TRAP.format(file=str(tmp_path / "ran")))
    code = [sys.executable, "-c", "import typing"]
    with without_working_folder():
        subprocess.run(code, cwd=tmp_path, check=True)
    assert not (tmp_path / "ran").exists() and SAFE_PATH not in os.environ
    subprocess.run(code, cwd=tmp_path, check=True)
    assert (tmp_path / "ran").exists()


def test_the_search_path_of_a_process_is_its_parents_without_what_is_relative_or_excluded(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", ["", "relative", str(tmp_path), *sys.path])
    (tmp_path / "link").symlink_to(tmp_path)
    command = python_command("import json; print(json.dumps(sys.path))", excluded=tmp_path / "link")
    seen = json.loads(subprocess.run(command, cwd=tmp_path, capture_output=True, check=True).stdout)
    assert str(tmp_path) not in seen and all(map(os.path.isabs, seen)) and str(HOME) in seen
    monkeypatch.setattr(sys, "path", [each for each in sys.path if each != str(HOME)])
    seen = json.loads(subprocess.run(command[:3] + python_command("import json; print(json.dumps(sys.path))")[3:],
                                     capture_output=True, check=True).stdout)  # fmt: skip
    assert seen[-1] == str(HOME)


def test_every_python_that_the_tool_starts_is_isolated():
    starts = {
        path.relative_to(HOME).as_posix()
        for room in ("plant", "objectives", "tuner")
        for path in (HOME / room).rglob("*.py")
        if "executable" in (text := path.read_text(encoding="utf-8"))
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Attribute) and node.attr == "executable" and isinstance(node.value, ast.Name)
    }
    # A module of the Crazyflie's and a program of trials are files of the user's own, which only a command that runs code starts.
    of_user = {"tuner/extensions/crazyflie/bench.py", "tuner/extensions/trials/program.py"}
    assert starts == {"plant/python_process.py", *of_user}


def test_a_command_searches_programs_and_libraries_in_absolute_folders_alone(monkeypatch):
    monkeypatch.setenv("PATH", f"{os.pathsep}bin{os.pathsep}/usr/bin{os.pathsep}.")
    monkeypatch.setenv("LD_LIBRARY_PATH", f"/opt/lib{os.pathsep}")
    made = environment(False)
    assert (made["PATH"], made["LD_LIBRARY_PATH"], made["TUNER_OWN_CODE"]) == ("/usr/bin", "/opt/lib", "refuse")
    assert environment(True)["TUNER_OWN_CODE"] == "allow"


VERDICT = "print('{\"a\": 1}')"


@pytest.mark.parametrize(
    ("program", "meaning", "is_error"),
    [
        (f"{VERDICT}; sys.exit(0)", "done", False),
        (f"{VERDICT}; sys.exit(1)", "done; a limit is violated or a difference is there", False),
        (f"{VERDICT}; sys.exit(3)", "done; nothing feasible", False),
        ("sys.exit(2)", "refused: bad input", True),
        ("1 / 0", "ended before it was done: an error of the tool", True),
        ("sys.exit(0)", "ended before it was done: an error of the tool", True),
        ("print('Traceback'); sys.exit(1)", "ended before it was done: an error of the tool", True),
        (f"{VERDICT}; sys.exit({CRASHED})", "ended before it was done: an error of the tool", True),
        (f"{VERDICT}; sys.exit(9)", "ended before it was done: an error of the tool", True),
        (f"{VERDICT}; sys.exit(143)", "ended before it was done: interrupted", True),
        ("import os; os.kill(os.getpid(), 11)", "ended before it was done: SIGSEGV", True),
        (f"{VERDICT}; import os; sys.stdout.flush(); os.kill(os.getpid(), 9)", "ended before it was done: SIGKILL", True),
    ],
)  # fmt: skip
def test_a_verdict_is_an_exit_code_and_a_document(program, meaning, is_error, tmp_path, monkeypatch):
    monkeypatch.setattr(child, "python_command", lambda *_, **__: [sys.executable, "-c", f"import sys; {program}"])
    outcome = outcome_of(tmp_path, "judge")
    made = answer(outcome)
    assert made.structured_content["meaning"].startswith(meaning) and made.is_error is is_error
    if not is_error:
        assert made.structured_content["meaning"] == meaning


def test_a_signal_without_a_name_is_said_by_its_number():
    assert "40" in meaning_of(Outcome(-40, None, ())) or "signal" in meaning_of(Outcome(-40, None, ()))
    assert meaning_of(Outcome(128 + signal.SIGINT, None, ())) == "ended before it was done: interrupted"


@pytest.mark.parametrize(
    "broken", ["import tuner.cli.main as m; m.main = lambda: 1 / 0", "sys.modules['typer'] = None"]
)
def test_an_error_of_the_tool_has_an_exit_code_that_no_verdict_has(broken):
    code = f"import sys; {broken}; from tuner.__main__ import run; run()"
    done = subprocess.run([sys.executable, "-c", code], cwd=HOME, capture_output=True, text=True, check=False)
    assert done.returncode == CRASHED == 70 and "Traceback (most recent call last)" in done.stderr


@pytest.mark.parametrize("lines", [1, 5000])
def test_messages_of_a_command_are_bounded(lines, tmp_path, monkeypatch):
    program = f"import sys; [print('x' * 5000, i, file=sys.stderr) for i in range({lines})]"
    monkeypatch.setattr(child, "python_command", lambda *_, **__: [sys.executable, "-c", program])
    messages = outcome_of(tmp_path, "judge").messages
    assert len(messages) == min(lines, child.MAX_LINES) and {len(each) for each in messages} == {child.MAX_LETTERS}


def test_a_root_that_python_imports_from_is_refused(tmp_path):
    command = [sys.executable, "-m", "tuner", "mcp", "--root", str(tmp_path)]
    done = subprocess.run(
        command, cwd=HOME, env=os.environ | {"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and "is a folder from which Python imports" in done.stderr


@pytest.mark.parametrize(("verdict", "code"), EXIT_CODES.items())
def test_the_verdict_of_a_judge_is_named_whatever_its_exit_code_means_elsewhere(verdict, code):
    made = answer(Outcome(code, {"verdict": verdict}, ()))
    assert made.structured_content is not None and not made.is_error
    assert made.structured_content["meaning"] == f"done; the verdict is: {verdict}"
