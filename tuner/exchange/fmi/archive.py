"""A zip archive that is the same bytes for the same content: no dates, no owners, names in order."""

import io
import zipfile
from collections.abc import Mapping

# The earliest date that a zip archive can hold.
DATE = (1980, 1, 1, 0, 0, 0)
REGULAR_FILE = 0o100644


def archive(files: Mapping[str, bytes]) -> bytes:
    """Return the archive of files: name -> content."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as target:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = REGULAR_FILE << 16
            target.writestr(entry, files[name])
    return held.getvalue()
