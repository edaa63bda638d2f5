"""Incremental matching against matching by trial of every belief."""

from hypothesis import given
from hypothesis import strategies as st

from robots.deliberative.beliefs import Belief, BeliefStore, Origin
from robots.deliberative.guards import holds
from robots.deliberative.matching import Key, Matcher
from robots.deliberative.program import Conditions, Guard, Literal, Place
from robots.deliberative.terms import Term, Value, Variable, match, substitute, variables_in

HERE = Place(1, 1)
constants = st.sampled_from(["a", "b", 1.0])
forms = st.sampled_from([("p", 1), ("q", 2), ("r", 2), ("s", 0)])


def terms(arguments: st.SearchStrategy[Value]) -> st.SearchStrategy[Term]:
    def of(form: tuple[str, int]) -> st.SearchStrategy[Term]:
        name, arity = form
        return st.lists(arguments, min_size=arity, max_size=arity).map(lambda args: Term(name, tuple(args)))

    return forms.flatmap(of)


variables = st.sampled_from("xyz").map(Variable)
patterns = terms(st.one_of(constants, variables, variables))
literals = st.builds(Literal, patterns, st.sampled_from([False, False, True]), st.just(HERE))
guards = st.builds(
    Guard, variables, st.sampled_from(["!=", "==", "<"]), st.one_of(constants, variables), st.just(HERE)
)


@st.composite
def rules(draw: st.DrawFn) -> tuple[Conditions, tuple[str, ...]]:
    chosen = tuple(draw(st.lists(literals, min_size=1, max_size=4)))
    bound = {name for one in chosen if not one.negated for name in variables_in(one.term)}
    compared = [
        one
        for one in draw(st.lists(guards, max_size=1))
        if {*variables_in(one.left), *variables_in(one.right)} <= bound
    ]
    kept = tuple(sorted(name for name in bound if draw(st.booleans())))
    return Conditions(chosen, tuple(compared)), kept


def naive(conditions: Conditions, kept: tuple[str, ...], believed: set[Term]) -> set[Key]:
    """The instances that hold, by trying every belief for every condition."""
    ways: list[dict[str, Value]] = [{}]
    for literal in conditions.positive:
        longer = []
        for way in ways:
            for term in believed:
                extended = dict(way)
                if match(literal.term, term, extended):
                    longer.append(extended)
        ways = longer
    refused = [one.term for one in conditions.literals if one.negated]
    return {
        tuple(way[name] for name in kept)
        for way in ways
        if all(holds(guard, way) for guard in conditions.guards)
        and not any(match(substitute(one, way), term, {}) for one in refused for term in believed)
    }


@given(
    st.lists(rules(), min_size=1, max_size=4),
    st.lists(st.tuples(st.booleans(), terms(constants)), max_size=25),
    st.integers(0, 5),
)
def test_incremental_matching_agrees_with_trying_every_belief(
    wanted: list[tuple[Conditions, tuple[str, ...]]], told: list[tuple[bool, Term]], late: int
) -> None:
    store = BeliefStore()
    matcher = Matcher(store)
    known: dict[int, set[Key]] = {number: set() for number in range(len(wanted))}
    believed: set[Term] = set()
    for step, (is_believed, term) in enumerate([*told, (False, Term("s"))]):
        for number, (conditions, kept) in enumerate(wanted):
            if step == (late if number == 0 else 0):
                matcher.add(("rule", number), conditions, kept)
        if is_believed and term not in believed:
            store.adopt(Belief(term=term, origin=Origin.ADOPTED, since_s=0.0))
            matcher.told(term)
            believed.add(term)
        elif not is_believed and store.retract(term):
            matcher.untold(term)
            believed.discard(term)
        for change in matcher.changes():
            number = change.query[1]
            assert (change.key in known[number]) is not change.holds
            (known[number].add if change.holds else known[number].discard)(change.key)
        for number, (conditions, kept) in enumerate(wanted):
            if number or step >= late:
                assert known[number] == naive(conditions, kept, believed)
                assert set(matcher.holding(("rule", number))) == known[number]
