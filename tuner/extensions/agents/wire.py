"""Messages that cannot be read: each is answered with an error of JSON-RPC, for its sender waits for an answer."""

from typing import Any

from anyio.abc import ObjectReceiveStream
from mcp.shared.message import SessionMessage
from mcp.types import INVALID_REQUEST, PARSE_ERROR, ErrorData, JSONRPCError
from pydantic import ValidationError

from plant.input_files import parse_json


class ReadableMessages(ObjectReceiveStream[SessionMessage | Exception]):
    """The received messages that can be read.

    Args:
        received: stream of messages, and of an exception for each one that cannot be read.
        sent: stream that takes the answers to those.
    """

    def __init__(self, received: Any, sent: Any) -> None:
        self._received, self._sent = received, sent

    async def receive(self) -> SessionMessage:
        """Return the next message."""
        while isinstance(item := await self._received.receive(), Exception):
            await self._sent.send(SessionMessage(error_for(item)))
        return item

    async def aclose(self) -> None:
        """Close the stream of messages."""
        await self._received.aclose()

    @property
    def last_context(self) -> Any:
        """Context in which the last message was received."""
        return self._received.last_context


def error_for(exception: Exception) -> JSONRPCError:
    """Return the error that answers an unreadable message."""
    content, code, message = None, INVALID_REQUEST, "is no message of JSON-RPC 2.0"
    problems = exception.errors() if isinstance(exception, ValidationError) else []
    if any(each["type"] == "json_invalid" for each in problems):
        code, message = PARSE_ERROR, "is no JSON in Unicode; surrogates stand in pairs"
        content = _parsed(str(problems[0]["input"]))
    # Whatever is missing is missing in the whole message, as one of the four kinds that it could be.
    content = next((each["input"] for each in problems if each["type"] == "missing" and len(each["loc"]) == 2), content)
    number = content.get("id") if isinstance(content, dict) else None
    is_id = isinstance(number, int) and not isinstance(number, bool) or isinstance(number, str) and number.isprintable()
    return JSONRPCError(
        jsonrpc="2.0", id=number if is_id else None, error=ErrorData(code=code, message=f"The message {message}.")
    )


def _parsed(text: str) -> Any:
    """Return content that Python's reader takes, None where it takes none: it takes lone surrogates."""
    try:
        return parse_json(text)
    except ValueError:
        return None
