"""`macta demo`: plans a goal, approves the plan and shows the mission; checks the simulation's ground truth."""

import tempfile
from collections.abc import Collection, Mapping
from contextlib import nullcontext
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn
from rich.table import Column

from app.api.bodies import plan_body
from app.api.mission_bodies import MissionBody
from app.background_compilation import BackgroundCompilation
from app.cli.background import SMALL_ROBOTS, ending, groups_for
from app.cli.goal_input import FACT, read_goals
from app.cli.ground_truth import holds
from app.cli.render import show_plan, show_repairs, show_terms
from app.cli.settings import settings_of
from app.cli.start_progress import StartProgress
from app.composition import RunningWorld, Service
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles.goal import GoalState
from app.domain.lifecycles.mission import MissionState
from app.domain.recovery_rules import Policy
from app.domain.tender_document import Allocation
from app.domain.world_model import initial_facts
from app.domain.world_model.vocabulary import symbolic_all
from app.packs.pack_set import Packs
from app.planning.goal_service import GoalRequest
from app.settings import Settings
from app.store import GoalRow, ResultRow
from robots.compilation import uncompiled
from robots.wire import SymbolicFact
from robots.world import WorldFile
from sim import SimulationProcess

REFRESH_S = 0.1
"""The longest interval between two updates of the display."""
OPERATOR = "demo"
SMALL_GOALS = 1
"""A demo of at most this number of goals and `SMALL_ROBOTS` robots compiles nothing: that takes less time than
compilation."""


def demo(
    world: WorldFile,
    packs: Packs,
    text: str,
    speed: float | None,
    seed: int,
    *,
    allocation: str = Allocation.CENTRAL,
) -> int:
    """Run one goal; 0 if it became true in the simulation or asks for nothing to be done, else 1.

    :raises Invalid: if the goal is not understood or not possible, or a setting is wrong, before anything starts.
    """
    console = Console(highlight=False)
    pace = "as fast as possible" if speed is None else f"at {speed:g}× real time"
    title = escape(world.title or world.name)
    console.print(f"[bold]Macta[/]: {title}, {len(world.robots)} robots, {pace}.")
    console.print(f"Goal: [bold]{escape(text)}[/]\n")
    knowledge_base = packs.knowledge_base()
    stated = read_goals(world, initial_facts(world, knowledge_base), [text], knowledge_base, packs.verbs())
    show_terms(
        console,
        stated.readings,
        stated.constraints,
        stated.holds,
    )
    if stated.nothing_to_do:
        console.print(f"{escape(stated.nothing_to_do)}.")
        return 0
    is_small = len(stated.goals) <= SMALL_GOALS and len(world.robots) <= SMALL_ROBOTS
    with (
        tempfile.TemporaryDirectory(prefix="macta-demo-") as folder,
        uncompiled() if is_small else nullcontext(),
        ending(BackgroundCompilation(groups_for([world]))) as compilation,
    ):
        names = tuple(pack.place for pack in packs.packs)
        settings = settings_of({"data": Path(folder), "database_url": None, "packs": names})
        request = GoalRequest(
            world=world.name,
            text=None if FACT.match(text) else text,
            goal=stated.goals if FACT.match(text) else None,
            recovery=Policy.AUTO,
            allocation=Allocation(allocation),
        )
        return _run(console, settings, world, packs, request, speed, seed, compilation)


def _run(
    console: Console,
    settings: Settings,
    world: WorldFile,
    packs: Packs,
    request: GoalRequest,
    speed: float | None,
    seed: int,
    compilation: BackgroundCompilation,
) -> int:
    """Plan the goal, approve the plan and show the mission in a new simulated world."""
    with (
        StartProgress(console) as progress,
        SimulationProcess.start(
            world, seed=seed, speed=speed, packet_files=packs.packets, tell=progress.tell
        ) as simulation,
    ):
        running = RunningWorld(
            file=world, link=simulation.link, clock=simulation, rate=speed, run=simulation.run
        )
        with Service(settings, [running], tell=progress.tell, compilation=compilation) as service:
            service.planner_ready.result()
            progress.end()
            compilation.start()
            goal = _wait_until_planned(service, service.goals.submit(request, actor=OPERATOR), progress)
            progress.end()
            if goal.state == GoalState.FINISHED:
                console.print(f"{escape(goal.reason)}.")
                return 0
            if goal.plan_id is None or goal.state != GoalState.PLANNED:
                console.print(f"[bold red]No plan[/]: {escape(goal.reason)}")
                return 1
            show_plan(console, plan_body(service.plans.get(goal.plan_id)))
            _, mission_id = service.plans.approve(goal.plan_id, actor=OPERATOR, comment="the demo approves")
            console.print(f"Approved: mission {mission_id}.\n")
            mission = _show_progress(console, service, mission_id)
            wanted = [SymbolicFact.model_validate(fact) for fact in goal.goal]
            truth = simulation.truth()
            held = {fact: holds(fact, world, truth) for fact in wanted}
            code = _show_result(console, mission, held, _believed(service, world))
            for result in service.missions.results(mission_id):
                console.print(escape(_in_words(result)))
            return code


