"""The worked notebook runs from its first cell to its last, and is stored without outputs."""

import ast
import json
from pathlib import Path
from typing import Any

from tests.undrawn import drawn

NOTEBOOK = Path(__file__).parents[3] / "docs" / "notebooks" / "tune_in_a_notebook.ipynb"


def code_cells():
    return [cell for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]


def test_it_is_stored_without_outputs():
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code_cells())


def run(source, names) -> Any:
    """Run a cell and return the value of its last expression, as a notebook shows it."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)


def test_every_cell_runs_and_what_it_shows_is_html(tmp_path, monkeypatch, capsys, no_figures, few_golden_vectors):
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "notebook"}
    with drawn():
        shown = [run("".join(cell["source"]), names) for cell in code_cells()]
    pages = [value._repr_html_() for value in shown if hasattr(value, "_repr_html_")]
    assert len(pages) >= 6 and all("<table" in page for page in pages if page)
    assert "generation 6 of 6" in capsys.readouterr().out
    front = names["front"]
    assert len(front) and front["mean(travel)"].between(front["mean(travel) low"], front["mean(travel) high"]).all()
    assert (tmp_path / "front.png").stat().st_size > 10_000
    assert (tmp_path / "export" / "c99" / "export.json").exists()
