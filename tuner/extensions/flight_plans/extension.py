"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.flight_plans"
EXTENSION = Extension(
    name="flight_plans",
    about="The flight that identifies a vehicle's parameters to wanted intervals.",
    requires=(
        "ardupilot",
        "autopilots",
        "betaflight",
        "identification",
        "logs",
        "vehicle_fit",
    ),
    api={"plan_flight": f"{HOME}.api:plan_flight"},
    documents={"flight-plan": f"{HOME}.document:FlightPlanDocument"},
    printers={"FlightPlan": f"{HOME}.printer:print_flight_plan"},
    figures={"flight plan": f"{HOME}.page:figures_of"},
)
