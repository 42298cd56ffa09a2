"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="cluster",
    about="Flights on the workers of a Dask cluster, with the bits of this machine.",
    clusters={"dask": "tuner.extensions.cluster.connect:engine_at"},
)
