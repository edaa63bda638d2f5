"""Plans, alternatives and explanations as text for a terminal."""

from collections.abc import Iterator, Sequence
from math import ceil

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from app.domain.explanation_document import ActionExplanationBody, ExplanationBody
from app.domain.goal_language.constraints import UNCONSTRAINED, Constraints
from app.domain.goal_language.stated_holds import HoldPreview
from app.domain.goal_language.terms import Reading
from app.domain.plan_document import ActionBody, ForecastBody, PlanBody, PreferencesBody, RepairsBody
from app.domain.tender_document import TenderBody

EQUAL_S = 0.05
"""Times that differ by no more count as equal."""
LONGEST_PATH = 12
"""The most actions of a critical path that are shown; of a longer one only the two ends are."""
MAX_WAITS = 5
MAX_FORECASTS = 8
"""The most goals of which it is said when they are likely achieved."""


def show_terms(
    console: Console,
    readings: Sequence[Reading],
    constraints: Constraints = UNCONSTRAINED,
    holds: Sequence[HoldPreview] = (),
) -> None:
    """Show how quantities and times of sentences were resolved, the constraints on the plan, and the holds."""
    for reading in readings:
        console.print(f"[bold]{escape(reading.said)}[/]: {escape(', '.join(reading.means))}")
    if words := (*constraints.words, *constraints.preference_words):
        console.print(f"[bold]Constraints[/]: {escape('; '.join(words))}")
    if holds:
        console.print(f"[bold]A service[/] {escape('; '.join(hold.words for hold in holds))}")


def show_plan(console: Console, plan: PlanBody) -> None:
    """Show actions with their time windows, causal links, why each robot was chosen, and expected time and effort."""
    console.print(_actions(plan))
    console.print(_links(plan))
    for robot, why in sorted(plan.recruitment.items()):
        work = _work(plan, robot)
        console.print(f"[bold]{robot}[/]{f' ({work})' if work else ''}: {escape(why)}")
    if plan.tender is not None:
        _show_tender(console, plan.tender)
    for line in _clearances(plan):
        console.print(line)
    if plan.critical_path:
        console.print(f"Critical path: {_path(plan.critical_path)}")
    if plan.repairs is not None:
        show_repairs(console, plan.repairs)
    for late in plan.late:
        console.print(f"[bold red]{escape(str(late.goal))}[/] comes {late.late_s:.0f} s after its deadline")
    for left_out in plan.left_out:
        console.print(
            f"[bold]Left out[/], worth {left_out.value:g}: {escape(f'{left_out.goal}: {left_out.reason}')}"
        )
    if plan.value is not None:
        console.print(f"Optional goals achieved are worth {plan.value:g}{_value_gap(plan)}")
    if plan.preferences is not None:
        for line in _preferences(plan.preferences, plan.makespan_s):
            console.print(line)
    if plan.forecast is not None:
        for line in _forecast(plan.forecast):
            console.print(line)
    figures = (f"[bold]{plan.makespan_s:.0f} s[/]{_gap(plan)}", _effort(plan.distance_m, plan.energy_j))
    expected = ", ".join(filter(None, figures))
    console.print(f"Expected to take {expected}; planned by {plan.engine} in {plan.planning_s:.2f} s.\n")


def _value_gap(plan: PlanBody) -> str:
    if plan.value is None or plan.value_bound is None or plan.value_bound <= plan.value:
        return " (no choice is worth more)"
    return f" (none is worth more than {plan.value_bound:g})"


def _preferences(preferences: PreferencesBody, makespan_s: float) -> Iterator[str]:
    """Which preferences are kept, and why the others are not."""
    for one in preferences.outcomes:
        if one.kept:
            yield f"[bold]Kept[/]: {escape(one.preference)}"
        else:
            yield f"[bold]Not kept[/], at a cost of {one.cost_s:g} s: {escape(f'{one.preference}: {one.reason}')}"
    total = f"Makespan and costs are {makespan_s + preferences.cost_s:.0f} s together"
    yield f"{total} (proven: of no plan below {preferences.bound_s:.0f} s)" if preferences.bound_s else total
    if preferences.cut_short:
        yield "[bold]Cut short[/]: not every promising choice of preferences was tried; --time-limit gives more time"


