"""The commands whose outputs are kept: small runs of every kind, then every command that prints JSON, in one working folder."""

from pathlib import Path
from typing import NamedTuple

STUDIES = Path(__file__).with_name("studies")
"""The study files that lie in the working folder before the first step."""

LOG = Path(__file__).parents[1] / "tuner" / "extensions" / "logs" / "crazyflie" / "log15_70_to_85"
"""The flight log that lies there too."""

PID_GAINS = "contest/contenders/pid/gains.json"


class Step(NamedTuple):
    """A command line. folder: the new results folder that it leaves, whose documents are kept too."""

    name: str
    arguments: tuple[str, ...]
    folder: str | None = None


def step(name: str, line: str, folder: str | None = None) -> Step:
    """Return the step of a command line that prints JSON; {out} in it stands for the folder."""
    return Step(name.replace(" ", "-"), (*line.format(out=folder).split(), "--json"), folder)


LISTINGS = (
    "airframes",
    "firmwares",
    "laws",
    "margins",
    "metrics",
    "references",
    "risks",
    "searches",
    "sources",
    "studies",
    "targets",
    "theorems",
)
EXPORTS = {
    "ardupilot": (PID_GAINS, "--firmware 4.6"), "betaflight": (PID_GAINS, ""), "crazyflie": (PID_GAINS, ""),
    "px4": (PID_GAINS, ""), "ros2": (PID_GAINS, ""), "c99": ("run/gains.json", ""), "matlab": ("run/gains.json", ""),
    "rotorpy": ("run/gains.json", ""), "fmi": ("run/gains.json", ""),
}  # fmt: skip
"""Target -> gains that it carries, and options."""

STEPS = (
    step("check contest", "check contest.toml"),
    step("plan", "plan tuning.toml"),
    step("plan contest", "plan contest.toml"),
    step("run", "run tuning.toml --out {out} --threads 2", "run"),
    # It flies with half the plant step only where the run has compiled the kernel.
    step("check study", "check tuning.toml"),
    step("run infeasible", "run tuning.toml --out {out} --threads 2 --set constraint.1.max=0.001", "infeasible"),
    step("run contest", "run contest.toml --out {out} --threads 2", "contest"),
    step("show", "show run"),
    step("show infeasible", "show infeasible"),
    step("show contest", "show contest"),
    step("verify", "verify run --sample 2 --threads 2"),
    step("verify contest", "verify contest --sample 2 --threads 2"),
    step("compare", f"compare run {PID_GAINS} --out {{out}} --threads 2", "comparison"),
    step("rejudge", "rejudge run --set objective.0.level=0.25 --out {out} --threads 2", "rejudged"),
    step("sensitivity", "sensitivity tuning.toml --samples 8 --out {out} --threads 2", "sensitivity"),
    step("margins", "margins run/gains.json --study tuning.toml --certificates --out {out}", "margins"),
    step("margins law", "margins --law adrc --yaw 30 --speed 2 --wind 3"),
    step("design", "design tuning.toml --out designed.json"),
    step(
        "fit", "fit step.csv --input heater --output temperature --structure first-order,integrating --max-dead-time 2"
    ),
    step("adrc", "adrc adrc.txt --gyro-rate 3205 --gain adrc_wo_yaw=80"),
    step("validate", "validate run/gains.json"),
    step("theory", "theory run/gains.json --study tuning.toml"),
    step("fly", "fly run/gains.json --study tuning.toml --seeds 8 --threads 2"),
    step(
        "tail",
        "tail run tuning.toml --study tuning.toml --event peak.position>0.6 --event failure --to 0.05 --width 5 --most 300 "
        "--out {out} --threads 2",
        "tail",
    ),
    step("check gains", "check run/gains.json --requirements tuning.toml --seeds 8 --threads 2"),
    step("cost", "cost"),
    step("cost gains", "cost run/gains.json"),
    *(step(f"list {what}", f"list {what}") for what in LISTINGS),
    *(
        step(
            f"export {target}", f"export {gains} --to {target} {options} --flights 2 --out {{out}}", f"export/{target}"
        )
        for target, (gains, options) in EXPORTS.items()
    ),
    step("import px4", "import export/px4/gainproof.params --from px4 --airframe f450 --out vehicle.json"),
    step(
        "judge",
        "judge export/px4/gainproof.params --before export/px4/rollback/gainproof.params --airframe f450 --flights 8 "
        "--out {out} --threads 2",
        "judge",
    ),
    step("judge alone", "judge export/betaflight/gainproof.betaflight.txt --flights 8 --threads 2"),
    step(
        "judge read-back",
        "judge export/px4/gainproof.params --read-back export/px4/rollback/gainproof.params",
    ),
    step("approach", "approach designed.json run/gains.json --steps 2 --flights 4"),
    step("new airframe", "new airframe --mass 1.4 --wheelbase 0.45 --propeller 10x4.5 --kv 920 --cells 3"),
    step("compare-logs", f"compare-logs {LOG.name}@70:77 {LOG.name}@78:85 --airframe crazyflie-pybullet"),
    step("identify check", f"identify {LOG.name} --airframe crazyflie-pybullet --check"),
    step("resume", "resume run --threads 2"),
)
SLOW_STEPS = (step("bench", "bench --flights 16 --threads 2"),)
"""Half a minute for a document of nothing but speeds."""