def _wait_until_planned(service: Service, goal: GoalRow, progress: StartProgress) -> GoalRow:
    """Wait until planning has ended, and show what that waits for."""
    generation = service.events.generation
    shown = ""
    while goal.state in goal_lifecycle.TO_BE_PLANNED:
        waits_for = (goal.planning or {}).get("waits_for", "")
        if waits_for and waits_for != shown:
            progress.tell(f"waiting for {waits_for}")
        shown = waits_for
        generation = service.events.wait(generation, REFRESH_S)
        goal = service.goals.get(goal.id)
    return goal


def _show_progress(console: Console, service: Service, mission_id: str) -> MissionBody:
    """Show every robot's progress until the mission has ended."""
    columns = (
        TextColumn("{task.fields[robot]}", style="cyan"),
        BarColumn(bar_width=24),
        TextColumn("{task.completed:.0f}/{task.total:.0f}"),
        TextColumn("{task.description}", markup=False, table_column=Column()),  # wraps; the others do not
    )
    tasks: dict[str, TaskID] = {}
    revision = 1
    generation = service.events.generation
    with Progress(*columns, console=console) as progress:
        overall = progress.add_task("", total=1, robot="mission")
        while True:
            mission = MissionBody.of(*service.missions.get(mission_id))
            if mission.revision != revision:
                revision = mission.revision
                _show_recovery(console, service, mission)
            _update(service, progress, tasks, mission, overall)
            if MissionState(mission.state).ended or mission.state == MissionState.UNKNOWN:
                return mission
            generation = service.events.wait(generation, REFRESH_S)


def _show_recovery(console: Console, service: Service, mission: MissionBody) -> None:
    """Show why the mission goes on with another plan, and how the plan differs."""
    attempt = mission.recovery.attempts[-1]
    console.print(f"[bold]Recovered[/] ({attempt.measure}): {escape(attempt.reason)}")
    repairs = plan_body(service.plans.get(mission.plan_id)).repairs
    if repairs is not None:
        show_repairs(console, repairs)


def _update(
    service: Service, progress: Progress, tasks: dict[str, TaskID], mission: MissionBody, overall: TaskID
) -> None:
    for script in mission.progress:
        if script.robot not in tasks:
            tasks[script.robot] = progress.add_task("", total=len(script.packets), robot=script.robot)
        done = sum(packet.state == "finished" for packet in script.packets)
        current = next((p for p in script.packets if p.state not in ("finished", "waiting")), None)
        doing = script.state or f"script {script.delivery}"
        if current is not None:
            waiting = current.detail or "waiting to sense its pre-condition"
            waits = f" ({waiting})" if current.state == "initializing" else ""
            doing = f"{current.tag}: {current.description}{waits}"
        progress.update(tasks[script.robot], completed=done, description=doing)
    started = mission.started_at_s
    now_s = service.clocks[mission.world].now_s() if mission.ended_at_s is None else mission.ended_at_s
    elapsed_s = 0.0 if started is None else now_s - started
    told = f"{mission.state}, {elapsed_s:.0f} s of about {mission.original_estimate_s:.0f} s"
    done_s = min(elapsed_s, mission.original_estimate_s)
    if MissionState(mission.state) is MissionState.COMPLETED:
        done_s = mission.original_estimate_s
    progress.update(overall, total=mission.original_estimate_s, completed=done_s, description=told)


def _in_words(result: ResultRow) -> str:
    """What a packet has brought."""
    if result.kind == "image":
        brought = f"{result.media_type} of {result.size_bytes:,} bytes from {result.name}"
    else:
        brought = f"{result.name} {result.value:.4g} {result.unit}".rstrip()
    return f"{result.of}, by {result.robot}: {brought}."


def _believed(service: Service, world: WorldFile) -> Collection[SymbolicFact]:
    """The facts of the world model."""
    with service.database.read() as session:
        facts = service.core.facts.facts(session, world.name)
    return symbolic_all(facts, service.core.knowledge_base)


def _show_result(
    console: Console,
    mission: MissionBody,
    held: Mapping[SymbolicFact, bool | None],
    believed: Collection[SymbolicFact],
) -> int:
    """Show which goals became true and how the mission ended; the exit code.

    :param held: the goals, and whether the simulation's ground truth has them; None if that cannot tell.
    :param believed: what the robots' reports say.
    """
    missed = []
    console.print()
    for fact, is_true in held.items():
        where = "in the simulated world" if is_true is not None else "by the robots' reports"
        if not (fact in believed if is_true is None else is_true):
            missed.append(fact)
        mark = "[bold red]not true[/]" if fact in missed else "[bold green]true[/]"
        console.print(f"{fact}: {mark} {where}")
    if mission.ended_at_s is not None and mission.started_at_s is not None:
        took_s = mission.ended_at_s - mission.started_at_s
        estimate_s = mission.original_estimate_s
        change = f" ({took_s / estimate_s - 1:+.0%})" if estimate_s else ""
        console.print(f"Mission {mission.state}: took {took_s:.0f} s, estimated {estimate_s:.0f} s{change}.")
    else:
        console.print(f"Mission {mission.state}.")
    if mission.reason:
        console.print(f"Reason: {escape(mission.reason)}")
    return 0 if not missed and mission.state == MissionState.COMPLETED else 1
