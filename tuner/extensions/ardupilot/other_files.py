"""Parameters of ArduPilot in its flight logs (DataFlash, `.bin`): the messages PARM."""

from plant.input_files import ReadableFile, given_content
from tuner.extensions.ardupilot.text import WHAT
from tuner.extensions.autopilots.parameters import positional
from tuner.extensions.autopilots.resolution import MAX_LOG_BYTES, Resolved, log_notes, plain_file
from tuner.extensions.logs.dataflash import is_dataflash
from tuner.extensions.logs.logged_parameters import dataflash_parameters


def plain(file: ReadableFile) -> ReadableFile:
    """Return a file of parameters in the lines of Mission Planner."""
    return plain_file(file, resolved(file))


def resolved(file: ReadableFile) -> Resolved | None:
    """Return the parameters of a log; None for any other file."""
    content = given_content(file, f"give {WHAT}", MAX_LOG_BYTES)
    if not is_dataflash(content):
        return None
    log = dataflash_parameters(content, str(file))
    # A banner, by which a version and another vehicle than a Copter are recognized.
    head = [f"# {log.firmware} V{log.version}"] if log.version else []
    rows = [f"{name},{positional(value)}" for name, value in log.values.items()]
    return Resolved("\n".join([*head, *rows]) + "\n", log_notes(log))
