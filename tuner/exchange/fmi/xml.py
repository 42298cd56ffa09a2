"""XML as text: elements with attributes in the order given, indented, the same bytes every time."""

from collections.abc import Iterable, Mapping

from tuner.exchange.texts import xml_text

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def element(name: str, attributes: Mapping[str, object] = {}, children: Iterable[str] = ()) -> str:  # noqa: B006
    """Return an element; children: elements as text, one after the other."""
    given = "".join(f' {key}="{xml_text(_text(value))}"' for key, value in attributes.items())
    inner = "\n".join(children)
    if not inner:
        return f"<{name}{given}/>"
    indented = "\n".join(f"  {line}" for line in inner.split("\n"))
    return f"<{name}{given}>\n{indented}\n</{name}>"


def document(root: str) -> bytes:
    """Return a whole file."""
    return (HEAD + root + "\n").encode()


def _text(value: object) -> str:
    """Return a number so that it reads back to the same bits, a truth value as XML has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(float(value)) if isinstance(value, float) else str(value)
