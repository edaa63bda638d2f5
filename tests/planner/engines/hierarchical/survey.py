"""A knowledge base of quite other actions: rovers that survey rocks, with roads, gates, tools and heavy boxes."""

from collections.abc import Iterable, Mapping

from planner import Fact, PlanningProblem

SURVEY = """
types:
  site: {}
  rover: {}
  gate: {}
  tool: {}
  rock: {}
  box: {}
functions:
  road_m: [site, site]
predicates:
  at: {arguments: {rover: rover, site: site}}
  road: {arguments: {one: site, other: site}}
  through: {arguments: {gate: gate, one: site, other: site}}
  open: {arguments: {gate: gate}, sensed: true}
  lies: {arguments: {tool: tool, site: site}, sensed: true}
  free: {arguments: {rover: rover}}
  holds: {arguments: {rover: rover, tool: tool}}
  camera: {arguments: {tool: tool}}
  seen_from: {arguments: {rock: rock, site: site}}
  charged: {arguments: {rover: rover}}
  charger: {arguments: {site: site}}
  photographed: {arguments: {rock: rock}}
  warm: {arguments: {tool: tool}}
  stands: {arguments: {box: box, site: site}, sensed: true}
  strong: {arguments: {rover: rover}}
actions:
  - identifier: 1
    name: DRIVE
    parameters: [{name: rover, type: rover}, {name: one, type: site}, {name: other, type: site}]
    agents: [rover]
    preconditions: ["at(rover, one)", "road(one, other)"]
    delete: ["at(rover, one)"]
    intended_effects: ["at(rover, other)"]
    other_effects: []
    duration: road_m(one, other) / 2
    description: "{rover} drive from {one} to {other}"
  - identifier: 2
    name: PASS
    parameters:
      [{name: rover, type: rover}, {name: gate, type: gate}, {name: one, type: site}, {name: other, type: site}]
    agents: [rover]
    preconditions: ["at(rover, one)", "through(gate, one, other)", "open(gate)"]
    delete: ["at(rover, one)"]
    intended_effects: ["at(rover, other)"]
    other_effects: []
    duration: "4"
    description: "{rover} pass {gate} from {one} to {other}"
  - identifier: 3
    name: OPEN
    parameters:
      [{name: rover, type: rover}, {name: gate, type: gate}, {name: one, type: site}, {name: other, type: site}]
    agents: [rover]
    preconditions: ["at(rover, one)", "through(gate, one, other)", "free(rover)"]
    delete: []
    intended_effects: ["open(gate)"]
    other_effects: []
    duration: "6"
    description: "{rover} open {gate} at {one}, towards {other}"
  - identifier: 4
    name: TAKE
    parameters: [{name: rover, type: rover}, {name: tool, type: tool}, {name: site, type: site}]
    agents: [rover]
    preconditions: ["at(rover, site)", "lies(tool, site)", "free(rover)"]
    delete: ["lies(tool, site)", "free(rover)"]
    intended_effects: ["holds(rover, tool)"]
    other_effects: []
    duration: "3"
    description: "{rover} take {tool} at {site}"
  - identifier: 5
    name: DROP
    parameters: [{name: rover, type: rover}, {name: tool, type: tool}, {name: site, type: site}]
    agents: [rover]
    preconditions: ["at(rover, site)", "holds(rover, tool)"]
    delete: ["holds(rover, tool)"]
    intended_effects: ["free(rover)", "lies(tool, site)"]
    other_effects: []
    duration: "3"
    description: "{rover} drop {tool} at {site}"
  - identifier: 6
    name: PHOTOGRAPH
    parameters:
      [{name: rover, type: rover}, {name: rock, type: rock}, {name: tool, type: tool}, {name: site, type: site}]
    agents: [rover]
    preconditions: ["at(rover, site)", "seen_from(rock, site)", "holds(rover, tool)", "camera(tool)", "charged(rover)"]
    delete: ["charged(rover)"]
    intended_effects: ["photographed(rock)"]
    other_effects: ["warm(tool)"]
    duration: "5"
    description: "{rover} photograph {rock} with {tool} from {site}"
  - identifier: 7
    name: CHARGE
    parameters: [{name: rover, type: rover}, {name: site, type: site}]
    agents: [rover]
    preconditions: ["at(rover, site)", "charger(site)"]
    delete: []
    intended_effects: ["charged(rover)"]
    other_effects: []
    duration: "20"
    description: "{rover} charge at {site}"
  - identifier: 8
    name: CARRY
    parameters:
      - {name: box, type: box}
      - {name: rovers, type: rover, teams: [2]}
      - {name: one, type: site}
      - {name: other, type: site}
    agents: [rovers]
    preconditions: ["at(rovers, one)", "free(rovers)", "strong(rovers)", "stands(box, one)", "road(one, other)"]
    delete: ["at(rovers, one)", "stands(box, one)"]
    intended_effects: ["stands(box, other)", "at(rovers, other)"]
    other_effects: []
    duration: road_m(one, other)
    description: "{rovers} carry {box} from {one} to {other}"
"""

ROADS = ("base", "fork", "north", "ridge", "summit")
"""A road from site to site; a gate between fork and north stands in the way."""


def survey(
    goals: Iterable[Fact],
    *,
    rovers: Mapping[str, str],
    strong: Iterable[str] = (),
    charged: Iterable[str] = (),
    tools: Mapping[str, str] | None = None,
    open_gate: bool = False,
    branches: int = 0,
) -> PlanningProblem:
    """Roads base - fork =gate= north - ridge - summit, and `branches` dead ends off the fork.

    :param rovers: each rover's site. :param tools: each tool's site; all are cameras but the spade.
    """
    lying = {"camera": "base", "spade": "fork"} if tools is None else tools
    pairs = [("base", "fork"), ("north", "ridge"), ("ridge", "summit")]
    pairs += [("fork", f"branch_{n}") for n in range(branches)]
    objects = dict.fromkeys((*ROADS, *(f"branch_{n}" for n in range(branches))), "site")
    objects |= {"gate": "gate", "rock": "rock", "box": "box"}
    objects |= dict.fromkeys(rovers, "rover") | dict.fromkeys(lying, "tool")
    facts = {Fact("at", (rover, site)) for rover, site in rovers.items()}
    facts |= {Fact("free", (rover,)) for rover in rovers}
    facts |= {Fact("strong", (rover,)) for rover in strong}
    facts |= {Fact("charged", (rover,)) for rover in charged}
    facts |= {Fact("lies", (tool, site)) for tool, site in lying.items()}
    facts |= {Fact("camera", (tool,)) for tool in lying if tool != "spade"}
    facts |= {Fact("road", pair) for one, other in pairs for pair in ((one, other), (other, one))}
    facts |= {Fact("through", ("gate", *pair)) for pair in (("fork", "north"), ("north", "fork"))}
    facts |= {
        Fact("seen_from", ("rock", "summit")),
        Fact("charger", ("base",)),
        Fact("stands", ("box", "base")),
    }
    if open_gate:
        facts.add(Fact("open", ("gate",)))
    lengths = {("road_m", pair): 10.0 for one, other in pairs for pair in ((one, other), (other, one))}
    return PlanningProblem(objects=objects, facts=frozenset(facts), goals=tuple(goals), functions=lengths)
