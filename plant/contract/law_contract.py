"""The contract of a control law: what every law keeps, bundled or of the user's own.

Clauses run in groups: what a later group asks makes sense only where the earlier ones are kept.
"""

from collections.abc import Callable, Iterator

from plant.contract import law_behaviour as behaviour
from plant.contract import law_description as description
from plant.contract.violation import ContractViolation, violations_of
from plant.laws.law import Law

Clause = Callable[[Law], Iterator[ContractViolation]]


def code_can_be_made_of_it(law: Law) -> Iterator[ContractViolation]:
    """See `law_backends`, which imports the compilers."""
    from plant.contract.law_backends import code_can_be_made_of_it

    return code_can_be_made_of_it(law)


def backends_agree(law: Law) -> Iterator[ContractViolation]:
    """See `law_backends`, which imports the compilers."""
    from plant.contract.law_backends import backends_agree

    return backends_agree(law)


SHAPE: tuple[Clause, ...] = (
    description.parts_are_there,
    description.words_are_there,
    description.every_gain_is_described,
)
WORKS: tuple[Clause, ...] = (
    description.ranges_hold_their_defaults,
    description.what_proofs_ask_for_agrees,
    behaviour.results_are_finite_records,
    code_can_be_made_of_it,
)
FLIES: tuple[Clause, ...] = (
    behaviour.same_inputs_give_the_same,
    behaviour.at_rest_nothing_changes,
    behaviour.commands_point_the_right_way,
    behaviour.only_the_error_counts,
    behaviour.commands_scale_with_the_channel,
    behaviour.corners_stay_finite,
    behaviour.references_are_flown_as_promised,
    behaviour.disturbances_are_rejected_as_promised,
    behaviour.saturation_is_listened_to,
    behaviour.amplitude_counts_only_as_told,
    behaviour.nonlinearities_are_odd,
    behaviour.limits_take_away_from_large_signals_alone,
    behaviour.the_continuous_observer_is_the_limit,
)
AGREES: tuple[Clause, ...] = (backends_agree,)
CLAUSES: tuple[Clause, ...] = (*SHAPE, *WORKS, *FLIES, *AGREES)


def check_law(law: Law, file: str) -> Law:
    """Return a law that can be flown; raises InputError with the place of the first thing that stands against it."""
    for clauses in (SHAPE, WORKS):
        for clause in clauses:
            for violation in violations_of(lambda clause=clause: clause(law), law, file):
                raise violation.error
    return law


def violations_of_law(law: Law, file: str) -> list[ContractViolation]:
    """Return the violations of a law, up to the first group that has one."""
    for clauses in (SHAPE, WORKS, FLIES, AGREES):
        violations = [
            violation for clause in clauses for violation in violations_of(lambda clause=clause: clause(law), law, file)
        ]
        if violations:
            return violations
    return []
