"""`python -m tuner.exchange.processor_cost --write FILE`: count every pair of laws anew and write the table."""

import argparse
import sys
from pathlib import Path

from plant.errors import InputError
from tuner.exchange.processor_cost.measure import write_table


def main() -> int:
    """Write the table; exit code 2 where the toolchain is missing."""
    parser = argparse.ArgumentParser(prog="python -m tuner.exchange.processor_cost", description=__doc__)
    parser.add_argument(
        "--write", type=Path, required=True, help="the file to write, tuner/study/processor_cost/cortex_m4f.json"
    )
    try:
        write_table(parser.parse_args().write, lambda line: print(line, flush=True))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
