"""Legs re-awarded in the field: `python -m benchmarks.delegation [--seeds N]`.

yard_1 is to bring sample_1 to an interchange, from where store_2 takes it to bay_7; the jaws of yard_1 are jammed, and
yard_2 stands idle. What stands for the service gives the scripts and is cut off for good 1 s later. A row a condition:
missions whose robots have ended their scripts with the sample in place, the time, and messages between robots.
"""

import argparse
import statistics
from collections.abc import Mapping
from dataclasses import dataclass

from app.domain.mission_organiser import Organised, load_library, organise
from robots.wire import BehaviourScript, ScriptState
from robots.world import LinkSpec, WorldFile, load_world
from sim.trials.script_runner import ScriptRunner
from tests.app.sample_store import Store

LIMIT_S = 400.0
CUT = {"outages": [{"start_s": 1.0, "end_s": 1e6}]}
BAD = LinkSpec(loss=0.3, delay_s=0.2, jitter_s=2.0, duplication=0.2)
CONDITIONS: Mapping[str, tuple[bool, LinkSpec]] = {
    "not granted": (False, LinkSpec()),
    "granted": (True, LinkSpec()),
    "granted, robots hear each other badly": (True, BAD),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a mission ended. `took_s`: by the world's clock; `letters`: messages between robots."""

    came_true: bool
    took_s: float
    letters: int


def with_jammed_jaws(world: WorldFile, name: str) -> WorldFile:
    """The world with a robot whose jaws never close on what it is to grip."""
    tuning = {"DOCK": {"grip/grip": {"u.value": 0.0}}}
    robots = tuple(
        robot.model_copy(update={"tuning": tuning}) if robot.name == name else robot for robot in world.robots
    )
    return WorldFile.model_validate(world.model_copy(update={"robots": robots}).model_dump())


def scripts_of(world: WorldFile, *, delegate: bool) -> tuple[BehaviourScript, ...]:
    """The mission's scripts, organised as the service does."""
    store = Store(world)
    organised = organise(
        store.store_sample_1(),
        load_library(store.base),
        store.repertoires,
        "mission",
        store.base,
        facts=store.facts,
        clearing=world.clearing,
        delegating=world.delegating if delegate else (),
    )
    assert isinstance(organised, Organised), organised
    return organised.scripts


def carry_out(peer_link: LinkSpec, seed: int, *, delegate: bool) -> Ended:
    """Carry the mission out with the uplink cut."""
    radio = {"link": LinkSpec.model_validate(CUT), "peer_link": peer_link}
    world = with_jammed_jaws(load_world("sample_store").model_copy(update=radio), "yard_1")
    scripts = scripts_of(world, delegate=delegate)
    with ScriptRunner(world, seed=seed) as runner:
        runner.send(scripts)
        simulation = runner.simulation

        def states() -> list[ScriptState | None]:
            known: dict[str, ScriptState] = {}
            for agent in simulation.agents.values():
                known |= agent.memory().mind.executive.states  # type: ignore[attr-defined]
            return [known.get(script.id) for script in scripts]

        over = (ScriptState.FINISHED, ScriptState.FAILED)
        while simulation.clock.now_s() < LIMIT_S and not all(state in over for state in states()):
            simulation.run_until(lambda: False, timeout_s=5.0)
        in_place = simulation.truth().samples["sample_1"].ref == "bay_7"
        return Ended(
            came_true=in_place and set(states()) == {ScriptState.FINISHED},
            took_s=simulation.clock.now_s(),
            letters=simulation.hub.peer_letters,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=10, help="missions a condition")
    seeds = parser.parse_args().seeds
    print(f"{'condition':38} {'completed':>10} {'took s':>7} {'messages':>9}")
    for name, (delegate, link) in CONDITIONS.items():
        ended = [carry_out(link, seed, delegate=delegate) for seed in range(seeds)]
        done = [one for one in ended if one.came_true]
        took = f"{statistics.median(one.took_s for one in done):7.0f}" if done else "      -"
        letters = statistics.mean(one.letters for one in ended)
        print(f"{name:38} {len(done):4} of {seeds:2} {took} {letters:9.1f}", flush=True)


if __name__ == "__main__":
    main()
