"""What commands print on terminals of any width: no word broken, no heading cut, nothing lost, no line too wide."""

import re
from pathlib import Path

import pytest
from rich.text import Text
from typer.main import get_group

import tuner as interface
from tests.tuner.conftest import QUICKSTART
from tests.tuner.experiments.compare.conftest import changed_gains
from tests.tuner.extensions.contests.report.fabricate_contest import Made
from tests.tuner.extensions.contests.report.fabricate_contest import fabricate as fabricate_contest
from tests.tuner.in_process import tuner
from tests.tuner.report.fabricate import fabricate
from tuner.api.catalogue import listings
from tuner.cli.main import app
from tuner.cli.printers.run_end import print_end_tables
from tuner.cli.printers.tuning import comparison_table, gains_table
from tuner.cli.tables import PIPE_WIDTH, TerminalTable
from tuner.cli.terminal import Console
from tuner.documents.comparison_document import ComparisonDocument
from tuner.documents.plan import PlanDocument
from tuner.documents.summary import Summary
from tuner.documents.tuning import TuningFolder
from tuner.text.numbers import count

ROOT = Path(__file__).parents[3]
WIDTHS = (60, 80, 200)
# So wide that nothing has to give way: what stands there is what the words are.
ROOMY = 1000
# Lines that a person copies whole: where files lie, and commands.
WHOLE = re.compile(r"(Report|Gains|Results|Figure|Figures|Study|Wrote): |tuner ")
# What is drawn for the width it has.
DRAWN = re.compile(r"[─|▁▂▃▄▅▆▇█+.o@D-]+")


def words(text):
    return {word for word in text.split() if not DRAWN.fullmatch(word)}


def check_widths(told, monkeypatch, widths=WIDTHS, lost=()):
    """Hold what is told at each width against what is told where there is room; lost: words that only that one has."""
    monkeypatch.setenv("COLUMNS", str(ROOMY))
    whole = words(told())
    for width in widths:
        monkeypatch.setenv("COLUMNS", str(width))
        text = told()
        assert words(text) - whole == set(), f"broken or cut at {width} columns"
        assert whole - words(text) <= set(lost), f"lost at {width} columns"
        assert [line for line in text.splitlines() if len(line) > width and not WHOLE.match(line)] == []


def command(monkeypatch, capsys, *arguments, codes=(0,)):
    """Return a function that runs a command and returns what it prints."""

    def told():
        code, out, error = tuner(monkeypatch, capsys, *arguments)
        assert code in codes, error
        return out

    return told


def remembered(monkeypatch, name):
    """Have a function of the interface answer each question once: no answer hangs on a width."""
    work, answers = getattr(interface, name), {}

    def answer(*asked, **named):
        # Options that are no answers to a person, such as a watcher, are each call's own.
        key = repr((asked, [value for value in named.items() if isinstance(value[1], (str, Path, float, int))]))
        if key not in answers:
            answers[key] = work(*asked, **named)
        return answers[key]

    monkeypatch.setattr(interface, name, answer)


def printed(capsys, *printers):
    """Return a function that prints with a console of its own and returns what it prints."""

    def told():
        console = Console()
        for show in printers:
            show(console)
        return capsys.readouterr().out

    return told


@pytest.mark.parametrize("what", listings())
def test_listings(what, monkeypatch, capsys):
    # Where rows become blocks, the heading of the first column, which heads each block, goes.
    first = next(iter(listings()[what]()[0]))
    check_widths(command(monkeypatch, capsys, "list", what), monkeypatch, lost={first})


def test_the_help(monkeypatch, capsys):
    for names in [(), *[(name,) for name in get_group(app).commands]]:
        monkeypatch.setenv("COLUMNS", "80")
        text = command(monkeypatch, capsys, *names, "--help")()
        assert max(map(len, text.splitlines())) <= 80


def test_the_tables_at_the_end_of_a_run(small_run, tmp_path, monkeypatch, capsys):
    made_up = fabricate(tmp_path / "made-up", 3, ("gusts", "calm air"))
    for folder in (small_run[1], made_up):
        summary = Summary.read(folder / "summary.json")
        told = printed(
            capsys,
            lambda c, s=summary: c.print(gains_table(s, c.width)),
            lambda c, s=summary: c.print(comparison_table(s)),
            lambda c, f=folder: print_end_tables(TuningFolder(f), c),
        )
        check_widths(told, monkeypatch, lost=range_ends(summary))


def range_ends(summary):
    """Texts of the ends of ranges, which stand beside the bar where there is room alone."""
    return {f"{end:g}" for row in summary.variables for end in (row.low, row.high)}


@pytest.mark.parametrize("objectives", [2, 3])
def test_show_a_run(objectives, tmp_path, monkeypatch, capsys):
    folder = fabricate(tmp_path / "made-up", objectives, ("gusts", "calm air"))
    # The ends of a range stand beside its bar where there is room, and numbers beside axes as these are.
    ends = range_ends(Summary.read(folder / "summary.json"))
    check_widths(command(monkeypatch, capsys, "show", folder), monkeypatch, lost=ends)


def test_show_a_contest(tmp_path, monkeypatch, capsys):
    folder = fabricate_contest(tmp_path / "made-up", Made())
    check_widths(command(monkeypatch, capsys, "show", folder), monkeypatch, lost={"quantity", "cell"})


