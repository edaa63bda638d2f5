"""The bodies of requests and answers; the plan body is in `app.domain.plan_document`."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, Any, Generic, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import from_json, to_json

from app.agents.running_world import WorldState
from app.api.parameters import Id, Name
from app.domain.goal_language.conflict_set import ConstraintConflict
from app.domain.goal_language.constraints import UNCONSTRAINED, Constraints
from app.domain.goal_language.kept_facts import HoldFact
from app.domain.goal_language.stated_holds import HoldEnd, StatedHold
from app.domain.goal_language.terms import GoalHold, GoalTerms, Reading
from app.domain.goal_language.times import Due
from app.domain.plan_document import PlanBody
from app.domain.plan_edits import MAX_EDITS, PlanEdit
from app.domain.recovery_rules import Policy
from app.domain.tender_document import Allocation
from app.planning.alternatives import Search
from app.store import GoalRow, PlanRow
from app.store.records import values_of
from planner import Objective
from robots.wire import FactsheetState, SymbolicFact
from robots.world.bodies import BodyKind

Item = TypeVar("Item")


class Request(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class StatedFact(SymbolicFact):
    """A fact as a client states it."""

    model_config = ConfigDict(extra="forbid")

    predicate: Name
    args: tuple[Name, ...] = Field(default=(), max_length=8)


Holds = Annotated[
    list[StatedHold],
    Field(
        max_length=100,
        description="places to keep empty and facts to keep true from now on; the goal brings about what is not so yet",
    ),
]


class SubmitGoal(Request):
    """A goal, either as a sentence or structured, or holds alone."""

    world: Name | None = Field(default=None, description="optional if only one world runs")
    text: str | None = Field(default=None, min_length=1, max_length=1000, examples=["move sample_1 to bay_7"])
    goal: list[StatedFact] | None = Field(default=None, min_length=1, max_length=100)
    constraints: Constraints = UNCONSTRAINED
    holds: Holds = []
    priority: int = Field(default=0, ge=-100, le=100)
    deadline_s: float | None = Field(default=None, gt=0, description="seconds from now, world's clock")
    not_before_s: float | None = Field(
        default=None, gt=0, description="the goal is not to be true earlier; seconds from now, world's clock"
    )
    auto_approve: bool = False
    recovery: Policy | None = Field(
        default=None,
        description="when the mission fails: approve repaired plans (auto), propose them (ask), or end (never); "
        "default: auto with auto_approve, else ask",
    )
    allocation: Allocation = Field(
        default=Allocation.CENTRAL,
        description="how its robots are chosen: by planning alone (central), or by bids of the robots for the legs of "
        "a first plan (contract_net)",
    )
    time_limit_s: float | None = Field(default=None, gt=0, description="for the planning, wall clock")
    effort_s: float | None = Field(
        default=None, ge=0, description="seconds to improve the first plan; default: by the problem's size"
    )
    objective: Objective = Objective.MAKESPAN

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        _refuse_both(self)
        return self


class CheckGoal(Request):
    """A sentence, also an incomplete one, or a structured goal."""

    world: Name | None = Field(default=None, description="optional if only one world runs")
    text: str | None = Field(default=None, max_length=1000, examples=["move sample_1 to"])
    goal: list[StatedFact] | None = Field(default=None, min_length=1, max_length=100)
    constraints: Constraints = UNCONSTRAINED
    holds: Holds = []

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        _refuse_both(self)
        return self


def _refuse_both(stated: SubmitGoal | CheckGoal) -> None:
    """:raises ValueError: if a request states its goal twice, or neither a goal nor a hold."""
    if (stated.text is None) == (stated.goal is None) and (stated.text is not None or not stated.holds):
        raise ValueError('give either "text" (a sentence) or "goal" (a list of facts), or "holds" alone')


class SetRecovery(Request):
    policy: Policy


class Decision(Request):
    comment: str = Field(default="", max_length=2000)


class Approval(Decision):
    delegate: bool = Field(
        default=False,
        description="robots in the field may put legs of the plan to each other while the service is out of reach",
    )


class FactChange(StatedFact):
    """A fact that is true or, with `value` false, not true."""

    value: bool = True


class CorrectFacts(Request):
    facts: list[FactChange] = Field(min_length=1, max_length=1000)
    comment: str = Field(default="", max_length=2000)


class StatedNumber(Request):
    """A numeric fact as a client states it."""

    quantity: Name = Field(examples=["battery"])
    args: tuple[Name, ...] = Field(min_length=1, max_length=8, examples=[["rover_1"]])
    value: float = Field(allow_inf_nan=False, strict=True, examples=[0.8])


class CorrectNumbers(Request):
    numbers: list[StatedNumber] = Field(min_length=1, max_length=1000)
    comment: str = Field(default="", max_length=2000)


class Page(BaseModel, Generic[Item]):
    items: list[Item]
    next: str | None = None


class PlanningProgress(BaseModel):
    """Progress of planning: the best makespan so far and the proven lower bound; or what it waits for."""

    engine: str
    elapsed_s: float
    makespan_s: float | None = None
    lower_bound_s: float | None = Field(default=None, description="no plan is shorter")
    waits_for: str = Field(
        default="", description="what must be before planning begins; empty once it has begun"
    )


class SeekAlternatives(Request):
    count: int = Field(default=4, ge=1, le=20, description="the most plans to find")


class EditPlan(Request):
    edits: list[PlanEdit] = Field(
        min_length=1, max_length=MAX_EDITS, examples=[[{"action": "a4", "robot": "yard_2"}]]
    )


MAX_JOINED_GOALS = 16
"""The most goals that are taken along at once when a mission is planned again."""


class Preview(Request):
    edits: list[PlanEdit] = Field(
        default=[],
        max_length=MAX_EDITS,
        description="of actions of the mission's plan; what they pin counts for its later plans, too",
        examples=[[{"action": "a4", "robot": "yard_2"}]],
    )
    goals: list[Id] = Field(
        default=[],
        max_length=MAX_JOINED_GOALS,
        description="that wait, and are to be carried out by the mission, too; without a plan for all of them it is "
        "planned without them",
        examples=[[]],
    )


class Replan(Decision, Preview):
    """As for a preview, with a comment."""


class AlternativesSearch(BaseModel):
    """State of the search for alternatives to the proposed plan, or of the editing of a plan."""

    state: Search
    count: int
    reason: str = ""
    edited: str | None = Field(default=None, description="the plan that is edited; null for a search")


class GoalBody(BaseModel):
    id: str
    world: str
    text: str
    goal: list[SymbolicFact]
    state: str
    reason: str
    outcome: str | None
    priority: int
    deadline_s: float | None
    deadline_at_s: float | None = Field(default=None, description="the deadline by the world's clock")
    not_before_at_s: float | None = Field(
        default=None, description="before when it is not to be true, by the world's clock"
    )
    constraints: Constraints = Field(
        default=UNCONSTRAINED, description="all of them, of the sentence and of the request"
    )
    conflict: ConstraintConflict | None = Field(
        default=None,
        description="of a goal without a plan, the smallest set of its constraints found to stand in the way; null if "
        "none are known to",
    )
    due: Due | None = Field(default=None, description="the deadline that the sentence states")
    readings: list[Reading] = Field(
        default_factory=list, description="what quantities and times of the sentence were resolved to"
    )
    holds: list[GoalHold] = Field(
        default_factory=list,
        description="the holds that it has begun; they stand until they end by themselves",
    )
    auto_approve: bool
    recovery: Policy
    allocation: Allocation
    planning: PlanningProgress | None = Field(default=None, description="only while it is being planned")
    alternatives: AlternativesSearch | None = Field(
        default=None, description="while plans are open, once alternatives were requested"
    )
    joint_goal: str | None = Field(
        default=None,
        description="the goal whose mission carries it out, too, or is to: one that the service has stated for several "
        "that waited, or that of a mission that was planned again with it",
    )
    plan_id: str | None
    mission_id: str | None
    created_by: str
    created_at: str
    updated_at: str

    @classmethod
    def of(cls, row: GoalRow) -> Self:
        return cls.model_validate(goal_document(row))


GOAL_FIELDS = tuple(GoalBody.model_fields)
OF_TERMS = ("constraints", "conflict", "due", "readings", "holds", "not_before_at_s")
"""What a goal's recorded terms hold of its body."""
_COLUMNS = tuple(name for name in GOAL_FIELDS if name not in OF_TERMS)


