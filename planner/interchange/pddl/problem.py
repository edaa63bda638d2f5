"""A planning problem as a PDDL problem, for the domain that is written of its knowledge base.

Both state the problem's zones (`stated_zones`); `pddl_of` writes them together.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

from planner.errors import InvalidPlan
from planner.fact import Fact
from planner.interchange.pddl import numbers
from planner.interchange.pddl.domain import domain_text, section
from planner.interchange.pddl.vocabulary import Form, Vocabulary
from planner.interchange.stated_zones import StatedZones
from planner.knowledge import GroundAction, KnowledgeBase
from planner.knowledge.expression import scale_term
from planner.problem.duration_table import duration_table
from planner.problem.interface import PlanningProblem
from planner.problem.zones import ground

TENTHS = 10


class PddlTask:
    """A planning problem as PDDL for a planner, and the planner's steps as ground actions."""

    def __init__(
        self,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        form: Form,
        *,
        is_simplified: bool = False,
    ) -> None:
        """
        :param form: not `NUMERIC`, whose steps may have a parameter that no operator has.
        :param is_simplified: as `Vocabulary` has it.
        """
        self.knowledge_base = knowledge_base
        self.problem = problem
        stated = StatedZones(knowledge_base, problem)
        self._words = Vocabulary(stated.knowledge_base, form, is_simplified=is_simplified)
        self._problem_text = problem_text(self._words, stated.problem)
        self._operators = {self._words.operators[name]: op for name, op in stated.original.items()}

    def write(self, folder: Path) -> None:
        """Write `domain.pddl` and `problem.pddl`."""
        (folder / "domain.pddl").write_text(domain_text(self._words))
        (folder / "problem.pddl").write_text(self._problem_text)

    def ground(self, operator: str, objects: Sequence[str]) -> GroundAction:
        """The ground action of a planner's step, in whatever case it is written.

        :raises InvalidPlan: if there is no such operator or object, or the action has no duration.
        """
        op = self._operators.get(operator.lower())
        if op is None or len(objects) != len(op.parameters):
            raise InvalidPlan(f"no operator {operator}({', '.join(objects)})")
        try:
            values = [self._words.objects.original(name) for name in objects]
        except KeyError as error:
            raise InvalidPlan(f"{operator}({', '.join(objects)}): no object {error}") from error
        binding = dict(zip(op.parameters, values, strict=True))
        action = ground(op, binding, self.problem, self.knowledge_base)
        if action is None:
            raise InvalidPlan(f"{operator}({', '.join(objects)}) has no duration")
        return action


def pddl_of(knowledge_base: KnowledgeBase, problem: PlanningProblem, form: Form) -> tuple[str, str]:
    """The problem as PDDL: the domain's and the problem's text."""
    stated = StatedZones(knowledge_base, problem)
    words = Vocabulary(stated.knowledge_base, form, has_phases=True)
    return domain_text(words), problem_text(words, stated.problem)


def problem_text(words: Vocabulary, problem: PlanningProblem) -> str:
    """The problem in PDDL; a goal whose predicate is also an other effect is stated with its intended twin.

    The problem's objects are added to the words.
    """
    objects = sorted(problem.objects.items())
    lines = [f"{words.objects.add(name)} - {words.types[kind]}" for name, kind in objects]
    goals = [_goal(goal, words) for goal in dict.fromkeys(problem.goals)]
    metric = "total-time" if words.is_temporal else "total-cost"
    sections = [
        "(define (problem macta_problem)",
        "  (:domain macta)",
        section("objects", lines),
        section("init", _initial(words, problem)),
        "\n".join(["  (:goal (and", *(f"    {goal}" for goal in goals), "  ))"]),
        f"  (:metric minimize ({metric}))",
    ]
    return "\n".join(filter(None, sections)) + "\n)\n"


def _initial(words: Vocabulary, problem: PlanningProblem) -> Iterator[str]:
    if not words.is_temporal:
        yield "(= (total-cost) 0)"
    for fact in sorted(problem.facts):
        yield words.atom(words.word(fact.predicate), fact.args)
        if fact in problem.goals and fact.predicate in words.twins:
            yield _goal(fact, words)
    yield from _functions(words, problem)
    yield from numbers.initial_numbers(words, problem)
    for name, kind in sorted(problem.objects.items()):
        for agent in words.agent_types():
            if words.base.file.is_a(kind, agent):
                yield words.atom(words.word(agent, "idle"), (name,))
    for op in words.steps:
        measure = words.measure(op)
        if words.is_tabled(op):
            for row, seconds in duration_table(op, problem, words.base):
                yield words.atom(words.word(op.name, "defined"), row)
                yield f"(= {words.atom(measure, row)} {_measured(seconds, words)})"
        elif words.is_temporal:
            scale = problem.functions.get(scale_term(op.spec.name, len(op.agents)), 1.0)
            yield f"(= ({measure}) {_number(scale)})"
        else:
            yield f"(= ({measure}) {_measured(op.duration_s({}, problem.functions) or 0.0, words)})"


def _functions(words: Vocabulary, problem: PlanningProblem) -> Iterator[str]:
    """The functions' values, and that they are defined."""
    if words.is_simplified or not words.is_temporal:
        return
    for (name, args), value in sorted(problem.functions.items()):
        if name in words.base.file.functions and all(arg in words.objects for arg in args):
            if args:
                yield words.atom(words.word(name, "defined"), args)
            yield f"(= {words.atom(words.word(name), args)} {_number(value)})"


def _goal(goal: Fact, words: Vocabulary) -> str:
    word = words.word(goal.predicate, "intended" if goal.predicate in words.twins else "")
    return words.atom(word, goal.args)


def _measured(seconds: float, words: Vocabulary) -> str:
    return _number(seconds) if words.is_temporal else str(max(1, round(seconds * TENTHS)))


def _number(value: float) -> str:
    """As a decimal: PDDL readers may not accept an exponent."""
    return f"{value:.6f}".rstrip("0").rstrip(".")