def test_margins(small_run, monkeypatch, capsys):
    remembered(monkeypatch, "margins")
    check_widths(command(monkeypatch, capsys, "margins", "--law", "hybrid", codes=(1,)), monkeypatch)
    judged = ("margins", small_run[1] / "gains.json", "--study", QUICKSTART)
    check_widths(command(monkeypatch, capsys, *judged, codes=(0, 1)), monkeypatch, (60,))


def test_theory_and_cost(small_run, monkeypatch, capsys):
    for name in ("theory", "cost"):
        remembered(monkeypatch, name)
    check_widths(command(monkeypatch, capsys, "theory", small_run[1] / "gains.json"), monkeypatch)
    check_widths(command(monkeypatch, capsys, "cost"), monkeypatch)


def test_check(small_run, monkeypatch, capsys):
    for name in ("check", "judge"):
        remembered(monkeypatch, name)
    for name in ("quickstart", "contest"):
        check_widths(command(monkeypatch, capsys, "check", name), monkeypatch)
    judged = ("check", small_run[1] / "gains.json", "--requirements", QUICKSTART, "--seeds", "8")
    check_widths(command(monkeypatch, capsys, *judged, codes=(0, 1)), monkeypatch, (60, 80))


def test_design(tmp_path, monkeypatch, capsys):
    from tuner.api.designing import Design, margins_in
    from tuner.api.gains import gains_of
    from tuner.cli.printers.margins import print_design
    from tuner.study.build import load_study

    study = load_study(QUICKSTART)
    controller = study.controller(study.default_row)
    found = gains_of(controller, {})
    margins = {name: margins_in(study, controller) for name in ("default", "design")}
    design = Design(found, found, [], margins, [])
    check_widths(printed(capsys, lambda console: print_design(design, console)), monkeypatch)


def test_plan_compare_and_fly(small_run, tmp_path, monkeypatch, capsys):
    from tuner.cli.printers.compare import print_comparison
    from tuner.cli.printers.planning import show as show_plan

    gains = small_run[1] / "gains.json"
    plan = PlanDocument.parse(command(monkeypatch, capsys, "plan", QUICKSTART, "--json")())
    check_widths(printed(capsys, lambda console: show_plan(plan, console)), monkeypatch)
    other = changed_gains(gains, tmp_path / "a_name_that_takes_some_room.json", 0.5)
    found = ComparisonDocument.parse(
        command(monkeypatch, capsys, "compare", small_run[1], other, "--seeds", "16", "--json")()
    )
    check_widths(printed(capsys, lambda console: print_comparison(found, console)), monkeypatch)
    flown = command(monkeypatch, capsys, "fly", gains, "--seeds", "4")
    # The first flight may have to tell of a kernel that is compiled.
    flown()
    # The drawn lines differ with the width; nothing else does.
    check_widths(flown, monkeypatch, (60, 80))


def test_thousands_are_parted_by_commas(capsys):
    table = TerminalTable("Flights")
    table.add_column("at most")
    table.add_row(count(46275))
    for text in (count(12345), table):
        Console().print(text)
    assert re.findall(r"\d\S*", capsys.readouterr().out) == ["12,345", "46,275"]


def test_a_pipe_is_as_wide_as_columns_says_else_as_meanings_need(monkeypatch, capsys):
    def widest():
        return max(map(len, command(monkeypatch, capsys, "list", "metrics")().splitlines()))

    monkeypatch.delenv("COLUMNS", raising=False)
    assert 80 < widest() <= PIPE_WIDTH
    for columns, width in (("70", 70), ("0", PIPE_WIDTH), ("wide", PIPE_WIDTH), ("", PIPE_WIDTH)):
        monkeypatch.setenv("COLUMNS", columns)
        assert 60 < widest() <= width


def rendered(table, width):
    console = Console(width=width, color_system=None)
    with console.capture() as captured:
        console.print(table)
    return [line.rstrip() for line in captured.get().splitlines()]


def two_by_three(keys):
    table = TerminalTable("Title", keys=keys)
    for name in ("name", "alpha beta", "gamma"):
        table.add_column(name)
    table.add_row("first-row", "aaaa bbbb", "cccccc")
    table.add_row(Text("second"), "d", "")
    return table


TOLD = {
    (0, 29): """
Title
name       alpha beta  gamma
─────────────────────────────
first-row  aaaa bbbb   cccccc
second     d
""",
    (0, 25): """
Title
           alpha
name       beta    gamma
─────────────────────────
first-row  aaaa    cccccc
           bbbb
second     d
""",
    (1, 23): """
Title
name       alpha beta
─────────────────────
first-row  aaaa bbbb
second     d

name       gamma
─────────────────
first-row  cccccc
second
""",
    (0, 23): """
Title
first-row
  alpha beta  aaaa bbbb
  gamma       cccccc
second
  alpha beta  d
""",
    (0, 20): """
Title
first-row
  alpha beta  aaaa
              bbbb
  gamma       cccccc
second
  alpha beta  d
""",
}


@pytest.mark.parametrize(("keys", "width"), TOLD)
def test_a_table_narrows_between_words_then_splits_or_stacks(keys, width):
    # A blank line follows a table with a title.
    assert "\n".join(["", *rendered(two_by_three(keys), width)]) == TOLD[keys, width]