def goal_document(row: GoalRow) -> dict[str, Any]:
    """A `GoalBody` as data for JSON. Of what was validated when it was recorded nothing is validated again."""
    known: dict[str, Any] = dict(zip(_COLUMNS, values_of(row, _COLUMNS), strict=True))
    known |= _terms_document(to_json(row.terms))
    if (planning := known["planning"]) is not None:  # earlier versions recorded fewer fields
        known["planning"] = PlanningProgress.model_validate(planning).model_dump(mode="json")
    if (search := known["alternatives"]) is not None:
        known["alternatives"] = AlternativesSearch.model_validate(search).model_dump(mode="json")
    return {name: known[name] for name in GOAL_FIELDS}


@lru_cache(maxsize=1000)
def _terms_document(terms: bytes) -> Mapping[str, Any]:
    """What recorded terms, as JSON, hold of the body. Most goals have none."""
    return GoalTerms.from_json(from_json(terms)).model_dump(mode="json", include=set(OF_TERMS))


class CheckedIssue(BaseModel):
    """What is missing, not understood or impossible in a goal, as in the problem that submitting it would return."""

    model_config = ConfigDict(from_attributes=True)

    code: str
    detail: str
    thing: str
    choices: list[str]
    constraints: list[str] = Field(
        default_factory=list,
        description="the smallest set of constraints that cannot be kept together, each in words",
    )
    span: tuple[int, int] | None = Field(
        default=None, description="where in the sentence the thing is, start and end; or where it is missing"
    )


