"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.judge"
EXTENSION = Extension(
    name="judge",
    about="A second opinion on gains before arming, and parameters read back from a vehicle.",
    requires=(
        "autopilots",
        "parts_list",
    ),
    command_module=f"{HOME}.command",
    commands=("judge",),
    api={"judge": f"{HOME}.api:judge", "read_back": f"{HOME}.api:read_back"},
    documents={"read-back": f"{HOME}.document:ReadBackDocument"},
    printers={
        "Assessment": f"{HOME}.printer:print_assessment",
        "ReadBackComparison": f"{HOME}.printer:print_read_back",
    },
    opinions={"judge": f"{HOME}.present:judge_against_present"},
)
