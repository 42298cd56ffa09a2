"""Records of extensions: what they name is there, reading them imports nothing, and the core runs without any."""

import ast
import re
import subprocess
import sys
from dataclasses import fields
from importlib.metadata import entry_points as installed
from importlib.util import find_spec
from pathlib import Path

import pytest

from plant.entry_points import entry_points
from plant.errors import InputError, UnknownNameError
from tuner import extension
from tuner.extension import BUNDLED_NAMES, GROUP, Extension, extensions, find, load, refuse_lacking

RECORDS = extensions()
HOME = Path(extension.__file__).parent / "extensions"
TESTS = Path(__file__).parent


def references(record):
    """References of a record, "module:object"."""
    for part in fields(record):
        value = getattr(record, part.name)
        if part.name == "folders":
            yield from value
        elif hasattr(value, "values") and part.name != "commands":
            yield from value.values()


def test_records_of_the_wheel_are_its_folders():
    folders = {path.parent.name for path in HOME.glob("*/extension.py")}
    assert folders == {path.name for path in HOME.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders <= set(RECORDS)


def test_records_are_found_as_the_library_finds_them():
    assert dict(entry_points(GROUP, sys.path)) == {point.name: point.value for point in installed(group=GROUP)}


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_names_what_is_there_and_its_module_imports_the_record_alone(name):
    record = RECORDS[name]
    assert all(load(reference) is not None for reference in references(record))
    assert record.about.endswith(".") and set(record.requires) <= set(RECORDS)
    spec = find_spec(f"tuner.extensions.{name}.extension")
    assert spec is not None and spec.origin is not None
    imported = [
        node
        for node in ast.walk(ast.parse(Path(spec.origin).read_text()))
        if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    assert [getattr(node, "module", None) for node in imported] == ["tuner.extension"]


def test_no_two_records_name_the_same():
    for part in fields(Extension):
        names = [name for record in RECORDS.values() for name in getattr(record, part.name)]
        if part.name not in {"name", "about", "requires", "command_module"}:
            assert len(names) == len(set(names)), part.name


@pytest.mark.parametrize("name", RECORDS)
def test_an_extension_imports_the_core_and_what_its_record_requires(name):
    """Those of import statements anywhere in its modules; the rest of the wheel may import no extension at all."""
    nodes = [node for file in (HOME / name).rglob("*.py") for node in ast.walk(ast.parse(file.read_text()))]
    modules = [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    modules += [entry.name for node in nodes if isinstance(node, ast.Import) for entry in node.names]
    named = {module.split(".")[2] for module in modules if module.startswith("tuner.extensions.")}
    assert named - {name} <= set(RECORDS[name].requires)


def test_the_table_of_bundled_names_is_that_of_the_records_of_the_wheel():
    bundled = [RECORDS[path.parent.name] for path in HOME.glob("*/extension.py")]
    for part, names in BUNDLED_NAMES.items():
        if part != "tables":
            assert names == {name: record.name for record in bundled for name in getattr(record, part)}, part
    studies = {load(kind).table: record.name for record in bundled for kind in record.studies.values()}
    requirements = {table: record.name for record in bundled for table in record.requirements}
    observers = {table: record.name for record in bundled for table in record.observers}
    assert BUNDLED_NAMES["tables"] == studies | requirements | observers


def test_a_name_of_an_installed_extension_or_of_none_is_not_refused(monkeypatch):
    refuse_lacking("tables", "contender")
    monkeypatch.setattr(extension, "extensions", lambda: {"trials": RECORDS["trials"]})
    refuse_lacking("tables", "trials")
    refuse_lacking("tables", "contenders")
    with pytest.raises(InputError, match="^a.toml: contender: the table 'contender' comes with the extension contests"):
        refuse_lacking("tables", "contender", file="a.toml", key="contender")


def package(folder: Path, name: str, reference: str, code: str = "") -> None:
    """Write a package's metadata with one record, and its module."""
    metadata = folder / f"{name}-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "entry_points.txt").write_text(
        f"[console_scripts]\nx = y:z\n\n[{GROUP}]\n{name} = {reference}\n\n[other]\nn = m:o\n"
    )
    (folder / f"{reference.partition(':')[0]}.py").write_text(code)


RECORD = "from tuner.extension import Extension\nR = Extension({arguments})\n"


@pytest.fixture
def anew(tmp_path, monkeypatch):
    """A folder on the import path, whose records count."""
    monkeypatch.syspath_prepend(str(tmp_path))
    extensions.cache_clear()
    yield tmp_path
    extensions.cache_clear()


def test_a_strangers_package_adds_what_its_record_names(anew):
    package(
        anew,
        "warmth",
        "warmth_record:R",
        RECORD.format(arguments='"warmth", "Heat of coils.", api={"heat": "math:sqrt"}'),
    )
    assert list(extensions()) == sorted([*RECORDS, "warmth"])
    assert find("api", "name", "heat")(9.0) == 3.0
    with pytest.raises(UnknownNameError, match="did you mean 'heat'"):
        find("api", "name", "heatt")


def test_a_part_that_no_record_has_is_refused_with_advice(monkeypatch):
    monkeypatch.setattr(extension, "extensions", lambda: {})
    with pytest.raises(InputError, match="no installed extension adds a template; `tuner list extensions`"):
        find("templates", "template", "extension")


@pytest.mark.parametrize(
    ("reference", "code", "said"),
    [
        (
            "broken_record:R",
            "import nothing_of_that_name",
            "broken = broken_record:R cannot be loaded: No module named",
        ),
        ("broken_record:R", "", "cannot be loaded: module 'broken_record' has no attribute 'R'"),
        ("broken_record:R", "R = 3", "is no record of an extension with the name broken"),
        (
            "broken_record:R",
            RECORD.format(arguments='"other", "x."'),
            "is no record of an extension with the name broken",
        ),
        (
            "broken_record:R",
            RECORD.format(arguments='"broken", "x.", requires=("missing",)'),
            "requires missing, which is not installed",
        ),
    ],
)
def test_a_record_that_is_none_is_refused_by_name(anew, reference, code, said):
    sys.modules.pop("broken_record", None)
    package(anew, "broken", reference, code)
    with pytest.raises(InputError, match=said):
        extensions()


def test_two_packages_cannot_share_a_name(anew, monkeypatch):
    package(anew, "sensitivity", "my_sensitivity:R", RECORD.format(arguments='"sensitivity", "x."'))
    with pytest.raises(InputError, match="two packages have an extension with the name sensitivity"):
        extensions()


WITHOUT = """
import tuner.extension, sys
tuner.extension.extensions = lambda: {}
from tuner.cli.main import main
sys.argv = ["tuner", *sys.argv[1:]]
main()
"""


@pytest.mark.parametrize("arguments", [("--help",), ("list", "laws"), ("check", "quickstart"), ("schema", "summary")])
def test_the_core_runs_without_an_extension(arguments, tmp_path):
    done = subprocess.run([sys.executable, "-c", WITHOUT, *arguments], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    commands = {line.split()[0] for line in done.stdout.splitlines() if line[:2] == "  " != line[:3]}
    assert arguments != ("--help",) or "run" in commands
    assert not commands & {command for record in RECORDS.values() for command in record.commands}


MIN_LINES, MAX_LINES = 10, 45
FILE = re.compile(r"`([\w./-]+\.(?:py|c|cpp|hpp))`")
LINK = re.compile(r"\]\(([^)#]+)\)")


def faults_of_readme(text: str, record: Extension, home: Path) -> list[str]:
    """Commands, targets and options of a record and modules of its folder that a README lacks, and its names of no file."""
    commands = [f"`tuner {word}" for word in record.commands]
    options = [word for part in ("targets", "backends", "clusters") for word in getattr(record, part)]
    modules = [f"`{path.name}`" for path in home.glob("*.py") if path.stem not in {"__init__", "extension"}]
    roots = home, TESTS.parents[2], TESTS / record.name, TESTS / "autopilots"
    named = [file for file in FILE.findall(text) if not any((root / file).exists() for root in roots)]
    linked = [link for link in LINK.findall(text) if not (home / link).exists()]
    return [word for word in (*commands, *options, *modules) if word not in text] + named + linked


@pytest.mark.parametrize("name", sorted(path.parent.name for path in HOME.glob("*/extension.py")))
def test_a_readme_of_a_page_describes_each_extension(name):
    text = (HOME / name / "README.md").read_text(encoding="utf-8")
    assert text.startswith(f"# {name}\n") and MIN_LINES <= len(text.splitlines()) <= MAX_LINES
    assert faults_of_readme(text, RECORDS[name], HOME / name) == []


def test_a_readme_that_lacks_a_name_or_has_one_of_no_file_is_refused(tmp_path):
    (tmp_path / "command.py").touch()
    record = Extension("warmth", "Heat.", commands=("warm",), targets={"coil": "coil:TARGET"})
    good = "`tuner warm` and the target `coil`, in [`command.py`](command.py)."
    assert faults_of_readme(good, record, tmp_path) == []
    assert faults_of_readme("`gone.py` [there](gone.md)", record, tmp_path) == [
        *("`tuner warm", "coil", "`command.py`", "gone.py", "gone.md")
    ]
