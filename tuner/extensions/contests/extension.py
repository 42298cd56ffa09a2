"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.contests"
EXTENSION = Extension(
    name="contests",
    about="Several controllers or choices, each tuned and compared; claims and printed numbers put to the test.",
    api={"ContestResults": f"{HOME}.results:ContestResults"},
    documents={
        "contest": f"{HOME}.documents:ContestDocument",
        "contest-plan": f"{HOME}.documents:ContestPlanDocument",
    },
    folders=(f"{HOME}.documents:ContestFolder",),
    results={"contest": f"{HOME}.results:ContestResults"},
    printers={
        "ContestResults": f"{HOME}.printer:print_contest",
        "ContestPlanDocument": f"{HOME}.printer:print_contest_plan",
    },
    shows={"contest": f"{HOME}.printer:show_contest"},
    figures={"contest": f"{HOME}.figures:figures_of"},
    studies={"choices": f"{HOME}.kinds:STUDY_WITH_CHOICES", "contest": f"{HOME}.kinds:STUDY"},
    experiments={"contest": f"{HOME}.kinds:EXPERIMENT"},
    schemas={
        "contest-study": f"{HOME}.kinds:contest_study_schema",
        "choices-study": f"{HOME}.kinds:choices_study_schema",
    },
    previews={"contest": f"{HOME}.planning:contest_preview"},
    plans={"contest": f"{HOME}.planning:plan_contest"},
)
