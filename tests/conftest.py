"""Order of the test files, the long ones first, so that no worker ends the suite alone with one of them; and the surroundings of all."""

import gc
import os
import signal
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

# The width and colours of whoever starts the tests are not those that the tests expect: 80 columns and none.
for name in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE"):
    os.environ.pop(name, None)

# As the command has it: matrices are small, and more threads of a linear algebra library would spin beside the other workers.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Compiled sources are kept, whatever the starter wants: else half of the collection is pytest rewriting assertions, and each
# process that a test starts compiles the tool's sources for 0.3 s.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# No test loses power. Runs wait 5 ms for each of their files to lie on the disk, and one worker for the files of the others.
os.fsync = lambda _: None

# Tests interrupt runs. A shell that starts the tests in the background has them ignore Ctrl-C, and all that they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Those of 12 s of processor time and more, the longest first; kernels are compiled in them.
LONG = (
    "tuner/report/test_report_browser.py", "tuner/extensions/identification/test_identification.py", "golden/test_golden.py",
    "tuner/extensions/tails/test_tail_run.py", "tuner/extensions/contests/experiments/test_contest_run.py", "tuner/extensions/judge/test_second_opinion.py",
    "tuner/experiments/again/test_resume.py", "tuner/search/test_search_contract.py", "tuner/extensions/fmu/test_fmu_flights.py",
    "tuner/extensions/fmu/test_fmu_run.py",
    "tuner/experiments/tuning/test_margin_study.py", "tuner/api/test_ten_calls.py", "plant/backends/test_backends_agree.py",
    "tuner/cli/test_interrupt.py", "tuner/cli/test_surroundings.py", "tuner/extensions/first_flights/test_approach.py",
    "tuner/exchange/test_hostile_texts.py", "tuner/analysis/test_check_kinds.py", "plant/laws/test_laws.py",
    "tuner/search/test_bayesian_optimization.py", "tuner/cli/test_cli.py", "tuner/study/test_bundled_studies.py",
    "tuner/api/test_examples.py", "tuner/gains/test_gains_schema.py", "test_blocks_of_pages.py",
    "objectives/margins/test_margin_control.py", "tuner/report/test_report_layout.py", "tuner/exchange/c99/test_c99_bits.py",
    "tuner/extensions/trials/test_ask_and_tell.py", "tuner/exchange/c99/test_c99_bundle.py",
    "tuner/extensions/betaflight/test_betaflight_firmware.py", "tuner/extensions/cluster/test_cluster_lost.py",
)  # fmt: skip
# Folders whose files share runs that take seconds (fixtures of the session): one worker gets all of each.
TOGETHER = (
    "tests/tuner/extensions/identification/",
    "tests/tuner/extensions/contests/experiments/",
    "tests/tuner/experiments/compare/",
    "tests/tuner/extensions/contests/report/",
)


# Laws as papers print them, forms of the ideal PID and other variants of one law: their cases of a property are proofs that
# tests/proofs.txt names.
VARIANTS = {
    "hybrid_beta3", "hybrid_gsta", "hybrid_literal", "hybrid_paper_f_hat", "hybrid_true_sta", "ladrc_printed",
    "supertwisting_euler", "pid_incremental", "pid_parallel", "pid_series",
}  # fmt: skip


@pytest.hookimpl(wrapper=True)
def pytest_collection(session):
    """Collect no garbage while tests are collected: it finds nothing, and takes a fifth of that time."""
    gc.disable()
    try:
        import_share(session.config)
        return (yield)
    finally:
        gc.enable()


def import_share(config):
    """Import a worker's share of the test files before the others.

    In one order, all workers compile all test files of a new clone at the same time, 6 s of processor time each; so each
    compiles a share and reads what the others have compiled.
    """
    worker = getattr(config, "workerinput", None)
    if worker is None:
        return
    folders = [Path(argument) for argument in config.args if Path(argument).is_dir()]
    files = sorted({file.resolve() for folder in folders for file in folder.rglob("test_*.py")})
    number, count = int(worker["workerid"].removeprefix("gw")), int(worker["workercount"])
    for file in files[number::count]:
        # What fails or is skipped is reported by the collection itself.
        with suppress(Exception, pytest.skip.Exception):
            import_module(".".join(file.relative_to(config.rootpath).with_suffix("").parts))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark cases of variants slow and put the tests of long files first; the others keep their order."""
    draw_no_constants_of_sources()
    for item in items:
        if "[" in item.name and not VARIANTS.isdisjoint(item.callspec.id.split("-")):
            item.add_marker(pytest.mark.slow)
    place = {f"tests/{name}": number for number, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.nodeid.partition("::")[0], len(LONG)))


def draw_no_constants_of_sources():
    """Leave the constants of the tool's own sources out of what hypothesis draws: to read them takes 2 s of each worker."""
    if "hypothesis" in sys.modules:
        setattr(import_module("hypothesis.internal.conjecture.providers"), "is_local_module_file", lambda _: False)  # noqa: B010


def pytest_collection_finish(session):
    """Leave what is there before the first test out of all collections of garbage, which took 7 % of the time."""
    # Hardly any of it is garbage; to look for that takes half a second of each process.
    gc.freeze()


@pytest.fixture(scope="module", autouse=True)
def _what_a_file_left_is_collected_once():
    """Do so after each file too, once its garbage is collected: looking at modules, kernels and graphs took 11 % of the time."""
    yield
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers(config):
    """Start one worker more than there are processors: tests wait for browsers, firmware and other processes."""
    return (yield) + ("PYTEST_XDIST_AUTO_NUM_WORKERS" not in os.environ)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Hand out tests by file, and those of some folders together."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid):
            return next((folder for folder in TOGETHER if nodeid.startswith(folder)), super()._split_scope(nodeid))

    return Scheduling(config, log)


MIN_REPORTED_SECONDS = 0.1
"""Duration from which on a set-up or an end is reported: `--durations` shows the long ones."""


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    """Report the call of a test, and its set-up and end only if they did not pass or took long.

    A report of a worker costs 0.3 ms of both processes together: 28,000 of set-up and end are 8 s of the suite.
    """
    if not hasattr(item.config, "workerinput"):
        return None
    hook = item.ihook
    hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in runtestprotocol(item, nextitem=nextitem, log=False):
        if report.when == "call" or not report.passed or report.duration > MIN_REPORTED_SECONDS:
            hook.pytest_runtest_logreport(report=report)
    hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


@pytest.fixture(autouse=True)
def _no_code_of_an_earlier_test():
    """Forget the laws, metrics and references of files that a test named: the next one's registries are the bundled ones."""
    yield
    own_code = sys.modules.get("plant.own_code")
    if own_code is not None and own_code.HAVE_RUN:
        from tests.plant.own_files import forget

        forget()
