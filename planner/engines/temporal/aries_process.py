"""The process that runs Aries: reads the problem from the folder it is started in, writes plan files there."""

import os
import pickle
import sys
from pathlib import Path
from typing import Any

from planner.engines.temporal.aries import PROBLEM
from planner.engines.temporal.aries_compilation import AriesCompiler
from planner.engines.temporal.best_plan import Step
from planner.engines.temporal.plan_files import plan_file, text_of
from planner.interchange.up_import import import_unified_planning
from planner.knowledge import KnowledgeBase


def main(time_limit_s: float) -> None:
    import_unified_planning()
    from unified_planning.environment import get_environment
    from up_aries import Aries

    get_environment().credits_stream = None
    file, problem = pickle.loads(Path(PROBLEM).read_bytes())
    up_problem = AriesCompiler(KnowledgeBase(file), problem).run()
    with Aries() as aries:
        answers = aries.get_solutions(up_problem, timeout=time_limit_s)
        plans = (answer.plan for answer in answers if answer.plan is not None)
        for number, plan in enumerate(plans, start=1):
            _write(plan_file(Path(), number), plan)


def _write(file: Path, plan: Any) -> None:
    steps = [
        Step(
            start=float(start),
            duration=float(duration),
            operator=instance.action.name,
            objects=tuple(str(parameter) for parameter in instance.actual_parameters),
        )
        for start, instance, duration in plan.timed_actions
    ]
    draft = file.with_suffix(".new")
    draft.write_text(text_of(steps))
    os.replace(draft, file)


if __name__ == "__main__":
    main(float(sys.argv[1]))
