"""Whatever starts code of somebody else's refuses to where TUNER_OWN_CODE does: files, FMUs, firmware, programs of trials."""

import ast
import socket

import pytest

import tuner
from plant.errors import InputError
from plant.own_code import OWN_CODE, run_own_code
from plant.python_process import HOME
from tests.tuner.extensions.agents.test_agent_isolation import outcome_of
from tuner.extensions.autopilots.process import FirmwareProcess
from tuner.extensions.autopilots.registry import firmwares
from tuner.extensions.betaflight.board import powered_up
from tuner.extensions.px4.bench import LIBRARIES as PX4
from tuner.extensions.trials.program import TrialProcess

REFUSED = "which this process does not run; `tuner mcp --allow-code` would"


@pytest.fixture
def program(tmp_path, monkeypatch):
    """A program that notes that it ran, in a process that runs none."""
    file = tmp_path / "program"
    file.write_text(f"#!/bin/sh\ntouch {tmp_path / 'ran'}\n")
    file.chmod(0o755)
    monkeypatch.setenv(OWN_CODE, "refuse")
    yield file
    assert not (tmp_path / "ran").exists()


STARTS = {
    "firmware": lambda file: FirmwareProcess([str(file)], file),
    "betaflight": lambda file: powered_up(file, file.parent, file, {}, list[socket.socket]()),
    "checkout": lambda file: PX4.compile(file.parent, file.parent / "made"),
    "trials": lambda file: TrialProcess(str(file)),
    "autotune": lambda file: tuner.autotune("log", "x.params", file.parent / "out", airframe="racer5", binary=file),
    **{f"confirm {name}": lambda file, name=name: tuner.confirm(file.parent, name, file) for name in firmwares()},
}


@pytest.mark.parametrize("start", STARTS)
def test_no_program_starts(start, program):
    with pytest.raises(InputError, match=REFUSED):
        STARTS[start](program)


@pytest.mark.parametrize("name", ["mine.py", "mine.fmu"])
def test_no_file_of_code_runs(name, program):
    file = program.with_name(name)
    file.write_text(f"open({str(program.with_name('ran'))!r}, 'w')")
    for run in (tuner.use, tuner.check) if name.endswith(".py") else (tuner.use,):
        with pytest.raises(InputError, match=REFUSED):
            run(file)


def test_code_runs_again_where_it_is_allowed(tmp_path, monkeypatch):
    monkeypatch.setenv(OWN_CODE, "allow")
    (tmp_path / "mine.py").write_text("value = 7")
    assert run_own_code(tmp_path / "mine.py").names["value"] == 7
    with TrialProcess("true"):
        pass


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("check", ("mine.py",)),
        *(
            pytest.param(*each, marks=pytest.mark.slow)
            for each in (
                ("autotune", ("--vehicle=x.params", "--airframe=racer5", "--binary=program", "log")),
                ("check", ("mine.toml",)),
                ("run", ("mine.toml",)),
                ("tail", ("mine.toml",)),
            )
        ),
    ],
)
def test_a_tool_runs_nothing_without_allow_code(name, options, program):
    root, trap = program.parent, f"open({str(program.with_name('ran'))!r}, 'w')\n"
    (root / "mine.py").write_text(trap)
    study = (HOME / "studies" / "own_law.toml").read_text()
    (root / "mine.toml").write_text(study.replace("own_law/", ""))
    for file in (HOME / "studies" / "own_law").glob("*.py"):
        (root / file.name).write_text(trap + file.read_text())
    outcome = outcome_of(root, name, *options)
    assert outcome.code == 2 and REFUSED in outcome.messages[-1], outcome


# File that starts a process -> what is started, and why no other look at TUNER_OWN_CODE is needed.
STARTERS = {
    "tuner/extensions/fmu/process.py": "our worker; its FMU is admitted as it is read",
    "tuner/extensions/agents/child.py": "our command",
    "tuner/extensions/betaflight/board.py": "a program: refused; our library's compiler",
    "tuner/extensions/autopilots/libraries/building.py": "a checkout's compiler: refused",
    "tuner/extensions/autopilots/process.py": "a program: refused",
    "tuner/extensions/fmi/code.py": "the compiler of what is exported",
    "tuner/extensions/processor_cost/qemu.py": "compiler and emulator of what is exported",
    "tuner/extensions/studio/live.py": "our command",
    "tuner/extensions/studio/searching.py": "our command",
    "tuner/extensions/trials/program.py": "a program: refused",
    "tuner/experiments/tuning/problem.py": "our margins",
    "tuner/report/charts/printer.py": "our figures",
    "tuner/store/environment.py": "git, in our own clone",
}


def test_every_start_of_a_process_is_looked_at():
    found = {}
    for room in ("plant", "objectives", "tuner"):
        for path in (HOME / room).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            if not any(name in text for name in {"subprocess", "anyio", "os.system", "os.execv"}):
                continue
            calls = [node.func for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
            names = {ast.unparse(call) for call in calls}
            if names & {
                "subprocess.run",
                "subprocess.Popen",
                "subprocess.call",
                "anyio.open_process",
                "os.system",
                "os.execv",
            }:
                found[path.relative_to(HOME).as_posix()] = "refuse_program(" in text
    assert found == {file: ": refused" in why for file, why in STARTERS.items()}
