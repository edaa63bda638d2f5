"""Why a problem has no plan, in an operator's words.

For each goal out of reach: a smallest set of facts that, if they held, would bring it within reach of the
delete relaxation. It is found by supposing plausible facts, as few as can be: any static fact that fits its types (an
ability, a reach), and fluents of a shape that present facts have, unless they contradict a present one.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from math import prod

from planner.fact import Fact
from planner.knowledge import KnowledgeBase, number_words
from planner.knowledge.phrases import clause, denial, enumeration, naturally_sorted, nothing, phrase
from planner.problem.contradiction import contradicting_goals
from planner.problem.interface import PlanningProblem
from planner.problem.static_facts import StaticFacts
from planner.relaxation import Relaxation
from planner.relaxation.reachability import members_of
from planner.relaxation.rules import FUNCTION, argument_types

MAX_OBJECTS = 60
"""With more objects, those unrelated to the goals are ignored."""
MAX_SUPPOSED = 40_000
MAX_REASONS = 6


def why_unsolvable(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> str:
    """What stands in each goal's way, else which goals contradict each other, else that no plan exists."""
    reasons = list(dict.fromkeys(_Diagnosis(knowledge_base, problem).reasons()))
    reasons = reasons or [
        f"{phrase(knowledge_base, one)} or {phrase(knowledge_base, other)}, not both"
        for one, other in contradicting_goals(knowledge_base, problem)
    ]
    if len(reasons) > MAX_REASONS:
        reasons[MAX_REASONS:] = [f"and {len(reasons) - MAX_REASONS} more reasons like these"]
    if not reasons and len(problem.goals) > 1:
        return "no plan exists from the present facts for all goals together"
    return "; ".join(reasons) or "no plan exists from the present facts"


class _Diagnosis:
    """One problem's diagnosis."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self._base = knowledge_base
        self._problem = problem
        self._members = members_of(knowledge_base, problem.objects)

    def reasons(self) -> Iterator[str]:
        """A sentence or more for each goal that is out of reach."""
        present = Relaxation(
            self._base, self._problem, observed={goal.predicate for goal in self._problem.goals}
        )
        present.run()
        goals = [goal for goal in dict.fromkeys(self._problem.goals) if present.missing(goal) is None]
        hopeless = [goal for goal in goals if not self._is_intended(goal)]
        for goal in hopeless:
            by_the_way = ", it only comes about as a side effect" if present.holds(goal) else ""
            yield f"no action has the intended effect {goal.predicate}{by_the_way}"
        goals = [goal for goal in goals if goal not in hopeless]
        if goals:
            problem = self._small(goals)
            supposed = self._supposing(problem, self._plausible(problem), with_functions=False)
            if any(supposed.missing(goal) is None for goal in goals):
                bold = self._plausible(problem, strict=False)
                supposed = self._supposing(problem, bold, with_functions=False)
            for goal in goals:
                yield from self._reasons_for(goal, problem, supposed, present)

    def _is_intended(self, goal: Fact) -> bool:
        return any(
            effect.predicate == goal.predicate
            for op in self._base.operators
            for effect in op.intended_effects
        )

    def _small(self, goals: list[Fact]) -> PlanningProblem:
        problem = replace(self._problem, goals=tuple(goals))
        if len(problem.objects) <= MAX_OBJECTS:
            return problem
        return StaticFacts(self._base, problem).without_bystanders(problem)

    def _supposing(
        self, problem: PlanningProblem, facts: Iterable[Fact], *, with_functions: bool
    ) -> Relaxation:
        relaxation = Relaxation(self._base, problem, supposed=facts, with_functions=with_functions)
        relaxation.run(until=problem.goals)
        return relaxation

    def _reasons_for(
        self, goal: Fact, problem: PlanningProblem, supposed: Relaxation, present: Relaxation
    ) -> Iterator[str]:
        missing = supposed.missing(goal)
        if missing is None:
            yield f"no sequence of actions leads to {phrase(self._base, goal)}"
        elif missing:
            reason = _Reason(self._base, problem, goal, supposed.leaves(goal), present)
            yield from reason.sentences(self._smallest(goal, problem, missing))
        else:
            values = sorted(str(fact).removeprefix(FUNCTION) for fact in self._values_missing(goal, problem))
            yield f"nothing is known of {enumeration(values)}"

    def _values_missing(self, goal: Fact, problem: PlanningProblem) -> frozenset[Fact]:
        """The values of functions that the goal lacks."""
        facts = {
            Fact(FUNCTION + name, args)
            for name, kinds in self._base.file.functions.items()
            for args in self._combinations(kinds)
            if (name, args) not in problem.functions
        }
        problem = replace(problem, goals=(goal,))
        return self._supposing(problem, facts, with_functions=True).missing(goal) or frozenset()

    def _smallest(self, goal: Fact, problem: PlanningProblem, missing: frozenset[Fact]) -> list[Fact]:
        """The missing facts without those that the goal could do without after all."""
        kept = set(missing)
        alone = replace(problem, goals=(goal,))
        for fact in sorted(missing) if len(missing) > 1 else ():
            trial = self._supposing(alone, kept - {fact}, with_functions=False)
            if trial.missing(goal) is not None:
                kept.remove(fact)
        return sorted(kept)

    def _plausible(self, problem: PlanningProblem, *, strict: bool = True) -> Iterator[Fact]:
        """The absent facts that are likely to be missing; if not strict, also statics that contradict present ones."""
        shapes = {(fact.predicate, self._shape(fact)) for fact in problem.facts}
        for predicate in sorted({need.predicate for op in self._base.operators for need in op.preconditions}):
            holding = [fact for fact in problem.facts if fact.predicate == predicate]
            is_fluent = predicate in self._base.fluents
            key = key_length(holding, least=1 if is_fluent else 2)
            taken = {fact.args[:key] for fact in holding} if key and (is_fluent or strict) else set()
            for args in self._combinations(argument_types(predicate, self._base), problem.objects):
                fact = Fact(predicate, args)
                fits = not is_fluent or (predicate, self._shape(fact)) in shapes
                if fits and args[:key] not in taken and fact not in problem.facts | set(problem.goals):
                    yield fact

    def _shape(self, fact: Fact) -> tuple[str, ...]:
        """The fact's constants, and the types of its objects."""
        return tuple(self._problem.objects.get(arg, arg) for arg in fact.args)

    def _combinations(
        self, kinds: tuple[str, ...], objects: Mapping[str, str] | None = None
    ) -> Iterator[tuple[str, ...]]:
        known = {*(objects or self._problem.objects), *self._base.constants}
        choices = [sorted(self._members.get(kind, frozenset()) & known) for kind in kinds]
        return product(*choices) if prod(map(len, choices)) <= MAX_SUPPOSED else iter(())


