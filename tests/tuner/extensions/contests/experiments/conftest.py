"""One small contest with a search in it, shared by the tests of what a contest leaves behind."""

import pytest

from tests.tuner.extensions.contests.experiments.contest_text import write
from tests.tuner.study.loading import load_contest
from tuner.extensions.contests.run import ContestRun
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder


def run_small(path, folder, threads=2, **changes):
    contest = load_contest(path, {key.replace("__", "."): value for key, value in changes.items()})
    return ContestRun(contest, Folder.create(folder, inside="contenders"), Watcher(), threads=threads).carry_out()


@pytest.fixture(scope="session")
def small_contest(tmp_path_factory):
    folder = tmp_path_factory.mktemp("contests")
    return run_small(write(folder), folder / "small"), folder / "small"
