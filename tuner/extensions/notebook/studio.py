"""The page from Python: `tuner.studio` serves it from a thread, and a notebook shows it in the cell."""

import atexit
import socket
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING

from plant.errors import InputError
from tuner.api.gains import Gains
from tuner.api.results import AnyResults, Results
from tuner.api.studies import StudyLike
from tuner.extensions.studio.command import check_places, require_server
from tuner.text.markup import element, join

if TYPE_CHECKING:
    from tuner.extensions.studio.server import Studio
    from tuner.extensions.studio.session import Session

HEIGHT = 900
"""Height of the frame in a notebook [px]."""


class RunningStudio:
    """A served page; a notebook shows it below the cell.

    Attributes:
        address: Address with the token of this run.
    """

    def __init__(self, page: "Studio", listening: socket.socket) -> None:
        from tuner.extensions.studio.server import server_of

        self.address = page.door.address
        self._page, self._listening, self._server = page, listening, server_of(page)
        self._thread = Thread(target=self._server.run, args=([listening],), name="studio", daemon=True)
        self._thread.start()
        atexit.register(self.stop)

    @property
    def is_running(self) -> bool:
        """Whether the page is served."""
        return self._thread.is_alive()

    def wait(self) -> None:
        """Serve until Ctrl-C, for a script that has nothing else to do."""
        try:
            self._thread.join()
        except KeyboardInterrupt:
            self.stop()

    def stop(self) -> None:
        """End the page, and a search that it started."""
        atexit.unregister(self.stop)
        self._server.should_exit = True
        self._thread.join()
        self._page.close()
        self._listening.close()

    def __repr__(self) -> str:
        return f"Studio: {self.address}" if self.is_running else "Studio, ended"

    def _repr_html_(self) -> str:
        if not self.is_running:
            return str(element("p", "Studio, ended."))
        link = element("a", self.address, href=self.address, target="_blank", rel="noopener")
        frame = element(
            "iframe", src=self.address, title="gainproof studio", width="100%", height=str(HEIGHT), style="border:0"
        )
        return str(join((element("p", "Studio: ", link), frame)))


def studio(
    given: StudyLike | AnyResults | Gains | None = None,
    *,
    study: StudyLike | None = None,
    out: str | Path = ".",
    present: str | Path | None = None,
    port: int = 0,
    threads: int | None = None,
) -> RunningStudio:
    """Serve a local page on which gains are moved by hand.

    The call returns at once.

    Args:
        given: Study, results or gains, in memory or by their path; by default the study quickstart.
        study: Study of gains that lie in no results folder.
        out: Folder that takes what is saved.
        present: Parameter file of what the vehicle flies, for judge and rollback.
        port: Port on 127.0.0.1, 0 for any free one.
        threads: Threads of flights, by default one for each core.

    Returns:
        The page; `.address`, `.stop()`, `.wait()`. It ends with the process.

    Raises:
        InputError: A file is of another kind, a folder is missing, or the port is taken.
        MissingPackageError: The packages of the server are not installed.

    Examples:
        >>> page = tuner.studio("dc_motor")
        >>> page.stop()

    """
    require_server("tuner.studio")
    from tuner.extensions.studio.server import opened_page

    folder, before = Path(out), None if present is None else Path(present)
    check_places(folder, before)
    page, listening = opened_page(_session(given, study), folder.resolve(), before, port, threads, embeds=True)
    print(f"Studio: {page.door.address}", flush=True)
    return RunningStudio(page, listening)


def _session(given: StudyLike | AnyResults | Gains | None, study: StudyLike | None) -> "Session":
    """Return the session of objects in memory, or of paths."""
    from tuner.extensions.studio.session import open_session, session_of_gains, session_of_study

    if isinstance(given, Results):
        if given.folder is None:
            raise InputError("these results have no folder; give the study or the gains", key="given")
        return open_session(given.folder)
    if isinstance(given, Gains):
        with given.file() as file:
            return session_of_gains(file, study)
    if given is None or isinstance(given, str | Path):
        return open_session(None if given is None else Path(given), study)
    return session_of_study(given)
