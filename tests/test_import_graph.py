"""The one-way graph: plant <- objectives <- tuner, and no cycle among modules, imports inside functions included."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("plant", "objectives", "tuner")


def modules():
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
    }


def is_type_checking(node):
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def imported(path, known):
    """Modules of ours that a file imports anywhere, but for those that only a type checker sees."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    hidden = {id(inner) for node in ast.walk(tree) if is_type_checking(node) for inner in ast.walk(node)}
    found = set()
    for node in ast.walk(tree):
        if id(node) in hidden:
            continue
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            # `from package import module` depends on the module, `from module import name` on the module it stands in.
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name in known else node.module for name in names]
        found |= {name for name in names if name in known}
    return found


def graph():
    known = modules()
    return {name: imported(path, known) - {name} for name, path in known.items()}


def test_the_graph_sees_known_edges():
    edges = graph()
    assert "plant.primitives" in edges["plant.vectors"]
    assert "tuner.report" in edges["tuner.experiments.tuning.run"]  # imported inside a function


def test_packages_point_one_way():
    rank = {package: i for i, package in enumerate(PACKAGES)}
    wrong = [
        (name, other)
        for name, others in graph().items()
        for other in others
        if rank[other.split(".")[0]] > rank[name.split(".")[0]]
    ]
    assert wrong == []


def test_no_cycles():
    edges = graph()
    done, stack = set(), []

    def visit(name):
        if name in stack:
            raise AssertionError(" -> ".join([*stack[stack.index(name) :], name]))
        if name in done:
            return
        stack.append(name)
        for other in sorted(edges[name]):
            visit(other)
        stack.pop()
        done.add(name)

    for name in edges:
        visit(name)
