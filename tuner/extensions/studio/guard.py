"""The door of the server: who may ask, and how much.

A page of another site, another user of the machine and a name that resolves to this machine are refused: the host has to be the
loopback address, the origin the page's own, and every request carries the token, a cookie that the first address sets.
"""

import hmac
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

HOST = "127.0.0.1"
"""Address that the server listens on."""
NAMES = (HOST, "localhost")
"""Names of the server in the header Host."""
MAX_BYTES = 65_536
"""Bytes of the body of a request."""
TOKEN = "token"
"""Name of the token in the first address."""
HEADER = b"x-studio-token"
"""Header with the token, for programs without cookies."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content-Security-Policy: scripts are the server's files alone; plotly.js writes styles."""
HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


@dataclass(frozen=True)
class Door:
    """Address and token of a server.

    Attributes:
        port: Port that it listens on.
        token: Random token of this run.
        embeds: Whether a notebook may frame the page; addresses then hold the token, since foreign frames have no cookies.
    """

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)
    embeds: bool = False

    @property
    def origin(self) -> str:
        """Origin of its page."""
        return f"http://{HOST}:{self.port}"

    @property
    def address(self) -> str:
        """First address, with the token."""
        return f"{self.origin}/?{TOKEN}={self.token}"

    @property
    def query(self) -> str:
        """End of the page's addresses: the token where no cookie holds it."""
        return f"?{TOKEN}={self.token}" if self.embeds else ""

    @property
    def headers(self) -> dict[str, str]:
        """Headers of the page."""
        allowed = " ".join(f"http://{name}:*" for name in NAMES) if self.embeds else "'none'"
        policy = POLICY.replace("frame-ancestors 'none'", f"frame-ancestors {allowed}")
        return {**HEADERS, "Content-Security-Policy": policy}

    @property
    def cookie(self) -> str:
        """Name of its cookie; browsers share cookies between ports, so it holds the port."""
        return f"studio-{self.port}"

    def knows(self, given: str) -> bool:
        """Return True for the token, compared in constant time."""
        return hmac.compare_digest(given.encode(), self.token.encode())

    def refusal(self, scope: Scope) -> Response | None:
        """Return the refusal of a request, None for one that may pass."""
        headers = Headers(scope=scope)
        names = {f"{name}:{self.port}" for name in NAMES}
        if headers.get("host", "") not in names:
            return _refused(403, "The page is served to this machine alone.")
        origin = headers.get("origin")
        if origin is not None and origin not in {f"http://{name}" for name in names}:
            return _refused(403, "Requests of other pages are refused.")
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get(TOKEN, [""])[0]
        has_token = bool(given) and self.knows(given)
        is_frame = self.embeds and has_token and (scope["method"], scope["path"]) == ("GET", "/")
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none") and not is_frame:
            return _refused(403, "Requests of other pages are refused.")
        if scope["method"] not in ("GET", "POST"):
            return _refused(405, "Allowed: GET and POST.")
        if has_token and not self.embeds and (scope["method"], scope["path"]) == ("GET", "/"):
            return self._entered()
        if has_token and self.embeds:
            return None
        held = cookie_parser(headers.get("cookie", "")).get(self.cookie, "")
        if self.knows(held) or self.knows(headers.get(HEADER.decode(), "")):
            return None
        return _refused(403, "Open the address that `tuner studio` printed; it holds the token of this run.")

    def _entered(self) -> Response:
        """Return the redirection to the page without the token in its address."""
        response = RedirectResponse("/", status_code=303, headers=dict(HEADERS))
        response.set_cookie(self.cookie, self.token, httponly=True, samesite="strict", path="/")
        return response


def _refused(code: int, text: str) -> Response:
    return PlainTextResponse(text, status_code=code, headers=dict(HEADERS))


class Guard:
    """Middleware that refuses strangers and long messages to the application behind it."""

    def __init__(self, app: ASGIApp, door: Door) -> None:
        self._app, self._door = app, door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        # No web socket is served.
        elif scope["type"] == "http":
            refused = self._door.refusal(scope) or _too_long(Headers(scope=scope))
            await (self._app(scope, limited(receive), send) if refused is None else refused(scope, receive, send))


def _too_long(headers: Headers) -> Response | None:
    length = headers.get("content-length", "0")
    if not length.isascii() or not length.isdigit() or int(length) > MAX_BYTES:
        return _refused(413, f"A message may have at most {MAX_BYTES} bytes.")
    return None


class TooLongError(Exception):
    """A body beyond the limit that announced no length."""


def limited(receive: Receive) -> Receive:
    """Return a receiver that ends a body beyond the limit."""
    seen = 0

    async def counted() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > MAX_BYTES:
            raise TooLongError
        return message

    return counted
