"""The examples in the docstrings of the public interface run, on one small study and its run."""

import doctest
import inspect
import re
import shutil
from importlib import import_module
from pathlib import Path

import pytest

import tuner
import tuner.report
from tests.tuner.conftest import SMALL, NoDrawing
from tuner.extension import added, load

HOMES = sorted({home for home in tuner._HOMES if home.startswith("tuner.api")})
BENCH = """
title = "A test bench"
seed = 1
trials = { search = 2, held_out = 2 }
variable = [{ name = "x", low = 0.0, high = 2.0, default = 1.5 }]
metric = [{ name = "cost", worst = 4.0 }]
objective = [{ metric = "cost" }]
search = { algorithm = "random", population = 8, generations = 2 }
"""
PARAMETERS = "1\t1\tMC_ROLLRATE_P\t0.15\t9\n"


def small_study():
    return tuner.load_study("quickstart", {**SMALL, "scenario.0.name": "gusts", "scenario.0.held_out": 48})


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A folder with a finished run, gains of somebody's own, and a vehicle's parameter file."""
    folder = tmp_path_factory.mktemp("examples") / "prepared"
    folder.mkdir()
    tuner.run(small_study(), folder / "results" / "first", threads=2)
    tuner.default_gains("hybrid").write(folder / "mine.json")
    (folder / "quad.params").write_text(PARAMETERS)
    shutil.copy(Path(__file__).parents[1] / "extensions" / "logs" / "crazyflie" / "log15_70_to_85", folder / "log15")
    (folder / "bench.toml").write_text(BENCH)
    return folder


@pytest.mark.parametrize("home", HOMES)
def test_examples_of_the_docstrings_run(home, prepared, tmp_path, monkeypatch, few_golden_vectors):
    # Figures take most of the time of a short run; `figure` and `report` draw their own.
    monkeypatch.setattr(tuner.report, "start_figures", lambda folder: NoDrawing())
    shutil.copytree(prepared, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    given = {
        "tuner": tuner,
        "study": small_study(),
        "results": tuner.open_results("results/first"),
        "gains": tuner.read_gains("mine.json"),
    }
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    for example in doctest.DocTestFinder(exclude_empty=True).find(import_module(home), extraglobs=given):
        runner.run(example)
    assert runner.failures == 0
    assert runner.tries > 0


def public():
    """Every public function, class, and public method of one that is written in the interface itself."""
    for name in tuner.__all__:
        value = getattr(tuner, name)
        if not str(value.__module__).startswith("tuner.api"):
            continue
        yield name, value
        if inspect.isclass(value):
            for key, member in vars(value).items():
                if not key.startswith("_") and (inspect.isfunction(member) or hasattr(member, "__get__")):
                    yield f"{name}.{key}", member


def test_every_docstring_tells_its_arguments_and_has_an_example():
    lacking = []
    for name, value in public():
        text = inspect.getdoc(value) or ""
        head = text.split("\n", 1)[0]
        if not head.endswith((".", ":")) or head.startswith(("What", "How", "Which", "Where", "Who")):
            lacking.append(f"{name}: {head!r}")
        if not inspect.isfunction(value) or name.endswith(".file") or text.endswith("see `Results.figure`."):
            continue
        named = [key for key in inspect.signature(value).parameters if key != "self"]
        lacking += [f"{name}: {key} is not told" for key in named if f"    {key}: " not in text]
        parts = ("Args:",) * bool(named) + ("Returns:", "Examples:")
        lacking += [f"{name}: no {part}" for part in parts if part not in text]
    assert lacking == []


def test_public_names_are_those_of_the_core_and_of_extensions_and_all_have_types():
    core = {name: home for home, names in tuner._HOMES.items() for name in names}
    for name, home in core.items():
        assert getattr(import_module(home), name) is inspect.unwrap(getattr(tuner, name))
    references = added("api")
    assert sorted([*core, *references]) == list(tuner.__all__)
    for name, reference in references.items():
        assert load(reference) is inspect.unwrap(getattr(tuner, name))
    stub = Path(tuner.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    homes = core | {name: reference.partition(":")[0] for name, reference in references.items()}
    typed = dict(
        (name, line.split()[1])
        for line in stub.splitlines()
        if line.startswith("from ")
        for name in re.findall(r"(\w+) as \1", line)
    )
    assert typed == homes


def test_what_a_notebook_shows_is_text_that_may_be_a_strangers():
    study = tuner.load_study("quickstart", {**SMALL, "title": "<script>x</script>"})
    page = study._repr_html_()
    assert "&lt;script&gt;x" in page and "<script>" not in page and "hummingbird" in page
    assert "<td" in tuner.default_gains("pid")._repr_html_()
    study = tuner.load_study("contest")
    assert study.title in study._repr_html_() and "<td" in study._repr_html_()


def test_a_study_of_tables_runs_like_one_of_a_file_and_leaves_its_text(tmp_path, monkeypatch):
    monkeypatch.setattr(tuner.report, "start_figures", lambda folder: NoDrawing())
    study = small_study()
    made = tuner.make_study(study.content, "quickstart", tmp_path)
    assert made.digest() == study.digest()
    results = tuner.run(made, tmp_path / "made", threads=2)
    assert (tmp_path / "made" / "study.toml").read_text() == made.given
    assert tuner.verify(tmp_path / "made", sample=1).identical
    assert results.gains().document["gains"] == results.nearest.document["gains"]
    with pytest.raises(tuner.InputError, match="this is a contest"):
        tuner.make_study({**study.content, "contender": []})
    with pytest.raises(tuner.UnknownNameError, match="unknown point 'p9999'"):
        results.gains("p9999")
