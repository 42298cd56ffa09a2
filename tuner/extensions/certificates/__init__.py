"""Certificates: numbers proved about one axis of a controller by matrix inequalities, without flying."""
