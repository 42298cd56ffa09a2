"""Reference pages generated from the program: study file, gains.json, command line, and what there is to choose from."""

import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import typer
from law_pages import laws_page
from pydantic import BaseModel
from schema_tables import Document, Row, Section, attribute_docstrings, cell, written
from typer.testing import CliRunner

from tuner.cli.main import app
from tuner.extensions.contests.tables import ChoicesTable, ContestTable
from tuner.extensions.trials.study import TrialStudyTable
from tuner.study.plant_schema import PlantStudyTable
from tuner.study.schema import StrictTable, StudyTable

KINDS: tuple[tuple[str, type[BaseModel]], ...] = (
    ("Tuning", StudyTable),
    ("Plant of one's own", PlantStudyTable),
    ("Contest", ContestTable),
    ("Choices", ChoicesTable),
    ("Trials of another program", TrialStudyTable),
)
MEANINGS = {table.__name__: attribute_docstrings(table) for table in StrictTable.__subclasses__()}
"""Meanings of the keys of each table, by the name of its class."""
CHOICES = {
    "laws": "Control laws", "airframes": "Airframes", "firmwares": "Firmwares", "references": "References", "metrics": "Metrics",
    "risks": "Risk measures", "signals": "Signals of plants",
    "margins": "Stability margins", "theorems": "Theorems", "searches": "Search algorithms", "targets": "Export targets",
    "sources": "Import sources", "studies": "Shipped studies",
}  # fmt: skip
STUDY_HEAD = """# Study file

Every table and key of a study file, generated from the schema that `tuner check` uses. A file is TOML. Numbers are
in SI units and angles in radians, unless the key ends in `_deg` or the table says otherwise. An unknown key is an error.
`[name]` is written once, `[[name]]` as often as needed. `tuner new NAME` writes a study with a comment on each line;
[what there is to choose from](choices.md) lists the names that a key takes. [What may change](stability.md) explains how
keys change between versions.

## In an editor

`tuner schema study` prints the same tables as a JSON Schema (2020-12). With it an editor completes keys and names, shows
meanings and ranges, and marks errors:

```sh
tuner schema study > study.schema.json      # or plant-study, contest-study, choices-study, trials-study
```

Editors with Taplo, such as VS Code with *Even Better TOML*, Helix and Neovim, take it from the first line of the study:

```toml
#:schema study.schema.json
title = "Quickstart"
```

On the command line, `taplo check my_study.toml` reads that line too. Only `tuner check` validates rules between keys, such as the
gains of a law, and what a file of your own defines.
"""
GAINS_HEAD = """# Keys of gains.json

Generated from the JSON Schema that `tuner schema gains` prints; [the page on the file](gains_file.md) explains the parts.
Every quantity is an object with `value` and `unit` (UCUM).
"""
COMMANDS_HEAD = """# Command line

Generated from `tuner --help` and the help of each command. Exit codes are in [reading the
report](reading_the_report.md#nothing-feasible).
"""
CHOICES_HEAD = """# What there is to choose from

Names that a study file and the command line take, as `tuner list` prints them for this version.
"""


NAMES = ("study_file.md", "gains_keys.md", "commands.md", "choices.md", "laws.md")
"""Generated pages."""


def pages() -> dict[str, str]:
    """Return the generated pages, Markdown by name."""
    texts = study_page(), gains_page(), commands_page(), choices_page(), laws_page(markdown_table)
    return dict(zip(NAMES, texts, strict=True))


def study_page() -> str:
    """Return the reference of the study file, a part for each kind of study."""
    parts = [STUDY_HEAD]
    for kind, model in KINDS:
        document = Document(model.model_json_schema())
        parts.append(f"## {kind}\n\n{meaning_of(document.schema)}\n")
        for section in sections(document, document.schema, ""):
            heading = f"### {section.path}\n\n{section.about}\n\n" if section.path else ""
            parts.append(heading + table_of(document, section))
        if model is PlantStudyTable:
            parts.append(signals_section())
    return "\n".join(parts)


def signals_section() -> str:
    """Return the keys of a signal, by its kind."""
    rows = [
        (
            f"`{row['signal']}`",
            "either" if row["follows"] == "yes" else "disturbance",
            f"`{row['parameters']}`",
            row["about"],
        )
        for row in json.loads(output_of("list", "signals", "--json"))
    ]
    head = "### [scenario.reference.NAME], [scenario.disturbance.NAME]\n\nA signal by its `kind`, with the keys of that kind.\n\n"
    return head + markdown_table(("kind", "of", "keys with their defaults", "meaning"), rows)


def sections(document: Document, schema: Row, path: str, about: str = "") -> Iterator[Section]:
    """Yield the table at a path of a study and, depth first, the tables inside it."""
    section, inner = Section(path, about), []
    told = MEANINGS.get(schema.get("title", ""), {})
    for key, entry in schema.get("properties", {}).items():
        held = {"description": told.get(key, ""), **document.followed(entry)}
        place = f"{path.strip('[]')}.{key}" if path else key
        if held.get("type") == "array" and document.is_table(held.get("items", {})):
            inner.append((document.followed(held["items"]), f"[[{place}]]", ""))
        elif document.is_table(held):
            inner.append((held, f"[{place}]", ""))
        elif table := table_of_any_keys(document, held):
            # Beside tables a table may hold plain numbers, as [gains] does; its keys are names of the user's then too.
            named = "" if "oneOf" in held["additionalProperties"] else ".NAME"
            inner.append((table, f"[{place}{named}]", held["description"]))
        else:
            if table := table_among_entries(document, held):
                inner.append((table, f"[[{place}]]", ""))
            section.keys[key] = {**held, "required": key in schema.get("required", ())}
    if section.keys:
        yield section
    for table, place, more in inner:
        yield from sections(document, table, place, " ".join([more, meaning_of(table)]).strip())


