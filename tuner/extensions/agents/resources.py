"""Resources of an agent: shipped studies, lists, schemas, and the results of its folder."""

import os
from collections.abc import Callable
from pathlib import Path
from urllib.parse import quote, unquote

from mcp.types import Resource, ResourceTemplate

from plant.errors import InputError
from plant.input_files import read_input_text
from tuner.api.catalogue import about_of, listings, rows_of
from tuner.api.frames import json_text
from tuner.documents.registry import schema_names, schema_of
from tuner.extensions.agents.answers import DATA
from tuner.extensions.agents.places import is_inside
from tuner.extensions.agents.tools import RESULTS
from tuner.study.files import shipped_studies

SCHEME = "tuner://"
JSON, TOML = "application/json", "application/toml"


def resources(root: Path) -> list[Resource]:
    """Return all resources; of results, those of the folder `results`."""
    runs = sorted(path.name for path in (root / RESULTS).glob("*") if path.is_dir() and is_inside(path, root))
    return [
        *[_resource(f"studies/{name}", f"Shipped study {name}.", TOML) for name in shipped_studies()],
        *[_resource(f"lists/{kind}", f"{about_of(kind)}.", JSON) for kind in listings()],
        *[_resource(f"schemas/{name}", f"JSON Schema of {name}.", JSON) for name in schema_names()],
        *[_resource(f"{RESULTS}/{quote(os.fsencode(name))}", f"Results of a run. {DATA}", JSON) for name in runs],
    ]


def templates() -> list[ResourceTemplate]:
    """Return the template of results."""
    return [
        ResourceTemplate(
            uri_template=f"{SCHEME}{RESULTS}/{{name}}",
            name=RESULTS,
            description="Results of a run in the folder `results`: setup, result, reliability, next step.",
            mime_type=JSON,
        )
    ]


def run_of(uri: str) -> str | None:
    """Return the folder of results that a resource is, None for another; InputError where it is no name."""
    kind, _, name = uri.removeprefix(SCHEME).partition("/")
    if not uri.startswith(SCHEME) or kind != RESULTS:
        return None
    folder = unquote(name)
    if not folder or folder in (".", "..") or "/" in folder:
        raise InputError(f"given {folder!r}; it must be the name of a folder in {RESULTS}")
    return f"{RESULTS}/{folder}"


def content_of(uri: str) -> tuple[str, str]:
    """Return text and type of a resource that is no run's; InputError where there is none."""
    kind, _, name = uri.removeprefix(SCHEME).partition("/")
    readers: dict[str, tuple[Callable[[str], str], str]] = {
        "studies": (_study, TOML),
        "lists": (lambda kind: json_text(rows_of(kind)), JSON),
        "schemas": (schema_of, JSON),
    }
    if not uri.startswith(SCHEME) or kind not in readers or not name:
        raise InputError(
            f"there is no resource {uri!r}; it begins with {SCHEME} and one of {', '.join([*readers, RESULTS])}"
        )
    read, mime_type = readers[kind]
    return read(unquote(name)), mime_type


def _resource(place: str, description: str, mime_type: str) -> Resource:
    return Resource(
        uri=f"{SCHEME}{place}", name=place, description=description, mime_type=mime_type, _meta={"note": DATA}
    )


def _study(name: str) -> str:
    if (file := shipped_studies().get(name)) is None:
        raise InputError(f"there is no shipped study {name!r}; there are {', '.join(shipped_studies())}")
    return read_input_text(file)