class CheckedHold(BaseModel):
    """A hold that the goal would begin."""

    model_config = ConfigDict(from_attributes=True)

    places: list[str]
    facts: list[HoldFact]
    until: HoldEnd
    words: str = Field(description="what it would do")


class CheckedPreference(BaseModel):
    """A constraint that a plan may break, and whether one can keep it at all."""

    model_config = ConfigDict(from_attributes=True)

    preference: str = Field(description="in words")
    cost_s: float = Field(description="what breaking it costs, in seconds of makespan")
    conflict: str = Field(description="why no plan can keep it; empty if one may")


class CheckedGoal(BaseModel):
    """How a sentence is understood in the present world."""

    model_config = ConfigDict(from_attributes=True)

    goals: list[SymbolicFact] = Field(description="empty if it is not understood")
    constraints: Constraints = UNCONSTRAINED
    deadline_s: float | None = Field(default=None, description="stated; seconds from now, world's clock")
    due: Due | None = Field(default=None, description="the deadline that the sentence states")
    readings: list[Reading] = Field(
        default_factory=list, description="what quantities and times of the sentence were resolved to"
    )
    holds: list[CheckedHold] = Field(default_factory=list, description="what it would keep, and until when")
    preferences: list[CheckedPreference] = Field(
        default_factory=list, description="what it prefers, and which of that cannot be kept"
    )
    issue: CheckedIssue | None = Field(description="null if the goal would be accepted")
    completions: list[str] = Field(description="complete sentences, the likeliest first")


def plan_body(row: PlanRow) -> PlanBody:
    """The stored plan body with the decision on it."""
    return PlanBody.model_validate({**row.body, **decision_on(row)})


def decision_on(row: PlanRow) -> dict[str, str | None]:
    """The part of a plan's body that changes after it was proposed."""
    return {
        "state": row.state,
        "reason": row.reason,
        "label": row.label,
        "comparison": row.comparison,
        "created_at": row.created_at,
        "comment": row.comment,
        "decided_by": row.decided_by,
        "decided_at": row.decided_at,
    }


