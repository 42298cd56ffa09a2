"""`tuner schema`: the JSON Schema of a file that the tool writes."""

from collections.abc import Callable

from plant.errors import UnknownNameError
from tuner.gains.schema import schema_text

SCHEMAS: dict[str, Callable[[], str]] = {"gains": schema_text}


def schema_command(name: str) -> None:
    """Print a schema."""
    if name not in SCHEMAS:
        raise UnknownNameError("schema", name, SCHEMAS)
    print(SCHEMAS[name](), end="")
