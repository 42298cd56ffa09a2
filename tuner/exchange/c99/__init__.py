"""The controller as C99: the laws that the simulator flies, unaltered, for firmware and for other exports to build on."""

from tuner.exchange.c99.sources import CSources, c_sources

__all__ = ["CSources", "c_sources"]
