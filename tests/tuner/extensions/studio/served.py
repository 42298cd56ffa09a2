"""A studio at work in a thread, and a client with plain sockets: no browser, so every header is ours."""

import json
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from threading import Thread

from tuner.extensions.studio.answering import Bench
from tuner.extensions.studio.guard import HEADER, HOST, Door
from tuner.extensions.studio.outputs import Outputs
from tuner.extensions.studio.server import Studio, bound_socket, server_of
from tuner.extensions.studio.session import open_session
from tuner.extensions.studio.work import Work


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
    session = open_session(given, study)
    listening = bound_socket(0)
    door = Door(listening.getsockname()[1])
    bench = Bench.of(session, 2)
    work = Work(bench)
    page = Studio(work, door, Outputs(bench, out))
    server = server_of(page)
    thread = Thread(target=server.run, args=([listening],))
    thread.start()
    try:
        yield bench, Client(door)
    finally:
        server.should_exit = True
        thread.join()
        page.searches.close()
        work.close()
        listening.close()
