"""The unified-planning features that plan-net actions can express, and workarounds for the others."""

from typing import Any

from planner.errors import Unsupported

SUPPORTED = (
    "ACTION_BASED CONTINUOUS_TIME DISCRETE_TIME STATIC_FLUENTS_IN_DURATIONS INT_TYPE_DURATIONS REAL_TYPE_DURATIONS"
    " DURATION_INEQUALITIES SELF_OVERLAPPING NEGATIVE_CONDITIONS EQUALITIES FLAT_TYPING HIERARCHICAL_TYPING"
    " INT_FLUENTS REAL_FLUENTS NUMERIC_FLUENTS CONTINUOUS_NUMBERS DISCRETE_NUMBERS ACTIONS_COST MAKESPAN PLAN_LENGTH"
    " STATIC_FLUENTS_IN_ACTIONS_COST INT_NUMBERS_IN_ACTIONS_COST REAL_NUMBERS_IN_ACTIONS_COST"
    " UNDEFINED_INITIAL_NUMERIC"
)

_REMOVABLE = {
    "DISJUNCTIVE_CONDITIONS": "DISJUNCTIVE_CONDITIONS_REMOVING",
    "EXISTENTIAL_CONDITIONS": "QUANTIFIERS_REMOVING",
    "UNIVERSAL_CONDITIONS": "QUANTIFIERS_REMOVING",
    "FORALL_EFFECTS": "QUANTIFIERS_REMOVING",
    "CONDITIONAL_EFFECTS": "CONDITIONAL_EFFECTS_REMOVING",
    "OBJECT_FLUENTS": "USERTYPE_FLUENTS_REMOVING",
    "TRAJECTORY_CONSTRAINTS": "TRAJECTORY_CONSTRAINTS_REMOVING",
    "STATE_INVARIANTS": "STATE_INVARIANTS_REMOVING",
}


def supported_features() -> frozenset[str]:
    """The names of the features that can be read."""
    return frozenset(SUPPORTED.split())


def workaround(feature: str) -> str:
    """What can be done about a feature that cannot be read."""
    if feature in _REMOVABLE:
        return f"unified-planning's compiler {_REMOVABLE[feature]} removes it"
    if "NUMERIC" in feature or "INCREASE" in feature or "DECREASE" in feature:
        return "numbers may only be static functions in durations and costs"
    return "plan-net actions have conditions and effects that are literals, and a duration"


def unsupported_feature(feature: str, where: str) -> Unsupported:
    """The error for a feature, to be raised."""
    words = feature.lower().replace("_", " ")
    return Unsupported(f"{where}: {words} cannot be planned with; {workaround(feature)}")


def check_problem_features(up_problem: Any) -> None:
    """Refuse unsupported features of the problem as a whole.

    :raises Unsupported: naming the first feature that does not fit.
    """
    kind = up_problem.kind
    for feature in sorted(kind.features - supported_features()):
        raise unsupported_feature(feature, f"problem {up_problem.name or 'without a name'}")
