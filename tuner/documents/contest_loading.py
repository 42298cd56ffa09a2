"""From contest.json and the files beside it to `Contest`; whatever is missing or wrong becomes a StoreError naming it."""

from pathlib import Path

from plant.errors import StoreError
from tuner.documents.contest import (
    Gain,
    ShownBest,
    ShownBestUnder,
    ShownCell,
    ShownClaim,
    ShownContender,
    ShownContest,
    ShownDifference,
    ShownQuantity,
    ShownRuling,
)  # fmt: skip
from tuner.documents.contest_document import (
    BestRow,
    BestUnder,
    ClaimRow,
    ComparisonDocument,
    ContenderRow,
    ContestDocument,
    DifferenceRow,
    PublishedRow,
    QuantityRow,
    RulingRow,
)
from tuner.documents.flown import read_air, read_fans, read_scores, read_traces
from tuner.documents.front_table import read_fronts
from tuner.documents.inference import load_inference
from tuner.store.document import read_text
from tuner.store.environment import Environment


def load_contest(folder: Path) -> ShownContest:
    """Read a contest folder; StoreError names the file that is missing or damaged.

    contest.json (or comparison.json, which has the same form), environment.json and study.toml must be there; what the other
    files hold is left out where they are not.
    """
    if not folder.is_dir():
        raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
    document = contest_document_of(folder)
    return ShownContest(
        folder=folder,
        document=document,
        environment=Environment.read(folder / "environment.json"),
        study=read_text(folder / "study.toml"),
        compared_on=document.compared_on,
        contenders=_contenders(document.contenders),
        quantities=[_quantity(row) for row in document.quantities],
        estimates={(row.contender, row.quantity): row.estimate for row in document.estimates},
        differences=[_difference(row) for row in document.differences],
        fronts=read_fronts(document.fronts, folder / "fronts.csv"),
        best_under=[_best_under(row) for row in document.best_under],
        cells=[_cell(row) for row in document.published],
        claims=[_claim(row) for row in document.claims],
        scores=read_scores(folder / "scores.parquet"),
        fans=read_fans(folder / "responses.parquet"),
        traces=read_traces(folder / "traces.parquet"),
        air=read_air(folder / "wind.parquet"),
        inference=load_inference(folder / "inference.json") if (folder / "inference.json").exists() else None,
    )


def contest_document_of(folder: Path) -> ContestDocument | ComparisonDocument:
    """Read what a contest or a comparison found."""
    compared = folder / "comparison.json"
    return ComparisonDocument.read(compared) if compared.exists() else ContestDocument.read(folder / "contest.json")


def _contenders(rows: list[ContenderRow]) -> list[ShownContender]:
    return [_contender(i, row) for i, row in enumerate(rows)]


def _contender(index: int, row: ContenderRow) -> ShownContender:
    return ShownContender(
        index=index,
        name=row.name,
        slug=row.slug,
        laws=row.laws.content(),
        airframe=row.airframe,
        tuned=row.tuned,
        folder=row.folder or "",
        point=row.point,
        gains=[Gain(name, gain.value, gain.unit) for name, gain in row.gains.items()],
        searched=row.searched,
        operations=row.cost.operations,
        on_bounds=row.on_bounds,
        failures=row.failures,
        instructions=None if row.cost.processor is None else row.cost.processor.instructions_step,
    )


def _quantity(row: QuantityRow) -> ShownQuantity:
    return ShownQuantity(
        label=row.label,
        metric=row.metric,
        unit=_shown(row.unit),
        risk=row.risk_definition or row.risk,
        scenario=row.scenario,
        definition=row.definition,
        limit=row.limit,
        kind=row.kind,
    )


def _difference(row: DifferenceRow) -> ShownDifference:
    return ShownDifference(row.first, row.second, row.quantity, row.estimate, row.lower)


def _best_under(row: BestUnder) -> ShownBestUnder:
    return ShownBestUnder(
        row.objective, row.subject_to, row.limit, {entry.contender: _best_row(entry) for entry in row.rows}
    )  # fmt: skip


def _best_row(row: BestRow) -> ShownBest | None:
    return None if row.point is None else ShownBest(row.estimate, row.point)


def _cell(row: PublishedRow) -> ShownCell:
    return ShownCell(
        contender=row.contender,
        metric=row.metric,
        scenario=row.scenario,
        unit=_shown(row.unit),
        printed=row.printed,
        source=row.source,
        mean=row.mean,
        central=row.central,
        percentile=row.percentile,
        inside=row.inside,
        fitted=row.fitted,
    )


def _claim(row: ClaimRow) -> ShownClaim:
    return ShownClaim(row.text, row.better, row.verdict, [_ruling(entry) for entry in row.rows])


def _ruling(row: RulingRow) -> ShownRuling:
    return ShownRuling(row.than, row.quantity, row.estimate, row.verdict)


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit
