"""Exchange of gains with other programs: exports that hold a controller exactly or refuse with the reason, and imports."""
