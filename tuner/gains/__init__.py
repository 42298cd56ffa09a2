"""gains.json: a tuned controller that explains itself, with every number's unit, its airframe and where it came from.

Version 1.2 of the format "gainproof-gains"; `tuner schema gains` prints its JSON Schema. A minor version adds keys, a major one
breaks readers. Units are UCUM codes, hashes are taken over the canonical form of RFC 8785.
"""

from tuner.gains.controller import Controller, TunedLoops, VehicleRecord
from tuner.gains.document import plant_gains_document, to_document
from tuner.gains.hashing import content_hash
from tuner.gains.reading import content_sha256, read_gains, read_loops
from tuner.gains.sections import FORMAT, VERSION

__all__ = [
    "FORMAT",
    "VERSION",
    "Controller",
    "TunedLoops",
    "VehicleRecord",
    "content_hash",
    "content_sha256",
    "plant_gains_document",
    "read_gains",
    "read_loops",
    "to_document",
]
