"""Breakpoints on the rules of simulated robots: their world stands where one is met, for people to look and step.

They are kept by the simulation's process alone and end with it.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from app.agents.rules import RuleService
from app.agents.running_world import Debuggable, RunningWorld
from app.agents.tuning import robot_and_world
from app.core import Core
from app.domain.errors import Conflict, Invalid, Unavailable
from app.domain.events import BreakpointsSet
from robots.executive.breakpoints import Debugging
from robots.world import RobotSpec, WorldFile


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotBreakpoints:
    """The breakpoints of a robot's rules, and where its world stands.

    :param refusal: why its world cannot stand, in words; empty: it can.
    """

    robot: str
    world: str
    refusal: str
    debugging: Debugging


class BreakpointService:
    """Sets breakpoints, and lets worlds that stand at one go on."""

    def __init__(
        self,
        core: Core,
        *,
        files: Mapping[str, WorldFile],
        running: Mapping[str, RunningWorld],
        rules: RuleService,
    ) -> None:
        """:param files: of the worlds by name, as they are now. :param running: those of this process."""
        self._database = core.database
        self._events = core.events
        self._files = files
        self._running = running
        self._rules = rules
        self._used: set[str] = set()

    def get(self, robot: str) -> RobotBreakpoints:
        spec, world = robot_and_world(self._files, robot)
        refusal = self._refusal(spec, world)
        simulation = self._running[world].debuggable
        known = Debugging() if refusal or simulation is None else _asked(simulation)
        return RobotBreakpoints(robot=robot, world=world, refusal=refusal, debugging=known)

    def put(self, robot: str, rules: Collection[str], *, actor: str) -> RobotBreakpoints:
        """Replace the breakpoints of the robot's rules, "guard:3" and the like; none: a world without any goes on.

        :raises Conflict: if its world must not stand, or no simulation of this service runs it.
        :raises Invalid: if no rule begins there; names where rules begin.
        """
        spec, world = robot_and_world(self._files, robot)
        simulation = self._simulation(spec, world)
        self._check(robot, rules)
        if rules:
            self._used.add(world)
        try:
            debugging = simulation.break_at(robot, frozenset(rules))
        except RuntimeError as error:
            raise _gone(error) from error
        with self._database.write() as session:
            told = BreakpointsSet(subject=robot, world=world, actor=actor, rules=tuple(sorted(set(rules))))
            self._events.append(session, told)
        return RobotBreakpoints(robot=robot, world=world, refusal="", debugging=debugging)

    def stands(self, world: str) -> bool:
        """Whether the world stands at a breakpoint now. Cheap for worlds that never had any."""
        running = self._running.get(world) if world in self._used else None
        simulation = None if running is None else running.debuggable
        try:
            return simulation is not None and bool(simulation.debugging().halts)
        except RuntimeError:  # it is away
            return False

    def why_mute(self, robot: str) -> str:
        """Why the robot answers nothing now, in words; empty: it may answer."""
        _, world = robot_and_world(self._files, robot)
        if not self.stands(world):
            return ""
        return (
            f"{world} stands at a breakpoint, and {robot} answers nothing until it goes on: POST "
            f"/v1/robots/{robot}/breakpoints:continue; GET /v1/robots/{robot}/breakpoints says where minds stand"
        )

    def go_on(self, robot: str, *, one_cycle: bool) -> RobotBreakpoints:
        """Let the robot's world leave the breakpoint: for good, or for one control cycle.

        :raises Conflict: if it stands at none.
        """
        spec, world = robot_and_world(self._files, robot)
        simulation = self._simulation(spec, world)
        if not _asked(simulation).halts:
            raise Conflict(f"{world} does not stand at a breakpoint", code="world-runs", thing=world)
        try:
            debugging = simulation.go_on(one_cycle=one_cycle)
        except RuntimeError as error:
            raise _gone(error) from error
        return RobotBreakpoints(robot=robot, world=world, refusal="", debugging=debugging)

    def _simulation(self, spec: RobotSpec, world: str) -> Debuggable:
        refusal = self._refusal(spec, world)
        simulation = self._running[world].debuggable
        if refusal or simulation is None:
            raise Conflict(refusal, code="world-cannot-stand", thing=spec.name)
        return simulation

    def _refusal(self, spec: RobotSpec, world: str) -> str:
        """Why the world must not stand, or cannot; empty if it can."""
        if spec.external:
            return f"software of its own drives {spec.name}: only simulated robots stop at their rules"
        if real := [one.name for one in self._files[world].robots if one.external]:
            return (
                f"{world} has robots with software of their own ({', '.join(real)}), which a breakpoint would not "
                "stop; try the rules in a world of simulated robots"
            )
        if self._running[world].fleet is not None:
            return (
                f"a fleet drives {world}; breakpoints are for worlds that the service simulates itself: run "
                "`macta serve` without a broker"
            )
        if self._running[world].debuggable is None:
            return f"no simulation of {world} runs in this process, or it is not built yet"
        return ""

    def _check(self, robot: str, wanted: Collection[str]) -> None:
        from robots.deliberative.rule_set import read_rule_set  # a parser, which few services need

        ruled = self._rules.get(robot)
        read = read_rule_set({**ruled.files, **ruled.role_files})
        known = {f"{file.name}:{rule.place.line}": None for file in read for rule in file.rules}
        for one in wanted:
            if one not in known:
                where = f"its rules begin at {', '.join(known)}" if known else "it has none"
                raise Invalid(f"no rule of {robot} begins at {one}; {where}", code="no-such-rule")


def _asked(simulation: Debuggable) -> Debugging:
    try:
        return simulation.debugging()
    except RuntimeError as error:
        raise _gone(error) from error


def _gone(error: RuntimeError) -> Unavailable:
    return Unavailable(f"the simulation does not answer: {error}", code="simulation-away")
