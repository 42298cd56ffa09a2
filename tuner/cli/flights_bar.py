"""A progress display for commands that fly once: `tuner sensitivity`, `tuner plan` and `tuner check`."""

from tuner.cli.display import TerminalWatcher


class FlightsBar(TerminalWatcher):
    """Shows the compilation and one bar of flights."""

    def __enter__(self) -> "FlightsBar":
        super().__enter__()
        return self

    def flying(self, what: str, flights: int) -> None:
        """Start the bar; what: a participle, for instance "Sampling"."""
        self._begin_task(what, flights)
