"""One run of the behavioural agent down the corridor, with its trace."""

from dataclasses import dataclass, field
from functools import partial

from robots.physical.profile import Architecture
from robots.wire import Message, Performative, ScriptReport, ScriptRequest, ScriptState, Telemetry
from sim.clock import TICKS_PER_CONTROL
from sim.trials.interference.corridor import ROBOT, SONAR_MAX_M, corridor, get_in_kitchen, repertoire
from sim.trials.interference.interferer import Interference, Interferer, Kind
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

TIMEOUT_S = 600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Instant:
    """Sonar: least of the three beams ahead, metres, 0 while off. Bumper: 2 touched, 1 not, 0 off (P-SMPA §6.1)."""

    time_s: float
    sonar_m: float
    bumper: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """The result of one run. `time_s` is the time to the door; `arrived` is False if the robot gave up."""

    arrived: bool
    time_s: float
    interferences: tuple[Interference, ...]
    trace: tuple[Instant, ...] = field(repr=False)
    sensing_j: float
    saved_j: float

    @property
    def detected(self) -> int:
        return sum(one.detected for one in self.interferences)


def run_trial(kind: Kind, times: int, architecture: Architecture, seed: int) -> Trial:
    """One seed of one cell of table 1. The same arguments give a bit-identical trial."""
    make_agent = partial(behavioural_agent, repertoire=repertoire())
    simulation = Simulation(corridor(architecture), make_agent=make_agent, seed=seed, jitter_m=0.0)
    try:
        return _run(simulation, Interferer(simulation, kind, times, seed))
    finally:
        simulation.close()


def _run(simulation: Simulation, interferer: Interferer) -> Trial:
    request = ScriptRequest(script=get_in_kitchen(TIMEOUT_S))
    simulation.link.send(
        Message(
            performative=Performative.REQUEST, sender="service", receiver=ROBOT, sent_at_s=0.0, body=request
        )
    )
    trace: list[Instant] = []
    telemetry = Telemetry(at_s=0.0, x_m=0.0, y_m=0.0, heading_rad=0.0)
    ended: ScriptReport | None = None
    while ended is None:
        interferer.act()
        for _ in range(TICKS_PER_CONTROL):
            simulation.step()
            interferer.note_contact()
        interferer.note_detection()
        trace.append(_instant(simulation))
        for message in simulation.link.receive():
            if isinstance(message.body, Telemetry):
                telemetry = message.body
            elif isinstance(message.body, ScriptReport):
                ended = message.body
    return Trial(
        arrived=ended.state is ScriptState.FINISHED,
        time_s=ended.at_s,
        interferences=tuple(interferer.done),
        trace=tuple(trace),
        sensing_j=telemetry.sensing_j,
        saved_j=telemetry.sensing_saved_j,
    )


def _instant(simulation: Simulation) -> Instant:
    readings = simulation.bodies[ROBOT].sense()
    ahead = () if readings.ranges_m is None else readings.ranges_m[[-1, 0, 1]]
    return Instant(
        time_s=readings.time_s,
        sonar_m=float(min(min(ahead, default=0.0), SONAR_MAX_M)),
        bumper=0 if readings.bumper is None else 1 + readings.bumper,
    )
