"""The preview of a study whose trials another program runs."""

from tuner.experiments.planning.counts import flights_of
from tuner.experiments.planning.study_preview import PreviewPart
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.extensions.trials.study import TrialStudy


class TrialsPreview(PreviewPart):
    """A study whose trials another program makes; the numbers of trials are the most that may be asked for."""

    variables: list[str]
    metrics: list[str]
    objectives: list[str]
    constraints: list[str]
    search_trials_at_most: int
    trials_at_most: int
    search: str
    digest: str
    warnings: list[str]


def trials_preview(study: TrialStudy) -> TrialsPreview:
    """Return the preview of a study whose trials another program runs."""
    flights = flights_of(study)
    return TrialsPreview(
        kind="trials",
        title=study.title,
        variables=study.names,
        metrics=[f"{metric.text} [{metric.unit}]" for metric in study.metrics],
        objectives=[objective.label for objective in study.objectives],
        constraints=[f"{entry.objective.label} at most {entry.most:g}" for entry in study.constraints],
        search_trials_at_most=flights.search_at_most,
        trials_at_most=flights.total_at_most,
        search=" ".join([study.search.text, *study.start_texts]),
        digest=study.digest(),
        warnings=warnings_before_run(study),
    )