def meaning_of(table: Row) -> str:
    """Return what the docstring of a table says behind the table's name."""
    text = table.get("description", "")
    meaning = cell(text.partition("]: ")[2] or text)
    return meaning[:1].upper() + meaning[1:]


def table_of_any_keys(document: Document, schema: Row) -> Row | None:
    """Return the table that each key of a table of free keys holds, None where there is none."""
    entry = schema.get("additionalProperties")
    if not isinstance(entry, dict):
        return None
    tables = [document.followed(part) for part in entry.get("oneOf", [entry]) if document.is_table(part)]
    return tables[0] if tables else None


def table_among_entries(document: Document, schema: Row) -> Row | None:
    """Return the table that an entry of a list may be beside a text, None where it may not."""
    tables = [document.followed(part) for part in schema.get("items", {}).get("oneOf", ()) if document.is_table(part)]
    return tables[0] if tables else None


def table_of(document: Document, section: Section) -> str:
    """Return the keys of a table as Markdown."""
    rows = []
    for key, entry in section.keys.items():
        usual = "required" if entry["required"] else shown_default(entry)
        rows.append((f"`{key}`", document.kind(entry), usual, entry.get("description", "")))
    return markdown_table(("key", "takes", "default", "meaning"), rows)


def shown_default(entry: Row) -> str:
    """Return the default of a key as a study would write it, empty where it is left out."""
    default = entry.get("default")
    return "" if default is None else f"`{written(default)}`"


def gains_page() -> str:
    """Return the reference of the keys of gains.json."""
    document = Document(json.loads(output_of("schema", "gains")))
    parts = [GAINS_HEAD]
    for place, schema in objects(document, document.schema, ""):
        required = schema.get("required", ())
        rows = [
            (
                f"`{key}`",
                gains_kind(document, entry),
                "" if key in required else "may be absent",
                entry.get("description", ""),
            )
            for key, entry in schema["properties"].items()
        ]
        heading = f"## {place}\n\n" if place else ""
        parts.append(f"{heading}{markdown_table(('key', 'holds', 'presence', 'meaning'), rows)}")
    return "\n".join(parts)


def objects(document: Document, schema: Row, path: str) -> Iterator[tuple[str, Row]]:
    """Yield the objects of a document, each with its path, outermost first; quantities are no objects of their own."""
    if not schema.get("properties") or is_quantity(schema):
        return
    yield path, schema
    for key, entry in schema["properties"].items():
        held = document.followed(entry)
        listed = held.get("type") == "array"
        inner = document.followed(held.get("items", {})) if listed else held
        yield from objects(document, inner, f"{path}.{key}".lstrip(".") + ("[]" if listed else ""))


def is_quantity(schema: Row) -> bool:
    """Return whether an object is a value with its unit."""
    return {"value", "unit"} <= set(schema.get("properties", ()))


def gains_kind(document: Document, entry: Row) -> str:
    """Return in words what a key of gains.json holds."""
    held = document.followed(entry)
    if is_quantity(held):
        unit = held["properties"]["unit"]
        return f"quantity in `{unit['const']}`" if "const" in unit else "quantity"
    if held.get("type") == "array" and document.is_table(held.get("items", {})):
        return "list of objects"
    return document.kind(held).replace("table", "object")


def commands_page() -> str:
    """Return the reference of the command line."""
    parts = [COMMANDS_HEAD]
    group: Any = typer.main.get_command(app)
    for name in sorted(group.commands):
        command = group.commands[name]
        if command.hidden:
            continue
        rows = [
            (f"`{called(option)}`", cell(option.help or "") if hasattr(option, "help") else "")
            for option in command.params
            if not getattr(option, "hidden", False) and option.name != "help"
        ]
        table = f"\n\n{markdown_table(('argument or option', 'meaning'), rows)}" if rows else ""
        parts.append(f"## tuner {name}\n\n{help_of(command.help or '')}{table}")
    return "\n".join(parts)


def help_of(text: str) -> str:
    """Return the help of a command with its examples as code."""
    lines = [line.strip() for line in text.replace("\f", "\n").splitlines()]
    shown = [f"`{line.removeprefix('Example: ')}`" if line.startswith("Example: ") else line for line in lines]
    return "\n".join(shown).strip() + "\n"


def called(option: Any) -> str:
    """Return how an argument or option is written."""
    return ", ".join(option.opts) if option.param_type_name == "option" else option.name.upper()


def choices_page() -> str:
    """Return the registries as tables."""
    parts = [CHOICES_HEAD]
    for what, title in CHOICES.items():
        rows = [row for row in json.loads(output_of("list", what, "--json")) if row]
        # A path belongs to the machine that builds the page.
        columns = [key for key in rows[0] if key != "file"]
        parts.append(f"## {title}\n\n{markdown_table(columns, [[shown(row[key]) for key in columns] for row in rows])}")
    return "\n".join(parts)


def shown(value: Any) -> str:
    """Return a figure of a list as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(map(shown, value))
    return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table without the columns that hold nothing."""
    rows = list(rows)
    held = [i for i in range(len(head)) if any(row[i] for row in rows)]
    lines = [[line[i] for i in held] for line in (head, ["---"] * len(head), *rows)]
    return "".join(f"| {' | '.join(cell(entry) for entry in line)} |\n" for line in lines)


def output_of(*arguments: str) -> str:
    """Return what a command prints."""
    result = CliRunner().invoke(app, list(arguments))
    if result.exit_code != 0:
        raise RuntimeError(f"tuner {' '.join(arguments)}: {result.output}")
    return result.output
