"""The controller as C99: the laws that the simulator flies, unaltered, for firmware and for other exports to build on."""
