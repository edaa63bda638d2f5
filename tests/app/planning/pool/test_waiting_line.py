"""Which work is next when a planning process is free."""

from app.planning.pool.waiting_line import Job, Priority, Ticket, WaitingLine, is_large

GOAL = Priority.GOAL


def line_of(*jobs: Job) -> WaitingLine[str]:
    line = WaitingLine[str]()
    for job in jobs:
        line.join(Ticket(job))
    return line


def order(line: WaitingLine[str]) -> list[Job]:
    """The jobs in the order in which they are taken."""
    taken = []
    while ticket := line.next(lambda _: True):
        taken.append(ticket.job)
    return taken


def test_repairs_come_before_goals_then_explanations_then_alternatives() -> None:
    jobs = [Job(world="store", priority=priority) for priority in reversed(Priority)]
    assert [job.priority for job in order(line_of(*jobs))] == [
        Priority.RECOVERY,
        Priority.GOAL,
        Priority.EXPLANATION,
        Priority.ALTERNATIVES,
    ]


def test_worlds_take_turns_however_many_jobs_one_has() -> None:
    line = line_of(*(Job(world=world) for world in "aaaabbc"))
    assert "".join(job.world for job in order(line)) == "abcabaa"


def test_a_world_that_had_a_turn_long_ago_is_before_one_that_had_it_recently() -> None:
    line = line_of(Job(world="a"), Job(world="b"))
    order(line)
    for world in "ba":
        line.join(Ticket(Job(world=world)))
    assert [job.world for job in order(line)] == ["a", "b"]


def test_jobs_of_one_world_are_taken_in_the_order_of_arrival() -> None:
    tickets = [Ticket[str](Job(world="a")) for _ in range(3)]
    line = WaitingLine[str]()
    for ticket in tickets:
        line.join(ticket)
    line.leave(tickets[0])
    line.leave(tickets[0])
    assert line.next(lambda _: True) is tickets[1]
    assert line.next(lambda _: True) is tickets[2]


def test_work_that_may_not_begin_lets_others_pass() -> None:
    large = Job(world="a", is_large=True)
    line = line_of(large, Job(world="a"))
    assert line.any(lambda ticket: not ticket.job.is_large)
    small = line.next(lambda ticket: not ticket.job.is_large)
    assert small is not None
    assert not small.job.is_large
    assert line.next(lambda ticket: not ticket.job.is_large) is None
    assert line.counts() == {large: 1}


def test_a_problem_is_large_by_its_goals_or_by_the_effort_requested() -> None:
    assert not is_large(goals=8, effort_s=None)
    assert is_large(goals=9, effort_s=None)
    assert is_large(goals=1, effort_s=60.0)
