"""Base of every JSON document that the tool writes: a frozen model that writer, reader, schema and tests share.

A document is validated on reading: a missing or wrong value becomes a StoreError that names the file and the key. Keys that
earlier versions did not write have a default, and a document is written with the keys that it was given and no others, so that
what was read comes out again as it stood.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError
from pydantic_core import CoreSchema, core_schema

from plant.errors import StoreError
from plant.input_files import check_json_size, parse_json, read_input_text
from plant.output_files import make_folders, write_new_file
from tuner.store.advice import kind_of, repair_hint
from tuner.text.input_errors import Fault


@dataclass(frozen=True)
class OneOf:
    """Annotation of a text that is one of a few; writers hold such texts as plain ones."""

    allowed: tuple[str, ...]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        return core_schema.literal_schema(list(self.allowed))


OLD_SENSES = {"most": "max", "least": "min"}
"""Words of documents of version 0.2 and before, which are read as those of today."""
Scale = Annotated[str, OneOf(("linear", "log"))]
Sense = Annotated[str, OneOf(("max", "min")), BeforeValidator(lambda word: OLD_SENSES.get(str(word), word))]
"""Whether a limit is an upper or a lower one, with the keys that a study gives it under."""
Json = Any
"""A value of a study file, which its own schema describes."""


class DocumentPart(BaseModel):
    """An object inside a document; names are those of its keys, all values in SI units, angles in rad."""

    model_config = ConfigDict(
        strict=True,
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        populate_by_name=True,
        defer_build=True,
    )

    def content(self) -> dict[str, Any]:
        """Return the JSON data, keys in the order of the model."""
        return self.model_dump(by_alias=True, exclude_unset=True)


class Document(DocumentPart):
    """The content of one JSON file."""

    def text(self) -> str:
        """Return the document as the text of its file."""
        return json_text(self.content())

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the document that a text holds; raises pydantic's ValidationError, see `explained`, or ValueError."""
        check_json_size(text)
        return cls.model_validate_json(text)

    @classmethod
    def read(cls, file: Path) -> Self:
        """Return the document in a file; StoreError names the file and the key that is missing or wrong."""
        text = read_text(file)
        try:
            return cls.parse(text)
        except ValidationError as error:
            raise refuse(file, explained(error, text)) from None
        except ValueError as error:
            raise refuse(file, str(error)) from None


def json_text(content: Any, ascii_only: bool = False) -> str:
    """Return data as the text of a JSON file; non-finite numbers are our own mistake."""
    return json.dumps(content, indent=2, allow_nan=False, ensure_ascii=ascii_only) + "\n"


def write_new(path: Path, content: Any, parents: bool = False) -> Path:
    """Write a JSON file that must not exist yet; parents: with the folders above it."""
    try:
        if parents:
            make_folders(path.parent)
        write_new_file(path, json_text(content).encode())
    except FileExistsError:
        raise taken(path) from None
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror}); choose another file with --out") from error
    return path


def taken(path: Path) -> StoreError:
    """Return the error for a file that exists already."""
    return StoreError(f"{path} exists already and was not touched; choose another file with --out")


def refuse(file: Path, what: str) -> StoreError:
    """Return the error for a file that cannot be used; what: what is wrong with it."""
    folder = next((above for above in list(file.parents)[:2] if kind_of(above) is not None), file.parent)
    return StoreError(f"{file}: {what}; {repair_hint(folder, file.relative_to(folder).as_posix())}")


def read_text(file: Path) -> str:
    """Return the content of a text file."""
    try:
        return read_input_text(file)
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise refuse(file, f"the file cannot be read ({error})") from None


def explained(error: ValidationError, text: str) -> str:
    """Return the first error of a document's text, as a sentence's beginning."""
    fault = Fault.of(error.errors(include_url=False)[0])
    kind, given, context = fault.kind, fault.given, fault.context
    if kind == "json_invalid":
        return _not_json(text, fault.message)
    key = _key(fault, json.loads(text))
    if kind == "missing":
        return f"the key '{key}' is missing"
    if kind == "extra_forbidden":
        return f"the key '{key}' is none that this version knows"
    if kind == "union_tag_not_found":
        return f"the key '{_below(key, context['discriminator'])}' is missing"
    if kind == "union_tag_invalid":
        inner = context["discriminator"].strip("'")
        return f"'{_below(key, inner)}' is {context['tag']!r:.60} and neither of {context['expected_tags'].replace(chr(39), '')}"
    if kind == "value_error":
        return str(context["error"])
    return f"'{key or 'the file'}' is {given!r:.60} and not {_expected(kind, given, context)}"


NAMES = {
    "float_type": "a number", "finite_number": "a finite number", "int_type": "a whole number", "bool_type": "true or false",
    "string_type": "a text", "list_type": "a list", "dict_type": "an object", "model_type": "an object",
    "model_attributes_type": "an object", "greater_than_equal": "a number of that size",
}  # fmt: skip


def _expected(kind: str, given: Any, context: dict[str, Any]) -> str:
    if kind == "literal_error":
        return f"one of {context['expected']}"
    if kind == "float_type" and isinstance(given, bool):
        return "a finite number"
    return NAMES.get(kind, "what should stand there")


def _not_json(text: str, otherwise: str) -> str:
    try:
        parse_json(text)
    except json.JSONDecodeError as error:
        return f"not JSON, {error.msg} in line {error.lineno}"
    except ValueError:
        pass
    return f"not JSON ({otherwise:.80})"


def _key(fault: Fault, content: Any) -> str:
    """Return the dotted place of an error; steps that represent a choice of the model and not for a key are left out."""
    key = ""
    for step in fault.place:
        if isinstance(step, int):
            key, content = f"{key}[{step}]", content[step]
        elif isinstance(content, dict) and step in content:
            key, content = _below(key, step), content[step]
    return _below(key, str(fault.place[-1])) if fault.kind == "missing" else key


def _below(key: str, name: str) -> str:
    name = name.strip("'")
    return f"{key}.{name}" if key else name