def key_length(facts: list[Fact], *, least: int = 1) -> int:
    """How many leading arguments determine the others in all these facts.

    0 if none do, or if there are fewer facts than `least` to tell from.
    """
    arity = len(facts[0].args) if len(facts) >= least else 0
    for length in range(1, arity):
        if max(Counter(fact.args[:length] for fact in facts).values()) == 1:
            return length
    return 0


class _Reason:
    """The words for one goal's missing facts; `leaves` are all facts that the supposed way starts from."""

    def __init__(
        self,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        goal: Fact,
        leaves: frozenset[Fact],
        present: Relaxation,
    ) -> None:
        self._base = knowledge_base
        self._problem = problem
        self._goal = goal
        self._leaves = leaves
        self._present = present
        self._tied = [
            fact
            for fact in sorted(leaves & problem.facts)
            if fact.predicate in knowledge_base.fluents and set(fact.args) & set(goal.args)
        ]
        """Present facts about what the goal is about."""
        self._pinned = {
            *goal.args,
            *knowledge_base.constants,
            *(arg for fact in self._tied for arg in fact.args),
        }

    def sentences(self, missing: list[Fact]) -> Iterator[str]:
        """Static facts first: without them, fluents such as a free place make no sense."""
        statics = [fact for fact in missing if fact.predicate not in self._base.fluents]
        special = []
        for fact in statics or missing:
            if fact.predicate in self._base.comparisons:
                yield self._too_small_or_great(fact)
                continue
            words = self._nothing(fact) if statics else self._nowhere(fact)
            if words:
                yield words
            elif statics:
                special.append(phrase(self._base, fact))
            else:
                yield self._tie(fact) + denial(self._base, fact)
        if special:
            yield f"{self._frontier()}it would take that {enumeration(special)}"

    def _too_small_or_great(self, fact: Fact) -> str:
        """`PHOTOGRAPH needs battery(rover_2) >= 0.3; it is 0.12`, of all that could be used instead."""
        comparison = self._base.comparisons[fact.predicate]
        actions = {
            op.spec.name
            for op in self._base.operators
            if any(literal.predicate == fact.predicate for literal in op.preconditions)
        }
        needs = f"{enumeration(sorted(actions))} {'needs' if len(actions) == 1 else 'need'}"
        known = {args: self._problem.numbers.get((comparison.quantity, args)) for args in self._rivals(fact)}
        words = {args: "not known" if value is None else number_words(value) for args, value in known.items()}
        if len(words) == 1:
            return f"{needs} {comparison.of(*fact.args)}; it is {words[fact.args]}"
        kinds = [self._problem.objects.get(arg, arg) for arg in fact.args]
        values = [f"{value} for {', '.join(args)}" for args, value in words.items()]
        return f"{needs} {comparison.of(*kinds)}; it is {enumeration(values)}"

    def _rivals(self, fact: Fact) -> list[tuple[str, ...]]:
        """The arguments that the fact could have, as far as other static facts tell; its own first."""
        loose = [arg for arg in fact.args if arg not in self._pinned]
        if len(loose) != 1:
            return [fact.args]
        arg = loose[0]
        needed = [
            leaf
            for leaf in self._leaves
            if arg in leaf.args
            and leaf.predicate not in self._base.fluents
            and leaf.predicate not in self._base.comparisons
            and {*leaf.args} - {arg} <= self._pinned
        ]
        kind = self._problem.objects[arg]
        others = naturally_sorted(
            name
            for name, other in self._problem.objects.items()
            if other == kind
            and name not in self._pinned
            and all(leaf.renamed({arg: name}) in self._problem.facts for leaf in needed)
        )
        names = [arg, *(name for name in others if name != arg)]
        return [fact.renamed({arg: name}).args for name in names]

    def _nowhere(self, fact: Fact) -> str:
        """`sample_1 is not in any location`, if a fluent's first arguments have no fact at all; else nothing."""
        key = key_length([other for other in self._problem.facts if other.predicate == fact.predicate])
        if not key:
            return ""
        objects = self._problem.objects
        kinds = [f"any {objects[arg]}" if arg in objects else arg for arg in fact.args]
        return denial(self._base, Fact(fact.predicate, (*fact.args[:key], *kinds[key:])))

    def _nothing(self, fact: Fact) -> str:
        """`no robot that can DOCK reaches bay_7`, if that is true of a static fact; else nothing."""
        holding = [other for other in self._problem.facts if other.predicate == fact.predicate]
        for position, arg in enumerate(fact.args):
            if arg in self._pinned:
                continue
            rivals = [other.args[position] for other in holding if _alike(other, fact, position)]
            that = self._excluding(arg, rivals)
            if that is not None:
                kind = self._problem.objects[arg]
                return self._where(fact, arg) + nothing(self._base, fact, position, f"{kind}{that}")
        return ""

    def _excluding(self, arg: str, rivals: list[str]) -> str | None:
        """` that can DOCK`: what none of the rivals does but the supposed way needs; empty without rivals."""
        if not rivals:
            return ""
        for leaf in sorted(self._leaves):
            if leaf.predicate in self._base.fluents or leaf.args.count(arg) != 1:
                continue
            position = leaf.args.index(arg)
            that = clause(self._base, leaf, position)
            pinned = {*leaf.args} - {arg} <= self._pinned
            if that and pinned and not any(leaf.renamed({arg: r}) in self._problem.facts for r in rivals):
                return f" {that}"
        return None

    def _where(self, fact: Fact, leaving_out: str) -> str:
        """What the fact has to do with the goal, where it does not say so itself."""
        about = set(fact.args) - {leaving_out, *self._goal.args} - self._base.constants.keys()
        return (self._tie(fact) or self._frontier()) if about else ""

    def _tie(self, fact: Fact) -> str:
        """`sample_9 is in bay_13: `, if the goal is about sample_9 and the fact about bay_13; else nothing."""
        about = set(fact.args) - set(self._goal.args) - self._base.constants.keys()
        ties = [tie for tie in self._tied if about & set(tie.args)]
        return f"{phrase(self._base, ties[0])}: " if ties else ""

    def _frontier(self) -> str:
        """How far the goal's own predicate gets from the present facts: its last argument's other values."""
        *first, last = self._goal.args
        kind = self._problem.objects.get(last)
        others = naturally_sorted(name for name, other in self._problem.objects.items() if other == kind)
        goal = self._goal.predicate
        near = [name for name in others if self._present.holds(Fact(goal, (*first, name)))]
        if not near or not first:
            return ""
        best = Fact(goal, (*first, enumeration(near, "or")))
        return f"at best {phrase(self._base, best)}; "


def _alike(one: Fact, other: Fact, position: int) -> bool:
    return all(i == position or a == b for i, (a, b) in enumerate(zip(one.args, other.args, strict=True)))
