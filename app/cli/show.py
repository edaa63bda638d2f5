"""Plan-nets as an operator reads them in a terminal."""

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from app.plan_body import ActionBody, PlanBody


def show_plan(console: Console, plan: PlanBody) -> None:
    """The actions with their time windows, the causal links, and why each robot was chosen."""
    console.print(_actions(plan))
    console.print(_links(plan))
    for robot, why in sorted(plan.recruitment.items()):
        console.print(f"[bold]{robot}[/]: {escape(why)}")
    console.print(
        f"Expected to take [bold]{plan.makespan_s:.0f} s[/]; planned by {plan.engine} in {plan.planning_s:.2f} s.\n"
    )


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
            f"{action.slack_s:.0f}" if action.slack_s >= 0.5 else "[bold]critical[/]",
        )
    return table


def _doing(action: ActionBody) -> str:
    """The tag and what it is done to, short enough for a line: `TRANSPORT sample_1 door_1 → interchange_2`."""
    words = action.arguments
    places = [words[ref] for ref in ("ref1", "ref2") if ref in words]
    return " ".join(filter(None, (action.tag, words.get("object", ""), " → ".join(places))))


def _links(plan: PlanBody) -> Table:
    """The causal links between actions and to the goals; what merely held at the start is left out."""
    table = Table(title="Causal links", title_justify="left", box=SIMPLE_HEAD)
    table.add_column("From", no_wrap=True)
    table.add_column("Fact")
    table.add_column("To", no_wrap=True)
    for link in plan.causal_links:
        if link.producer != "initial":
            table.add_row(link.producer, escape(str(link.fact)), link.consumer)
    return table
