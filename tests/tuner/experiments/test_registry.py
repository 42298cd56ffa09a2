"""The registry of experiments: every kind of study can be run, every kind of run resumed, and options are refused by name."""

import pytest

from plant.errors import InputError, StoreError
from tests.tuner.study.study_text import STUDY, write
from tuner.experiments.again.resume import resume
from tuner.experiments.options import OPTIONS
from tuner.experiments.planning.preview import PREVIEWS, preview
from tuner.experiments.registry import draw, experiments, folder_kind, refuse_options, run
from tuner.extension import added
from tuner.extensions.contests.choices import CHOICES
from tuner.store.advice import RESUMED, TRIALS
from tuner.store.folder import Folder
from tuner.study.files import shipped_studies
from tuner.study.kinds import load_any, study_kinds


def test_every_kind_of_study_can_be_run_resumed_and_previewed():
    # A study with choices is a contest once it is read.
    studied = {kind.name for kind in study_kinds()} - {CHOICES}
    # Trials of another program are gone on with by asking again.
    assert studied == {*RESUMED, TRIALS} == {*PREVIEWS, *added("previews")}
    assert studied <= set(experiments())
    assert {name for name, kind in experiments().items() if kind.run.resumable} == {*RESUMED, TRIALS, "judgement"}


def test_every_kind_is_known_by_the_name_that_its_run_records():
    """A run that searches gains records the kind of its study."""
    by_study = {"tuning", "plant"}
    assert {name: kind.run.kind for name, kind in experiments().items()} == {
        name: None if name in by_study else name for name in experiments()
    }


@pytest.mark.parametrize("kind", experiments().values(), ids=experiments())
def test_an_option_that_a_kind_does_not_take_is_refused_with_its_key(kind):
    taken = kind.run.takes - kind.lacks
    assert taken <= set(OPTIONS)
    for name, option in OPTIONS.items():
        refuse_options(kind, **{name: None})
        if option.why is None or name in taken:
            refuse_options(kind, **{name: "given"})
            continue
        with pytest.raises(InputError, match=option.why) as caught:
            refuse_options(kind, **{name: "given"})
        assert caught.value.key == option.flag_of(name)


def test_what_cannot_be_run_leaves_no_folder_behind(tmp_path):
    study = load_any(write(tmp_path, STUDY), {"gains": {}})
    with pytest.raises(InputError, match="no gain is searched"):
        run(study, tmp_path / "out")
    with pytest.raises(InputError, match="there is no results folder"):
        run(study, tmp_path / "out", reuse=(tmp_path / "nowhere",))
    contest = load_any(shipped_studies()["contest"])
    with pytest.raises(InputError, match="only a tuning study flies on a cluster"):
        run(contest, tmp_path / "out", dask="local:2")
    with pytest.raises(InputError, match="give --dask or --backend"):
        run(study, tmp_path / "out", dask="local:2", backend="cuda")
    assert not (tmp_path / "out").exists()


def test_an_interrupted_experiment_tells_once_what_to_do(tmp_path):
    study = load_any(write(tmp_path, STUDY))
    kind = experiments()[study.kind]

    class Interrupted(kind.run):
        def fly(self):
            with self.folder:
                raise KeyboardInterrupt

        def warm_up(self):
            pass

    with pytest.raises(KeyboardInterrupt) as caught:
        Interrupted(study, Folder.create(tmp_path / "out")).carry_out()  # pyright: ignore[reportAbstractUsage]
    assert caught.value.__notes__ == [f"go on with `tuner resume {tmp_path / 'out'}`"]
    # Inputs are frozen and the lock is given back.
    assert folder_kind(tmp_path / "out") is kind
    Folder.open(tmp_path / "out").close()


@pytest.mark.parametrize("name", ["quickstart", "contest"])
def test_a_preview_needs_no_flight(name):
    study = load_any(shipped_studies()[name])
    assert preview(study).title == study.title


def test_a_folder_of_nothing_is_neither_drawn_nor_resumed(tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(StoreError, match="no finished results folder"):
        draw(tmp_path / "empty")
    with pytest.raises(StoreError, match="cannot be continued"):
        resume(tmp_path / "empty")
    assert list((tmp_path / "empty").iterdir()) == []