class PlanChoice(BaseModel):
    """A plan among the others of its goal: what it is best at, and its figures."""

    id: str
    state: str
    label: str
    comparison: str
    makespan_s: float
    distance_m: float
    energy_j: float
    robots: list[str]
    clearances: int
    on_time: float | None = Field(
        description="probability that every deadline is kept if it starts now; null if there is none"
    )
    actions: int
    lanes: dict[str, list[tuple[float, float, str]]] = Field(
        description="what each robot does: start and end, seconds from the plan's start, and tag, in order"
    )

    @classmethod
    def of(cls, row: PlanRow, *, start_s: float | None = None) -> Self:
        """:param start_s: when it starts, by the world's clock; None: when it was to."""
        body = plan_body(row)
        likely = body.forecast if body.forecast is None else body.forecast.starting_at(start_s)
        made = {"actions", "robots", "lanes", "on_time"}
        plain = {name: getattr(body, name) for name in cls.model_fields if name not in made}
        lanes = {
            robot: sorted(
                (one.earliest_start_s, one.earliest_end_s, one.tag)
                for one in body.actions
                if robot in one.agents
            )
            for robot in body.robots
        }
        return cls(
            **plain,
            robots=list(body.robots),
            actions=len(body.actions),
            on_time=None if likely is None else likely.on_time,
            lanes=lanes,
        )


class PoseBody(BaseModel):
    x_m: float
    y_m: float
    heading_rad: float


class LostBody(BaseModel):
    """The declaration that a robot is lost; a `silent` one is used again once it is heard."""

    model_config = ConfigDict(from_attributes=True)

    since_s: float
    silent: bool
    declared_by: str
    declared_at: str
    comment: str


class OutOfServiceBody(BaseModel):
    """Why a robot is not recruited until it is brought back."""

    model_config = ConfigDict(from_attributes=True)

    since_s: float
    taken_by: str
    taken_at: str
    reason: str


class FactsheetBody(BaseModel):
    """What a robot has told of itself, and what has become of it."""

    model_config = ConfigDict(from_attributes=True)

    robot: str
    world: str
    number: int = Field(description="the robot's own; greater than that of an earlier one")
    state: FactsheetState
    reason: str = Field(description="why it is not in force")
    edition: int | None = Field(description="the edition of the world that it has made, if any")
    decided_by: str | None = Field(description="the operator who has admitted or refused the robot")
    at_s: float = Field(description="when it came, world's clock")
    came_at: str
    sheet: dict[str, Any] = Field(description="as the robot sent it")


class ImpersonationBody(BaseModel):
    """That somebody else publishes in the robot's name, as far as this process has noticed since its start."""

    model_config = ConfigDict(from_attributes=True)

    count: int = Field(description="messages that were dropped, or that contradict each other")
    reason: str = Field(description="of the last of them")
    at: str = Field(description="when the last came, wall clock")


class UnaskedBody(BaseModel):
    """That the robot does not understand status queries, so that it is not asked until it announces itself anew."""

    model_config = ConfigDict(from_attributes=True)

    reason: str = Field(description="its answer")
    noted_at: str = Field(description="since when, wall clock")


