"""Parameter files read back, for the tests of importers."""

from plant.quadrotor.airframes import load
from tuner.exchange.registry import importer, settings_of
from tuner.exchange.target import Request

DIGEST = "12" * 32


def write(folder, content, name="vehicle.txt"):
    file = folder / name
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return file


def read(source, file, *settings, airframe="hummingbird"):
    """What an importer makes of a file."""
    chosen = importer(source)
    frame = load(airframe, allow_unphysical=True) if isinstance(airframe, str) else airframe
    return chosen.read(file, frame, settings_of(chosen, settings))


def exported(exporter, given, *settings):
    return exporter.export(Request(given, DIGEST, settings_of(exporter, settings)))


def same_flight(one, other):
    """Gains, tilt and laws; periods are options of an import."""
    return (one.gains, one.options, one.cascade.position.name, one.cascade.attitude.name, one.airframe.name) == (
        other.gains,
        other.options,
        other.cascade.position.name,
        other.cascade.attitude.name,
        other.airframe.name,
    )
