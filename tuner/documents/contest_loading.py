"""From contest.json and the files beside it to `Contest`; whatever is missing or wrong becomes a StoreError naming it."""

from pathlib import Path

from plant.errors import StoreError
from tuner.documents.contest import (
    BestRow,
    BestUnder,
    Cell,
    Claim,
    Compared,
    Contender,
    Contest,
    Difference,
    Gain,
    OnBound,
    Quantity,
    Ruling,
)  # fmt: skip
from tuner.documents.files import Node, read_text
from tuner.documents.flown import read_air, read_fans, read_scores, read_traces
from tuner.documents.front_table import read_fronts
from tuner.documents.inference import load_inference
from tuner.documents.results import Estimate


def load_contest(folder: Path) -> Contest:
    """Read a contest folder; StoreError names the file that is missing or damaged.

    contest.json (or comparison.json, which has the same form), environment.json and study.toml must be there; what the other
    files hold is left out where they are not.
    """
    if not folder.is_dir():
        raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
    compared = folder / "comparison.json"
    root = Node.read(compared if compared.exists() else folder / "contest.json")
    _check(root)
    contenders = _contenders(root["contenders"].entries())
    return Contest(
        folder=folder,
        document=root.value,
        environment=Node.read(folder / "environment.json").value,
        study=read_text(folder / "study.toml"),
        compared_on=[_compared(row) for row in root["compared_on"].entries()],
        contenders=contenders,
        quantities=[_quantity(row) for row in root["quantities"].entries()],
        estimates={
            (row["contender"].text(), row["quantity"].text()): estimate(row) for row in root["estimates"].entries()
        },
        differences=[_difference(row) for row in root["differences"].entries()],
        fronts=read_fronts(root, folder / "fronts.csv"),
        best_under=[_best_under(row) for row in root["best_under"].entries()],
        cells=[_cell(row) for row in root["published"].entries()],
        claims=[_claim(row) for row in root["claims"].entries()] if "claims" in root.value else [],
        scores=read_scores(folder / "scores.parquet"),
        fans=read_fans(folder / "responses.parquet"),
        traces=read_traces(folder / "traces.parquet"),
        air=read_air(folder / "wind.parquet"),
        inference=load_inference(folder / "inference.json") if (folder / "inference.json").exists() else None,
    )


def estimate(row: Node, middle: str = "value", low: str = "low", high: str = "high") -> Estimate:
    """Return a number with its interval; a missing or null number is None."""
    return Estimate(*[None if row.get(name) is None else row[name].number() for name in (middle, low, high)])


def _check(root: Node) -> None:
    """Touch every key that the report reads from the bare document, so that a missing one is named here."""
    root["title"].text()
    for key in ("seed", "flights", "wall_seconds"):
        root[key].number()
    for key in ("words", "warnings"):
        for entry in root[key].entries():
            entry.text()


def _compared(row: Node) -> Compared:
    return Compared(row["scenario"].text(), int(row["flights"].number()), row["duration"].number())


def _contenders(rows: list[Node]) -> list[Contender]:
    return [_contender(i, row) for i, row in enumerate(rows)]


def _laws(row: Node) -> dict[str, str]:
    return {loop: row["laws"][loop].text() for loop in ("position", "attitude")}


def _contender(index: int, row: Node) -> Contender:
    return Contender(
        index=index,
        name=row["name"].text(),
        slug=row["slug"].text(),
        laws=_laws(row),
        airframe=row["airframe"].text(),
        tuned=bool(row["tuned"].value),
        folder=str(row.get("folder") or ""),
        point=str(row.get("point") or ""),
        gains=[Gain(name, gain["value"].number(), gain["unit"].text()) for name, gain in row["gains"].items()],
        searched=[entry.text() for entry in row["searched"].entries()] if "searched" in row.value else [],
        operations=row["cost"]["operations"].number(),
        on_bounds=[_on_bound(entry) for entry in row["on_bounds"].entries()],
        failures=row["failures"].number(),
        instructions=row["cost"]["processor"]["instructions_step"].number() if row["cost"].get("processor") else None,
    )


def _on_bound(row: Node) -> OnBound:
    return OnBound(
        row["variable"].text(), row["end"].text(), row["bound"].number(), bool(row["recommended"].value),
        row["share"].number(), bool(row["natural"].value),
    )  # fmt: skip


def _quantity(row: Node) -> Quantity:
    unit = row["unit"].text()
    return Quantity(
        label=row["label"].text(),
        metric=row["metric"].text(),
        unit="" if unit == "1" else unit,
        risk=str(row.get("risk_definition") or row["risk"].text()),
        scenario=None if row.get("scenario") is None else row["scenario"].text(),
        definition=row["definition"].text(),
        limit=None if row.get("limit") is None else row["limit"].number(),
        kind=str(row.get("kind") or "objective"),
    )


def _difference(row: Node) -> Difference:
    first, second, quantity = (row[key].text() for key in ("first", "second", "quantity"))
    return Difference(first, second, quantity, estimate(row, "difference"), row.get("lower"))


def _best_under(row: Node) -> BestUnder:
    rows = {entry["contender"].text(): _best_row(entry) for entry in row["rows"].entries()}
    return BestUnder(row["objective"].text(), row["subject_to"].text(), row["limit"].number(), rows)


def _best_row(row: Node) -> BestRow | None:
    return None if row.get("point") is None else BestRow(estimate(row), row["point"].text())


def _cell(row: Node) -> Cell:
    unit = row["unit"].text()
    return Cell(
        contender=row["contender"].text(),
        metric=row["metric"].text(),
        scenario=row["scenario"].text(),
        unit="" if unit == "1" else unit,
        printed=row["value"].number(),
        source=str(row.get("source") or ""),
        mean=row["mean"].number(),
        central=estimate(row, "median", "p2_5", "p97_5"),
        percentile=row["percentile"].number(),
        inside=bool(row["inside"].value),
        fitted=bool(row.get("fitted")),
    )


def _claim(row: Node) -> Claim:
    rows = [
        Ruling(entry["than"].text(), entry["quantity"].text(), estimate(entry, "difference"), entry["verdict"].text())
        for entry in row["rows"].entries()
    ]
    return Claim(row["text"].text(), row["better"].text(), row["verdict"].text(), rows)
