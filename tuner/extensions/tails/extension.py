"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.tails"
EXTENSION = Extension(
    name="tails",
    about="Small probabilities: of rare events of a flight, and limits of a study on them.",
    requires=("cluster", "step_records"),
    command_module=f"{HOME}.command",
    commands=("tail",),
    api={"tail": f"{HOME}.api:tail"},
    documents={"tail": f"{HOME}.document:TailDocument"},
    printers={"Tail": f"{HOME}.printer:print_tail"},
    figures={"tail": f"{HOME}.figure:figures_of"},
    panels={"tail": f"{HOME}.panels:limited_panels"},
    loss_sections={"tail": f"{HOME}.section:tail_section"},
    flights={"tail": f"{HOME}.record:point_setup"},
    finalists={"tails": f"{HOME}.finalists:ESTIMATOR"},
)