def _forecast(likely: ForecastBody) -> Iterator[str]:
    """When the goals are likely achieved, the least likely on time first."""
    if likely.on_time is not None:
        due = sum(goal.deadline_s is not None for goal in likely.goals)
        what = "its deadline is kept" if due == 1 else f"all {due} deadlines are kept"
        yield f"[bold]On time[/]: {_percent(likely.on_time)} that {what}"
    ranked = sorted(
        likely.goals, key=lambda goal: (2.0 if goal.on_time is None else goal.on_time, -goal.p90_s)
    )
    for goal in ranked[:MAX_FORECASTS]:
        by = ""
        if goal.on_time is not None and goal.deadline_s is not None:
            by = f"{_percent(goal.on_time)} by {goal.deadline_s:.0f} s; "
        yield (
            f"  {escape(str(goal.goal))}: {by}half of the time within {goal.p50_s:.0f} s, "
            f"10 to 90 % in {goal.p10_s:.0f} to {goal.p90_s:.0f} s"
        )
    if len(ranked) > MAX_FORECASTS:
        yield f"  and {len(ranked) - MAX_FORECASTS} more"


def _percent(chance: float) -> str:
    """In words; only what happened in every sample, or in none, is 100 or 0 %."""
    if 0.0 < chance < 0.005 or 0.995 < chance < 1.0:
        return "< 1 %" if chance < 0.5 else "> 99 %"
    return f"{100 * chance:.0f} %"


def _clearances(plan: PlanBody) -> list[str]:
    """The orderings for which a robot waits for clearance, and why."""
    tags = {action.id: f"{action.id} {action.tag}" for action in plan.actions}
    return [
        f"By clearance: {tags[one.after]} after {tags[one.before]}, for {escape(one.why)}"
        for one in plan.orderings
        if one.why
    ]


def _show_tender(console: Console, tender: TenderBody) -> None:
    """Show who is awarded which leg, and why."""
    for leg in tender.legs:
        bidders = sum(len(part.offers()) for part in leg.parts)
        what = f"[bold]{leg.id}[/], {escape(str(leg.goal))}, {bidders} bid{'' if bidders == 1 else 's'}"
        console.print(f"{what}: {escape(leg.why or 'nobody is awarded it')}")
    if tender.reason:
        console.print(f"Planned without awards: {escape(tender.reason)}")


def show_repairs(console: Console, repairs: RepairsBody) -> None:
    """Show how the plan differs from the one that it replaces."""
    summary, *details = repairs.difference.words or ("nothing is different",)
    console.print(f"Repairs {repairs.plan_id} ({repairs.course}): {escape(summary)}")
    for line in details:
        console.print(f"  {escape(line)}")


def show_alternatives(console: Console, plans: Sequence[PlanBody]) -> None:
    """Show a table of the alternative plans."""
    table = Table(title="Alternatives", title_justify="left", box=SIMPLE_HEAD)
    table.add_column("Best at")
    chances = [plan.forecast.on_time if plan.forecast is not None else None for plan in plans]
    has_deadline = any(chance is not None for chance in chances)
    for name in ("Takes, s", "Drives, m", "Uses, J", "To clear", *(["On time"] if has_deadline else [])):
        table.add_column(name, justify="right")
    table.add_column("Robots", style="cyan")
    for plan, chance in zip(plans, chances, strict=True):
        table.add_row(
            escape(plan.label),
            f"{plan.makespan_s:.1f}",
            f"{plan.distance_m:.1f}",
            f"{plan.energy_j:.0f}",
            str(plan.clearances),
            *([] if chance is None else [_percent(chance)]),
            ", ".join(plan.robots),
        )
    console.print(table)


def show_explanation(console: Console, plan: PlanBody, explanation: ExplanationBody) -> None:
    """Show the reasons for each action, the critical path, the longest waits, and what constraints and robots cost."""
    console.print("[bold]Why[/]")
    for action, why in zip(plan.actions, explanation.actions, strict=True):
        console.print(f"[bold]{action.id}[/] {escape(action.description)}")
        for words in _reasons(why):
            console.print(f"    {escape(words)}")
    console.print("\n[bold]What determines the makespan[/]")
    for words in explanation.makespan:
        console.print(f"  {escape(words)}")
    for wait in explanation.waits[:MAX_WAITS]:
        console.print(f"  {escape(wait.words)}")
    for cost in explanation.constraints:
        console.print(f"[bold]{escape(cost.constraint)}[/]: {escape(cost.words)}")
    for robot, words in explanation.robots.items():
        console.print(f"[bold]{robot}[/]: {escape(words)}")
    console.print()