class RobotBody(BaseModel):
    id: str
    name: str
    world: str
    kind: str = Field(description="robot, door, hatch or lift")
    state: str = Field(default="", description="of a door or hatch: opened or closed; of a lift its level")
    connection: str
    world_stands: bool = Field(description="its simulated world stands at a breakpoint: it says nothing")
    last_heard_s: float | None = Field(description="seconds ago, wall clock")
    heard_at_s: float | None = Field(description="when it was last heard, world's clock")
    silent: bool = Field(description="not heard for longer than its radio model explains")
    next_contact_s: float = Field(
        description="world seconds until contact is expected, as far as is known beforehand; 0 while it is"
    )
    repertoire: list[str]
    reach: list[str]
    pose: PoseBody | None = None
    battery: float | None = None
    holding: str | None = None
    driven_by: str | None = Field(default=None, description="the operator who drives it by hand")
    packet: str | None = None
    packet_state: str | None = None
    mission_id: str | None = None
    script_id: str | None = None
    role: str | None = Field(
        default=None, description="that it plays, which may limit what it is recruited for"
    )
    body: BodyKind | None = Field(
        default=None, description="what kind of body its mind is in; null of a door, hatch or lift"
    )
    lost: LostBody | None = Field(default=None, description="set if the robot was declared lost")
    out_of_service: OutOfServiceBody | None = Field(
        default=None, description="set if the robot was taken out of service"
    )
    impersonation: ImpersonationBody | None = Field(
        default=None, description="set if somebody else publishes in its name"
    )
    unasked: UnaskedBody | None = Field(
        default=None, description="set if the robot does not understand status queries"
    )


class RobotDetailBody(RobotBody):
    """A robot with what it has told of itself."""

    senses: list[str] = Field(
        description="the predicates whose facts it senses of others' work, as it says or as its sensors perceive; what "
        "it does not sense it is told by clearance"
    )
    factsheet: FactsheetBody | None = Field(description="null if it has told nothing")
    dialogue_id: str | None = Field(description="the newest dialogue of a person with it that has not ended")


class WorldItem(BaseModel):
    id: str
    name: str
    title: str
    time_s: float
    version: int = Field(description="counts the changes of its facts")
    edition: int = Field(description="counts the changes of the world itself since its file")
    status: WorldState = Field(description="whether messages are exchanged with the world")
    status_detail: str = Field(description="what is waited for, or why it failed; empty if it runs")
    numbers_version: int = Field(description="counts the changes of its numeric facts")


class WorldBody(WorldItem):
    layout: dict[str, Any]


class DurationBody(BaseModel):
    """How long an action takes in a world, as a factor of what the knowledge base expects."""

    action: str
    robots: int = Field(description="size of the team that does it together")
    samples: int = Field(description="finished packets it was learned from; old ones lose weight")
    mean: float = Field(description="of actual to expected duration")
    spread: float = Field(description="standard deviation of the same, few samples drawn towards the prior")
    factor: float = Field(description="what plans multiply the duration by: few samples drawn towards 1")


class BelievedBody(SymbolicFact):
    """A fact that was believed, with its source and time (world's clock)."""

    source: str
    at_s: float


class FactBody(SymbolicFact):
    source: str
    at_s: float
    recorded_at: str
    instead_of: list[BelievedBody] = Field(
        default=[], description="what was believed before and is contradicted by this, newest first"
    )


class UnknownBody(BaseModel):
    """A sample or robot whose place or state is unknown."""

    name: str
    kind: Literal["sample", "robot"]
    reason: str
    since_s: float | None = Field(description="world's clock")
    last_believed: BelievedBody | None = Field(description="its last believed place and the source")
    earlier_believed: list[BelievedBody] = Field(
        default=[], description="where it was believed to be before that correction, newest first"
    )


class NumberBody(BaseModel):
    """A numeric fact with its source and time (world's clock)."""

    quantity: str
    args: tuple[str, ...]
    value: float
    unit: str = Field(description="`share`: 0 to 1")
    text: str = Field(description="in words", examples=["rover_1's battery is at 80 %"])
    counted: bool = Field(description="counted from the facts, which are to be corrected instead")
    source: str
    at_s: float
    recorded_at: str
    version: int = Field(description="of the numeric facts when it came to this value")


class NumbersBody(Page[NumberBody]):
    version: int = Field(description="counts the changes of numeric facts")


class FactsBody(Page[FactBody]):
    version: int
    edition: int = Field(description="of the world itself; its layout is another when this has increased")
    dropped: list[SymbolicFact] = Field(
        default=[], description="after a correction: the facts that contradicted it"
    )
