"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.trials"
EXTENSION = Extension(
    name="trials",
    about="Ask and tell: a search whose trials another program or a test bench makes.",
    requires=("step_records",),
    command_module=f"{HOME}.command",
    commands=(
        "ask",
        "tell",
    ),
    api={"ask": f"{HOME}.api:ask", "tell": f"{HOME}.api:tell"},
    studies={"trials": f"{HOME}.kinds:STUDY"},
    experiments={"trials": f"{HOME}.kinds:EXPERIMENT"},
    schemas={"trials-study": f"{HOME}.kinds:study_schema"},
    previews={"trials": f"{HOME}.preview:trials_preview"},
)
