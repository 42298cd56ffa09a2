"""Accumulators that see one command, run for every input of a loop: as one accumulator of the whole flight."""

from collections.abc import Mapping

from objectives.metrics.metric import Accumulator
from plant.model.functions import written
from plant.records import record_type

ROTORS: Mapping[str, float] = {"r1": 1.0, "r2": 1.0, "r3": 1.0, "r4": 1.0}
"""Scales of a quadrotor's commands, which are counted in hover thrusts already."""


def over_inputs(accumulator: Accumulator, scales: Mapping[str, float]) -> Accumulator:
    """Return an accumulator of the flight with a record for each input; itself if it is no input's.

    scales: what the command of each input is counted in, in the input's unit.
    """
    if not accumulator.each_input:
        return accumulator
    Inputs = record_type("Inputs", dict.fromkeys(scales, accumulator.Record))
    names = {"Inputs": Inputs, "start_one": accumulator.start, "update_one": accumulator.update}
    commands = {name: f"{1.0 / scale!r} * sample.command.{name}" for name, scale in scales.items()}
    started = ", ".join(f"start_one({command})" for command in commands.values())
    updated = ", ".join(f"update_one(kept.{name}, {command}, h)" for name, command in commands.items())
    start = ["def start(sample, targets):", f"    return Inputs({started})"]
    update = ["def update(kept, sample, targets, h):", f"    return Inputs({updated})"]
    return Accumulator(Inputs, written("start", start, names), written("update", update, names))
