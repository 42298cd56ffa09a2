"""A studio at work in a thread, and a client with plain sockets: no browser, so every header is ours."""

import json
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from threading import Thread

from tuner.extensions.studio.guard import HEADER, HOST
from tuner.extensions.studio.server import opened_page, server_of
from tuner.extensions.studio.session import open_session


class Client:
    """Requests to a door; the token goes in the header unless others are given."""

    def __init__(self, door):
        self.door = door

    def ask(self, path, content=None, body=None, headers=None, method=None):
        """Status, headers and text of an answer."""
        connection = HTTPConnection(HOST, self.door.port, timeout=60)
        if body is None and content is not None:
            body = json.dumps(content).encode()
        own = {HEADER.decode(): self.door.token, "Content-Type": "application/json"}
        kept = {name: value for name, value in {**own, **(headers or {})}.items() if value is not None}
        connection.request(method or ("GET" if body is None else "POST"), path, body, kept)
        response = connection.getresponse()
        status, text = response.status, response.read()
        held = dict(response.getheaders())
        connection.close()
        return status, held, text

    def lines(self, path, content):
        """Documents of an answer, without progress."""
        status, _, text = self.ask(path, content)
        documents = [json.loads(line) for line in text.decode().splitlines()]
        assert status in (200, 400), text
        return [each for each in documents if "progress" not in each]


@contextmanager
def served(given: Path, out: Path, study: Path | None = None):
    """A studio and its client."""
    page, listening = opened_page(open_session(given, study), out, threads=2)
    server = server_of(page)
    thread = Thread(target=server.run, args=([listening],))
    thread.start()
    try:
        yield page.work.bench, Client(page.door)
    finally:
        server.should_exit = True
        thread.join()
        page.close()
        listening.close()
