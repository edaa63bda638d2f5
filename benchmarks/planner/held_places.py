"""What it costs that places are held from start to end: `python -m benchmarks.planner.held_places store:16 mixed:16`.

Each instance (family:samples) is planned with the shipped knowledge base and with one whose drives hold the place they
leave and the one they go to for two seconds. Every plan-net is executed a hundred times with random durations.
"""

import argparse
import time
from collections.abc import Sequence

from benchmarks.planner.check import fault_of
from benchmarks.planner.instances import FAMILIES
from benchmarks.planner.timed_store import timed_store
from planner import KnowledgeBase, PlanningRequest, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine

EXECUTIONS = 100


def row(family: str, samples: int, seed: int, knowledge_base: KnowledgeBase) -> str:
    """Makespan, bound, CPU seconds and the fault of one plan."""
    problem = FAMILIES[family](samples, seed).problem(knowledge_base)
    began_s = time.process_time()
    request = PlanningRequest(clock=time.process_time)  # a shared machine takes nothing from the effort
    result = HierarchicalEngine(knowledge_base).plan(problem, request)
    spent_s = time.process_time() - began_s
    if result.plan_net is None:
        return f"{result.status.value}: {result.reason}"
    fault = fault_of(result.plan_net, problem, knowledge_base, executions=EXECUTIONS)
    return (
        f"{result.plan_net.makespan_s:8.1f} s, bound {result.lower_bound_s or 0.0:6.1f} s, "
        f"{result.plan_net.clearances:3d} clearances, {spent_s:5.1f} s CPU, {fault or 'no fault'}"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.planner.held_places", description=__doc__)
    parser.add_argument("instances", nargs="+", metavar="FAMILY:SAMPLES")
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args(arguments)
    bases = {"start to end": load_knowledge_base(), "while used": timed_store()}
    for base in bases.values():
        HierarchicalEngine(base).warm_up()
        row("paper", 1, 0, base)
    for family, _, samples in (one.partition(":") for one in options.instances):
        for seed in range(options.seeds):
            for name, base in bases.items():
                print(f"{family} {samples}, seed {seed}, {name:12}:", row(family, int(samples), seed, base))


if __name__ == "__main__":
    main()
