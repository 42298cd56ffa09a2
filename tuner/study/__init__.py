"""Study files, read and checked."""
