"""A sample-store instance as a job shop for CP-SAT, milliseconds; `optimum` lists the decisions."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ortools.sat.python import cp_model

from benchmarks.planner.legs import ELSEWHERE, MILLISECONDS, Leg, Shop, in_ms
from planner import GroundAction

Var = cp_model.IntVar
_TIMES = ("come", "dock", "gone", "carry", "release", "left")


@dataclass(slots=True, kw_only=True)
class Job:
    """A leg's variables, milliseconds. `come` and `carry`: the starts of the last moves to fetch and to deliver;
    `gone`: the end of the first move away from fetch; `left`: of the first away from deliver, the horizon if none."""

    leg: Leg
    come: Var
    dock: Var
    gone: Var
    carry: Var
    release: Var
    left: Var
    by: dict[str, cp_model.LiteralT] = field(default_factory=dict)
    stop: dict[str, tuple[Var, Var]] = field(default_factory=dict)  # place → chosen, start of the move there
    detour: dict[str, tuple[Var, Var]] = field(default_factory=dict)
    park: dict[str, tuple[Var, Var]] = field(default_factory=dict)


class Jobs:
    """The model of one instance."""

    def __init__(self, shop: Shop, stops: Mapping[str, Sequence[str]]) -> None:
        """:param stops: where robots may stop on a way, by area; none where they cannot be in each other's way."""
        self._shop = shop
        self._stops = stops
        self.model = cp_model.CpModel()
        self._horizon = sum(map(shop.longest, shop.legs))
        self._occupied: dict[tuple[str, str], list[cp_model.IntervalVar]] = defaultdict(list)
        self._makespan = self._time("makespan")
        self._first: dict[tuple[str, int], Var] = {}
        self._next: dict[tuple[str, int, int], Var] = {}
        self._jobs = [self._job(number, leg) for number, leg in enumerate(shop.legs)]
        for area, robots in shop.robots.items():
            for robot in robots:
                self._tour(robot, [n for n, job in enumerate(self._jobs) if job.leg.area == area])
        for job in self._jobs:
            self.model.add_exactly_one(job.by.values())
            if job.leg.area in stops:
                self._occupy(job)
        for intervals in self._occupied.values():
            self.model.add_no_overlap(intervals)
        self._order_samples()
        self.model.minimize(self._makespan)

    def _time(self, name: str) -> Var:
        return self.model.new_int_var(0, self._horizon, name)

    def _flag(self, name: str) -> Var:
        return self.model.new_bool_var(name)

    def _job(self, number: int, leg: Leg) -> Job:
        come, dock, gone, carry, release, left = (self._time(f"{name}_{number}") for name in _TIMES)
        job = Job(leg=leg, come=come, dock=dock, gone=gone, carry=carry, release=release, left=left)
        add = self.model.add
        add(self._makespan >= job.release + self._shop.releasing(leg))
        others = [other for other in self._shop.legs if other is not leg and other.area == leg.area]
        for place in self._stops.get(leg.area, ()):
            job.stop[place] = (self._flag(f"at_{place}"), self._time(f"to_{place}"))
            job.park[place] = (self._flag(f"at_{place}"), self._time(f"to_{place}"))
            if any(leg.fetch in (other.fetch, other.deliver) for other in others):
                job.detour[place] = (self._flag(f"at_{place}"), self._time(f"to_{place}"))
        for what, own in ((job.stop, leg.fetch), (job.detour, leg.fetch), (job.park, leg.deliver)):
            what.pop(own, None)
        job.detour.pop(leg.deliver, None)
        for what in (job.stop, job.detour, job.park):
            self.model.add_at_most_one(chosen for chosen, _ in what.values())
        self._carry(job)
        return job

    def _carry(self, job: Job) -> None:
        """From docking to releasing, straight or with a stop."""
        leg = job.leg
        add = self.model.add
        docked = job.dock + self._shop.docking(leg)
        none = [chosen.negated() for chosen, _ in job.detour.values()]
        haul = self._shop.haul(leg, leg.fetch, leg.deliver)
        add(job.carry >= docked)
        add(job.release >= docked + haul)
        add(job.release >= job.carry + haul).only_enforce_if(none)
        add(job.gone == job.carry + haul).only_enforce_if(none)
        for place, (chosen, there) in job.detour.items():
            add(there >= docked).only_enforce_if(chosen)
            add(job.gone == there + self._shop.haul(leg, leg.fetch, place)).only_enforce_if(chosen)
            add(job.carry >= job.gone).only_enforce_if(chosen)
            add(job.release >= job.carry + self._shop.haul(leg, place, leg.deliver)).only_enforce_if(chosen)

    def _tour(self, robot: str, numbers: list[int]) -> None:
        """The robot's legs as a circuit from where it stands; node 0 is its rest before and after."""
        arcs: list[tuple[int, int, Var]] = [(0, 0, self._flag(f"{robot}_idle"))]
        load: list[cp_model.LinearExprT] = []
        for node, number in enumerate(numbers, start=1):
            job = self._jobs[number]
            absent = self._flag(f"{robot}_not_{number}")
            job.by[robot] = absent.negated()
            first = self._flag(f"{robot}_first_{number}")
            last = self._flag(f"{robot}_last_{number}")
            self._first[robot, number] = first
            arcs += [(node, node, absent), (0, node, first), (node, 0, last)]
            self._come(job, robot, self._shop.stands[robot], None, first)
            self._end(job, robot, last)
            load += [
                first
                * max(self._shop.head(job.leg), self._shop.way(robot, self._shop.stands[robot], job.leg))
            ]
            load += [absent.negated() * self._shop.work(job.leg), last * self._shop.tail(job.leg)]
            for other_node, other in enumerate(numbers, start=1):
                if other != number:
                    follows = self._flag(f"{robot}_{number}_{other}")
                    self._next[robot, number, other] = follows
                    arcs.append((node, other_node, follows))
                    self._come(self._jobs[other], robot, job.leg.deliver, job, follows)
                    load.append(follows * self._shop.way(robot, job.leg.deliver, self._jobs[other].leg))
            for what in (job.stop, job.detour, job.park):
                for place, (chosen, _) in what.items():
                    if not self._shop.reaches(robot, place):
                        self.model.add_implication(chosen, absent)
        self.model.add_circuit(arcs)
        self.model.add(self._makespan >= sum(load))  # implied by the rest, but improves the solver's bound
        self.model.add_no_overlap([self._busy(robot, self._jobs[number]) for number in numbers])

    def _busy(self, robot: str, job: Job) -> cp_model.IntervalVar:
        end = job.release + self._shop.releasing(job.leg)
        size = self._time("busy")
        return self.model.new_optional_interval_var(job.dock, size, end, job.by[robot], robot)

    def _come(self, job: Job, robot: str, origin: str, before: Job | None, when: Var) -> None:
        """The robot's way to the place it fetches at, from where it stood or delivered last; `left` is when the
        first move away from there has ended."""
        leg = job.leg
        add = self.model.add
        ready = 0 if before is None else before.release + self._shop.releasing(before.leg)
        straight = [when, *(chosen.negated() for chosen, _ in job.stop.values())]
        drive = self._shop.way(robot, origin, leg)
        add(job.dock >= ready + drive).only_enforce_if(when)
        add(job.come >= ready).only_enforce_if(straight)
        add(job.dock >= job.come + drive).only_enforce_if(straight)
        if origin == leg.fetch:
            add(job.come == ready).only_enforce_if(straight)
        if before is not None:
            add(before.left == job.come + drive).only_enforce_if(straight)
        for place, (chosen, there) in job.stop.items():
            both = [when, chosen]
            if place == origin or not self._shop.reaches(robot, place):
                self.model.add_bool_or([when.negated(), chosen.negated()])
                continue
            away = there + self._shop.drive(robot, origin, place)
            add(there >= ready).only_enforce_if(both)
            add(job.come >= away).only_enforce_if(both)
            add(job.dock >= job.come + self._shop.drive(robot, place, leg.fetch)).only_enforce_if(both)
            if before is not None:
                add(before.left == away).only_enforce_if(both)

    def _end(self, job: Job, robot: str, last: Var) -> None:
        """After its last leg the robot stays, or makes way once more."""
        leg = job.leg
        add = self.model.add
        stays = [last, *(chosen.negated() for chosen, _ in job.park.values())]
        add(job.left == self._horizon).only_enforce_if(stays)
        for place, (chosen, there) in job.park.items():
            self.model.add_implication(chosen, last).only_enforce_if(job.by[robot])
            if self._shop.reaches(robot, place):
                both = [last, chosen]
                away = there + self._shop.drive(robot, leg.deliver, place)
                add(there >= job.release + self._shop.releasing(leg)).only_enforce_if(both)
                add(job.left == away).only_enforce_if(both)
                add(self._makespan >= away).only_enforce_if(both)

    def _occupy(self, job: Job) -> None:
        """A place is not clear from the start of a move there to the end of the move away."""
        leg = job.leg
        self._interval(leg.area, leg.fetch, job.come, job.gone)
        self._interval(leg.area, leg.deliver, job.carry, job.left)
        for place, (chosen, there) in job.stop.items():
            robot = self._shop.robot(leg.area, place)
            self._stay(leg.area, place, there, job.come + self._shop.drive(robot, place, leg.fetch), chosen)
        for place, (chosen, there) in job.detour.items():
            self._stay(leg.area, place, there, job.carry + self._shop.haul(leg, place, leg.deliver), chosen)
        for place, (chosen, there) in job.park.items():
            self._stay(leg.area, place, there, self._horizon, chosen)

    def _stay(self, area: str, place: str, start: Var, end: cp_model.LinearExprT, when: Var) -> None:
        """A stop, where the place is a real one."""
        if place != ELSEWHERE:
            until = self._time("until")
            self.model.add(until == end).only_enforce_if(when)
            self._interval(area, place, start, until, when)

    def _interval(self, area: str, place: str, start: Var, end: Var, when: Var | None = None) -> None:
        size = self._time("size")
        if when is None:
            interval = self.model.new_interval_var(start, size, end, place)
        else:
            interval = self.model.new_optional_interval_var(start, size, end, when, place)
        self._occupied[area, place].append(interval)

    def _order_samples(self) -> None:
        """Legs of a sample in turn; a place is not vacant from the start of a release to the end of a docking."""
        filled: dict[str, list[cp_model.IntervalVar]] = defaultdict(list)
        ways: Mapping[str, list[Job]] = defaultdict(list)
        for job in self._jobs:
            ways[job.leg.sample].append(job)
        lying = list(self._shop.lies.values())
        for way in ways.values():
            for one, other in zip([None, *way], [*way, None], strict=True):
                start = one.release if one else self.model.new_constant(0)
                end = self._horizon if other is None else other.dock + self._shop.docking(other.leg)
                place = other.leg.fetch if other else way[-1].leg.deliver
                if one and other:
                    self.model.add(other.dock >= one.release + self._shop.releasing(one.leg))
                if one or lying.count(place) == 1:
                    size = self._time("lies")
                    filled[place].append(self.model.new_interval_var(start, size, end, place))
        for intervals in filled.values():
            self.model.add_no_overlap(intervals)

    def begin_with(self, solved: "Jobs", solver: cp_model.CpSolver) -> None:
        """Take the solution of the same jobs with other stops as a hint; its bound must hold for these, too."""
        self.model.add(self._makespan >= math.ceil(solver.best_objective_bound))
        flags = [(self._first[key], solved._first[key]) for key in self._first]
        flags += [(self._next[key], solved._next[key]) for key in self._next]
        for job, other in zip(self._jobs, solved._jobs, strict=True):
            flags += [(getattr(job, name), getattr(other, name)) for name in _TIMES]
        for mine, theirs in flags:
            self.model.add_hint(mine, solver.value(theirs))

    def timed(self, solver: cp_model.CpSolver) -> Iterator[tuple[float, float, GroundAction]]:
        """The solution's actions with their starts and ends, seconds."""
        for robot in (robot for robots in self._shop.robots.values() for robot in robots):
            number = next(
                (n for (r, n), first in self._first.items() if r == robot and solver.value(first)), None
            )
            place = self._shop.stands[robot]
            while number is not None:
                job = self._jobs[number]
                for start, action in self._done(solver, job, robot, place):
                    yield start / MILLISECONDS, (start + in_ms(action)) / MILLISECONDS, action
                place = job.leg.deliver
                number = next(
                    (
                        o
                        for (r, n, o), f in self._next.items()
                        if (r, n) == (robot, number) and solver.value(f)
                    ),
                    None,
                )

    def _done(
        self, solver: cp_model.CpSolver, job: Job, robot: str, place: str
    ) -> Iterator[tuple[int, GroundAction]]:
        shop = self._shop
        leg = job.leg
        at = solver.value
        stop, detour, park = (
            next(((p, at(there)) for p, (chosen, there) in what.items() if at(chosen)), None)
            for what in (job.stop, job.detour, job.park)
        )
        if stop:
            yield stop[1], shop.navigate(robot, place, stop[0])
            place = stop[0]
        if place != leg.fetch:
            yield at(job.come), shop.navigate(robot, place, leg.fetch)
        yield at(job.dock), shop.dock(robot, leg)
        rel = "at"
        place = leg.fetch
        if detour:
            yield detour[1], shop.transport(robot, leg, rel, place, detour[0])
            rel = "near"
            place = detour[0]
        yield at(job.carry), shop.transport(robot, leg, rel, place, leg.deliver)
        yield at(job.release), shop.release(robot, leg, rel, place)
        if park:
            yield park[1], shop.navigate(robot, leg.deliver, park[0])
