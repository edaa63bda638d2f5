"""The figures as tables: what each planner solved, how good its plans are, how long it took."""

from collections.abc import Callable, Iterable, Sequence
from statistics import geometric_mean, median

from benchmarks.domains.measure import Measure, Task

Key = tuple[str, str, int, int]


def best_by_problem(measures: Iterable[Measure]) -> dict[Key, float]:
    """The best quality that any planner found for each problem."""
    best: dict[Key, float] = {}
    for one in measures:
        if one.is_solved and one.best is not None:
            best[key(one.task)] = min(one.best, best.get(key(one.task), one.best))
    return best


def key(task: Task) -> Key:
    return task.domain, task.form.value, task.size, task.seed


def score(value: float | None, best: float | None) -> float:
    """Quality as planning competitions count it: the best known divided by one's own, 0 without a plan."""
    if value is None or best is None:
        return 0.0
    return best / value if value else 1.0


def by_domain(measures: Sequence[Measure], planners: Sequence[str]) -> list[str]:
    """A row a domain and form: solved, and the quality of the last plan over the best known, geometric mean."""
    best = best_by_problem(measures)

    def cell(mine: list[Measure]) -> str:
        solved = [one for one in mine if one.is_solved]
        said = f"{len(solved)} of {len(mine)}"
        ratio = _ratio(solved, best)
        return f"{said}, {ratio:.2f}" if ratio is not None else said

    rows = list(dict.fromkeys((one.task.domain, one.task.form.value) for one in measures))
    return _table(
        ("domain", "form", *planners),
        [
            [
                *row,
                *(
                    cell(mine) if (mine := [m for m in measures if _is_of(m, planner, row)]) else "–"
                    for planner in planners
                ),
            ]
            for row in rows
        ],
    )


def _is_of(measure: Measure, planner: str, row: tuple[str, str]) -> bool:
    task = measure.task
    return task.planner == planner and (task.domain, task.form.value) == row


def _ratio(solved: Sequence[Measure], best: dict[Key, float]) -> float | None:
    known = [one.best / best[key(one.task)] for one in solved if one.best and best[key(one.task)]]
    return geometric_mean(known) if known else None


def summary(measures: Sequence[Measure], planners: Sequence[str]) -> list[str]:
    """A row a form and planner, over all domains."""
    best = best_by_problem(measures)
    rows = []
    for form in dict.fromkeys(one.task.form for one in measures):
        for planner in planners:
            mine = [one for one in measures if (one.task.planner, one.task.form) == (planner, form)]
            if not mine:
                continue
            solved = [one for one in mine if one.is_solved]
            scores = [
                sum(
                    score(getattr(one, name) if one.is_solved else None, best.get(key(one.task)))
                    for one in mine
                )
                for name in ("first", "best")
            ]
            ratio = _ratio(solved, best)
            rows.append(
                [
                    form.value,
                    planner,
                    f"{len(solved)} of {len(mine)}",
                    *(f"{value:.1f}" for value in scores),
                    "–" if ratio is None else f"{ratio:.2f}",
                    _middle(solved, lambda one: one.first_s),
                    _middle(solved, lambda one: one.best_s),
                    _middle(mine, lambda one: one.final_s),
                    _middle(mine, lambda one: one.cpu_s),
                ]
            )
    head = ("form", "planner", "solved", "score of the first plans", "of the best", "best over best known")
    return _table((*head, "first, s", "best, s", "end, s", "CPU, s"), rows)


def _middle(measures: Iterable[Measure], value: Callable[[Measure], float | None]) -> str:
    known = [number for one in measures if (number := value(one)) is not None]
    return f"{median(known):.2f}" if known else "–"


def faults(measures: Iterable[Measure]) -> list[str]:
    """The planners whose plans are not valid, and where."""
    return [f"INVALID: {name(one.task)}: {one.rejected} plans: {one.fault}" for one in measures if one.fault]


def name(task: Task) -> str:
    return f"{task.domain} {task.form.value} {task.size} seed {task.seed}, {task.planner}"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """In Markdown."""
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]
