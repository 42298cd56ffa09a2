"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.log_comparison"
EXTENSION = Extension(
    name="log_comparison",
    about="Two flight logs side by side: ratios with intervals, and the prediction of the second.",
    requires=(
        "identification",
        "logs",
        "vehicle_fit",
    ),
    command_module=f"{HOME}.command",
    commands=("compare-logs",),
    api={"compare_logs": f"{HOME}.api:compare_logs"},
    documents={"log-comparison": f"{HOME}.document:LogComparisonDocument"},
    printers={"LogComparison": f"{HOME}.printer:print_log_comparison"},
)
