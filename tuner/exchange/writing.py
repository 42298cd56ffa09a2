"""The folder of an export: the target's files, rollback/ with what to go back to, export.json, and gains.json with its record."""

import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path, PurePosixPath
from typing import Any, TypedDict

from plant.errors import StoreError
from plant.output_files import make_folders, refuse_links_to, write_new_file
from tuner.documents.export import EXPORT_FORMAT, EXPORT_VERSION, ExportDocument, ExportedParameter, VerificationPart
from tuner.documents.parts import LawNames
from tuner.exchange.aboard import origin
from tuner.exchange.target import C, ExportBundle, ExportRequest, ExportTarget, HeldParameter
from tuner.exchange.texts import tool
from tuner.gains.sections import Row
from tuner.store.manifest import digest_of

# Beyond it a bound is that of a number type, not of a parameter.
LARGEST = 1e30


class LoopNames(TypedDict, total=False):
    """Names of airframe and laws, or of plant and channel laws."""

    airframe: str
    laws: LawNames
    plant: str
    channel_laws: dict[str, str]


def export_document(
    target: ExportTarget,
    request: ExportRequest[C],
    bundle: ExportBundle[C],
    verification: VerificationPart,
    names: LoopNames,
) -> ExportDocument:
    """Return the content of export.json."""
    return ExportDocument(
        format=EXPORT_FORMAT,
        version=EXPORT_VERSION,
        generator=tool(),
        target=target.name,
        target_version=bundle.target_version,
        title=target.title,
        experimental=target.experimental or None,
        **names,
        gains_sha256=request.digest,
        files={name: digest_of(content) for name, content in bundle.files.items()},
        rollback=sorted(bundle.rollback),
        settings=dict(request.settings),
        before=origin(request, target.name),
        lossy=list(bundle.differences),
        parameters=[exported(parameter) for parameter in bundle.parameters],
        verification=verification,
    )


def exported(parameter: HeldParameter) -> ExportedParameter:
    """Return a parameter as a row of export.json."""
    change = None if parameter.before is None else parameter.held - parameter.before
    row = {**asdict(parameter), "change": change}
    row |= {"asked": row.pop("unrounded"), "kept": row.pop("is_unmanaged")}
    return ExportedParameter(**{key: _finite(value) for key, value in row.items()})


def export_records(document: ExportDocument) -> list[Row]:
    """Return the records of an export in gains.json, one for each file."""
    return [
        {
            "target": document.target,
            "target_version": document.target_version,
            "file": name,
            "sha256": digest,
            "lossy": document.lossy,
        }
        for name, digest in document.files.items()
    ]


def write_export(out: Path, bundle: ExportBundle[C], document: ExportDocument, gains: Row) -> None:
    """Write everything into a folder that must not hold anything yet; it appears whole or not at all.

    gains: content of gains.json. Raises StoreError where it cannot be written or something stands there.
    """
    files = {**bundle.files, **{f"rollback/{name}": content for name, content in bundle.rollback.items()}}
    write_files(out, files | {"export.json": as_json(document.content()), "gains.json": as_json(gains)})


def write_files(out: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a folder that must not hold anything yet; it appears whole or not at all. Raises StoreError."""
    check_free(out)
    part = out.with_name(f".{out.name}.part{os.getpid()}")
    try:
        for name, content in files.items():
            assert not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts, name
            target = part / name
            make_folders(target.parent)
            write_new_file(target, content)
        if out.exists():
            out.rmdir()
        part.rename(out)
    except OSError as error:
        raise StoreError(f"{out} cannot be written ({error.strerror}); choose another folder with --out") from error
    finally:
        shutil.rmtree(part, ignore_errors=True)


def check_free(out: Path) -> None:
    """Raise StoreError where anything stands at the place of an export."""
    refuse_links_to(out)
    if out.is_symlink() or (out.exists() and (not out.is_dir() or any(out.iterdir()))):
        raise StoreError(f"{out} exists already and was not touched; choose another folder with --out, or empty it")


def as_json(document: Row) -> bytes:
    """Return JSON text as bytes."""
    # Half of a surrogate pair, which UTF-8 does not hold, comes out as the escape that JSON has for it.
    text = json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    return text.encode("utf-8", "backslashreplace")


def _finite(value: Any) -> Any:
    """Return null for a bound that is none: infinite, or the end of a number type."""
    return None if isinstance(value, float) and not abs(value) < LARGEST else value