def _reasons(why: ActionExplanationBody) -> list[str]:
    """What the action is for, why its robots were chosen, and what it comes after."""
    in_the_end = f"; in the end for {', '.join(map(str, why.goals))}" if len(why.chain) > 1 else ""
    purpose = [why.because[0] + in_the_end] if why.because else []
    robots = [f"{robot}: {words}" for robot, words in why.robots.items()]
    return [*purpose, *robots, *why.order[: len(why.after)]]


def _gap(plan: PlanBody) -> str:
    """The makespan's gap to the proven lower bound, in words; empty without one."""
    bound_s = plan.lower_bound_s or 0.0
    if bound_s <= 0:
        return ""
    if plan.makespan_s <= bound_s + EQUAL_S:
        return " (no plan is quicker)"
    over = ceil(100 * (plan.makespan_s - bound_s) / bound_s)
    return f" (at most {over} % over the quickest possible, {bound_s:.0f} s)"


def _work(plan: PlanBody, robot: str) -> str:
    """Distance and energy of the robot's actions, in words; a team's are divided evenly."""
    mine = [action for action in plan.actions if robot in action.agents]
    distance_m = sum(action.distance_m / len(action.agents) for action in mine)
    return _effort(distance_m, sum(action.energy_j / len(action.agents) for action in mine))


def _effort(distance_m: float, energy_j: float) -> str:
    """Distance and energy in words; empty where the knowledge base has no figures."""
    if not distance_m and not energy_j:
        return ""
    energy = f"{energy_j / 1000:.1f} kJ" if energy_j >= 1000 else f"{energy_j:.0f} J"
    return f"{distance_m:.0f} m, {energy}"


def _path(ids: Sequence[str]) -> str:
    if len(ids) > LONGEST_PATH:
        half = LONGEST_PATH // 2
        ids = [*ids[:half], f"({len(ids) - 2 * half} more)", *ids[-half:]]
    return " → ".join(ids)


def _actions(plan: PlanBody) -> Table:
    table = Table(title="Plan-net", title_justify="left", box=SIMPLE_HEAD)
    table.add_column("", no_wrap=True)
    table.add_column("Robot", style="cyan", no_wrap=True)
    table.add_column("Action")
    table.add_column("Starts, s", justify="right", no_wrap=True)
    table.add_column("Lasts", justify="right", no_wrap=True)
    table.add_column("Slack", justify="right", no_wrap=True)
    for action in plan.actions:
        table.add_row(
            action.id,
            ", ".join(action.agents),
            escape(_doing(action)),
            f"{action.earliest_start_s:.0f} – {action.latest_start_s:.0f}",
            f"{action.duration_s:.0f}",
            _slack(action),
        )
    return table


def _slack(action: ActionBody) -> str:
    if action.critical:
        return "[bold]critical[/]"
    return f"{action.slack_s:.0f}" if action.slack_s >= 1 else f"{action.slack_s:.1f}"


def _doing(action: ActionBody) -> str:
    """The tag and what it is done to, short enough for a line: `TRANSPORT sample_1 door_1 → interchange_2`."""
    words = action.arguments
    places = [words[ref] for ref in ("ref1", "ref2") if ref in words]
    phase = f"(phase {action.phase} of {action.phases})" if action.phases else ""
    if not places and "object" not in words:
        acting = {*action.agents, "+".join(action.agents)}
        done_to = [word for word in words.values() if word not in acting]
    else:
        done_to = [words.get("object", ""), " → ".join(places)]
    return " ".join(filter(None, (action.tag, *done_to, phase)))


def _links(plan: PlanBody) -> Table:
    """The causal links between actions and to the goals, without those from initial facts."""
    table = Table(title="Causal links", title_justify="left", box=SIMPLE_HEAD)
    table.add_column("From", no_wrap=True)
    table.add_column("Fact")
    table.add_column("To", no_wrap=True)
    for link in plan.causal_links:
        if link.producer != "initial":
            table.add_row(link.producer, escape(str(link.fact)), link.consumer)
    return table
