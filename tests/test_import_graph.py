"""The floor plan, as import-linter reads it in pyproject.toml: imports inside functions and of types alone count too."""

import ast
import tomllib
from pathlib import Path

from importlinter import cli

from tests.sources import sources, walk

ROOT = Path(__file__).parents[1]
CONFIG = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]


def test_every_room_imports_only_those_below_it(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert cli.lint_imports(no_cache=True) == 0, capsys.readouterr().out


def test_an_upward_import_inside_a_function_is_seen(tmp_path, monkeypatch, capsys):
    (tmp_path / "house" / "cellar").mkdir(parents=True)
    (tmp_path / "house" / "attic").mkdir()
    for name in ("", "cellar", "attic"):
        (tmp_path / "house" / name / "__init__.py").write_text("")
    (tmp_path / "house" / "cellar" / "boiler.py").write_text("def heat():\n    from house.attic import roof\n")
    (tmp_path / "house" / "attic" / "roof.py").write_text("")
    config = tmp_path / ".importlinter"
    text = [
        "[importlinter]",
        "root_package = house",
        "[importlinter:contract:floors]",
        "name = floors",
        "type = layers",
    ]
    config.write_text("\n".join([*text, "containers = house", "layers =", "    attic", "    cellar", ""]))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert cli.lint_imports(no_cache=True) == 1
    assert "house.cellar.boiler -> house.attic.roof" in capsys.readouterr().out


def test_type_checking_counts_and_no_contract_looks_away():
    assert CONFIG["exclude_type_checking_imports"] is False
    floors = next(contract for contract in CONFIG["contracts"] if contract.get("exhaustive"))
    assert "ignore_imports" not in floors


def test_only_the_package_its_command_and_the_record_of_extensions_lie_loose():
    loose = {path.name for path in (ROOT / "tuner").glob("*.py")}
    assert loose == {"__init__.py", "__main__.py", "extension.py"}


def test_all_imports_are_absolute():
    relative = [
        name
        for name, text in sources(pattern=r"from[\s\\]+\.")
        for node in walk(ast.parse(text))
        if isinstance(node, ast.ImportFrom) and node.level
    ]
    assert relative == []
