"""The [gains] table: gains that are searched, tied or fixed; the rest have their defaults."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from objectives.decisions import DecisionSpace, Variable
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.cascade import Cascade
from plant.quadrotor.gains import GROUPS, GainAddress, gain_addresses
from tuner.gains.ranges import check_value
from tuner.study.schema import GainTable

Entry = float | GainTable


@dataclass(frozen=True)
class KeyedGains:
    """A key of the table and the gains that it speaks for; a more specific key takes gains from a wider one."""

    key: str
    entry: Entry
    gains: tuple[GainAddress, ...]


def decision_space(
    table: Mapping[str, Entry], cascade: Cascade, control_period: float, default: Sequence[float] | None = None
) -> DecisionSpace:
    """Return the decision space of a [gains] table; raises InputError with the key inside the table.

    default: gains row that stands where the table says nothing, by default that of the laws. Facts of the airframe among
    the gains can be fixed at another value, but not searched.
    """
    every_gain = gain_addresses(cascade)
    claims = [claim for claim in _settled(_claims(table, every_gain)) if claim.gains]
    base = [gain.default for gain in every_gain] if default is None else list(default)
    owners: dict[str, KeyedGains] = {claim.key: claim for claim in claims}
    tied: dict[str, list[GainAddress]] = {}
    for claim in claims:
        if isinstance(claim.entry, GainTable):
            if claim.entry.tie is not None:
                owner = _owner(claim, owners)
                tied.setdefault(owner.key, []).extend(claim.gains)
        else:
            for gain in claim.gains:
                check_value(claim.key, gain, float(claim.entry), control_period)
                base[gain.column] = float(claim.entry)
    variables, columns = [], []
    for claim in claims:
        if isinstance(claim.entry, GainTable) and claim.entry.tie is None:
            gains = (*claim.gains, *tied.get(claim.key, []))
            variables.append(_variable(claim, gains, control_period))
            columns.append(tuple(gain.column for gain in gains))
    searched = {column for group in columns for column in group}
    for gain in every_gain:
        if gain.column not in searched:
            check_value(gain.address, gain, base[gain.column], control_period, "the default is")
    space = DecisionSpace(tuple(variables), tuple(columns), tuple(base))
    _check_shared(cascade, every_gain, space, claims)
    return space


def _check_shared(
    cascade: Cascade, every_gain: tuple[GainAddress, ...], space: DecisionSpace, claims: Sequence[KeyedGains]
) -> None:
    """Refuse gains that differ between axes which have one number between them."""
    columns = {gain.address: gain.column for gain in every_gain}
    owner = {column: i for i, group in enumerate(space.columns) for column in group}
    for law in (cascade.position, cascade.attitude):
        for name, axes in law.shared.items():
            addresses = [f"{axis}.{name}" for axis in axes if f"{axis}.{name}" in columns]
            kinds = {(owner.get(columns[address]), _fixed(space, owner, columns[address])) for address in addresses}
            if len(kinds) > 1:
                key = next(c.key for c in reversed(claims) if {gain.address for gain in c.gains} & set(addresses))
                group = next(group for group, members in GROUPS.items() if set(members) == set(axes))
                raise InputError(
                    f'{law.title} has one {name} for {", ".join(axes)}; search or fix it for all of them: "{group}.{name}"',
                    key=key,
                )


def _fixed(space: DecisionSpace, owner: Mapping[int, int], column: int) -> float | None:
    return None if column in owner else space.base[column]


def _claims(table: Mapping[str, Entry], every_gain: tuple[GainAddress, ...]) -> list[KeyedGains]:
    claims = []
    for key, entry in table.items():
        group, _, name = key.partition(".")
        if group not in GROUPS:
            raise UnknownNameError("axis or group", group, GROUPS, key=key)
        gains = tuple(gain for gain in every_gain if gain.address in {f"{axis}.{name}" for axis in GROUPS[group]})
        if not gains:
            valid = {gain.address.split(".")[1] for gain in every_gain if gain.axis in GROUPS[group]}
            raise UnknownNameError("gain", name, valid, key=key)
        claims.append(KeyedGains(key, entry, gains))
    return claims


def _settled(claims: list[KeyedGains]) -> list[KeyedGains]:
    """Take from each claim the gains that a narrower one claims; two claims of one width on a gain are an error."""
    settled = []
    for claim in claims:
        others = [other for other in claims if other is not claim]
        for other in others:
            shared = {gain.address for gain in other.gains} & {gain.address for gain in claim.gains}
            if shared and len(other.gains) == len(claim.gains):
                raise InputError(f"'{sorted(shared)[0]}' is given by '{other.key}' too; leave one out", key=claim.key)
        narrower = {g.address for o in others if len(o.gains) < len(claim.gains) for g in o.gains}
        settled.append(KeyedGains(claim.key, claim.entry, tuple(g for g in claim.gains if g.address not in narrower)))
    return settled


def _owner(claim: KeyedGains, owners: Mapping[str, KeyedGains]) -> KeyedGains:
    """Follow a tie to the searched entry at its end."""
    seen, current = [claim.key], claim
    while isinstance(current.entry, GainTable) and current.entry.tie is not None:
        if {current.entry.low, current.entry.high, current.entry.scale} != {None}:
            raise InputError("a tie has no range of its own; leave low, high and scale out", key=current.key)
        current = _target(current.entry.tie, claim.key, owners)
        if current.key in seen:
            raise InputError(f"the ties go in a circle: {' -> '.join([*seen, current.key])}", key=claim.key)
        seen.append(current.key)
    if not isinstance(current.entry, GainTable):
        raise InputError(
            f"'{current.key}' is fixed, not searched; write {claim.key} = {current.entry} instead", key=claim.key
        )
    return current


def _target(name: str, key: str, owners: Mapping[str, KeyedGains]) -> KeyedGains:
    """Return the entry of [gains] with a key, or with a gain's address."""
    if name in owners:
        return owners[name]
    for owner in owners.values():
        if name in {gain.address for gain in owner.gains}:
            return owner
    raise UnknownNameError("entry of [gains] to tie to", name, [other for other in owners if other != key], key=key)


def _variable(claim: KeyedGains, gains: tuple[GainAddress, ...], control_period: float) -> Variable:
    entry, first = claim.entry, gains[0]
    assert isinstance(entry, GainTable)
    usual = first.span
    low, low_origin = (usual.low, "the usual range begins at") if entry.low is None else (entry.low, "given")
    high, high_origin = (usual.high, "the usual range ends at") if entry.high is None else (entry.high, "given")
    scale = first.info.scale if entry.scale is None else entry.scale
    steps = {gain.info.resolution for gain in gains}
    variable = Variable(claim.key, tuple(gain.address for gain in gains), low, high, scale, max(steps))
    for gain in gains:
        if gain.info.airframe or gain.info.firmware:
            fact = "airframe" if gain.info.airframe else "firmware, which no parameter changes"
            message = (
                f"'{gain.address}' is a fact of the {fact} ({gain.info.meaning}); leave it out, or give one number"
            )
            raise InputError(message, key=claim.key)
        check_value(claim.key, gain, low, control_period, low_origin)
        check_value(claim.key, gain, high, control_period, high_origin)
    return variable
