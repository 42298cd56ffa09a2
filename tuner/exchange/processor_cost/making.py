"""Making the packaged table of costs, after a change of a law, of the cascade or of the C99 export:

python -m tuner.exchange.processor_cost --write tuner/study/processor_cost/cortex_m4f.json
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from plant.airframes import load
from plant.cascade import close_cascade
from plant.gains import default_row
from plant.laws import LAWS, law
from plant.nominal import ControlOptions
from tuner.exchange.processor_cost.measure import measure_cost
from tuner.gains import Controller
from tuner.study.processor_cost.cost import MEANING, Cost
from tuner.study.processor_cost.table import CONTROL_PERIOD, COUNTED, SHARED

AIRFRAME, PLANT_STEP = "hummingbird", 0.001


def default_controller(position: str, attitude: str) -> Controller:
    """Return the default gains of a pair of laws; raises UnknownNameError."""
    cascade = close_cascade(law(position), law(attitude))
    return Controller(
        load(AIRFRAME), cascade, ControlOptions(), CONTROL_PERIOD, PLANT_STEP, tuple(default_row(cascade))
    )


def measured_table(said: Callable[[str], None]) -> str:
    """Count every pair of laws and return the table as text; said(line) hears of each."""
    costs: dict[str, dict[str, Cost]] = {}
    for position in LAWS:
        for attitude in LAWS:
            cost = measure_cost(default_controller(position, attitude))
            costs.setdefault(position, {})[attitude] = cost
            said(f"{position} / {attitude}: {cost.instructions_step} instructions")
    return table_text(costs)


def table_text(costs: dict[str, dict[str, Cost]]) -> str:
    """Return a table as JSON with a line for each pair."""
    first = next(iter(next(iter(costs.values())).values())).as_dict()
    head: dict[str, Any] = {"meaning": MEANING, **{key: first[key] for key in SHARED}}
    head |= {"airframe": AIRFRAME, "control_period_s": CONTROL_PERIOD, "columns": list(COUNTED)}
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    blocks = [
        f"    {json.dumps(position)}: {{\n" + ",\n".join(_line(name, cost) for name, cost in rows.items()) + "\n    }"
        for position, rows in costs.items()
    ]
    return "{\n" + "\n".join(lines) + '\n  "costs": {\n' + ",\n".join(blocks) + "\n  }\n}\n"


def _line(name: str, cost: Cost) -> str:
    values = cost.as_dict()
    return f"      {json.dumps(name)}: {json.dumps([values[key] for key in COUNTED])}"


def write_table(path: Path, said: Callable[[str], None]) -> None:
    """Count every pair of laws and write the table."""
    path.write_text(measured_table(said), encoding="utf-8")
