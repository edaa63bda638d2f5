"""A goal's tender as data: which legs robots were called for, who has bid what, and who is awarded what and why."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf

from pydantic import BaseModel, ConfigDict, Field

from app.domain.allocation import Award, TenderedLeg, allocate, without
from app.domain.blockers import Blockers
from app.domain.goal_language.words import joined
from app.domain.lifecycles.tender import TenderState
from robots.executive.offer import PASSING, Declining, Offer
from robots.wire import SymbolicFact


class Allocation(StrEnum):
    """How a goal's robots are chosen."""

    CENTRAL = "central"
    """By planning alone."""
    CONTRACT_NET = "contract_net"
    """Robots bid for the legs of a first plan, and the goal is planned with the cheapest bids' robots."""


class BidState(StrEnum):
    """What a robot has answered to a call."""

    OFFERED = "offered"
    """It bids."""
    DECLINED = "declined"
    """It bids not; it is not recruited for the leg."""
    SILENT = "silent"
    """It has not answered in time. That says nothing about the robot: it may be recruited where nobody bids."""
    UNCALLED = "uncalled"
    """It does not take calls. It may be recruited where nobody bids."""
    BUSY = "busy"
    """It bids from when it is free; until then a mission has reserved it."""
    WITHHELD = "withheld"
    """It bids, but planning does not recruit it: its role or a constraint stands against it, or it is unavailable."""


class OfferBody(BaseModel):
    """A robot's bid, by its own state and belief; seconds of the world's clock."""

    model_config = ConfigDict(from_attributes=True, frozen=True)

    cost_s: float = Field(description="what bids are compared by")
    release_s: float = Field(description="until it is free")
    way_s: float = Field(description="from where it is then to the first place, at least")
    work_s: float
    battery: float = Field(description="what is left afterwards, 0 to 1, at least")
    degraded: tuple[str, ...] = Field(default=(), description="readings that it leaves out")

    def offer(self) -> Offer:
        return Offer(**self.model_dump())


class BidBody(BaseModel):
    """What a robot has answered to the call for a part of a leg."""

    model_config = ConfigDict(frozen=True)

    robot: str
    state: BidState
    offer: OfferBody | None = None
    reason: str = Field(default="", description="why it has made no bid, or is not recruited")
    declining: Declining | None = Field(default=None, description="the kind of reason why it declines")
    outcome: str = Field(
        default="",
        description="of its conversation, as far as that is known still: proposed (not decided on), rejected, awarded, "
        "done, failed, refused, timed_out, not_understood or cancelled",
    )


class PartBody(BaseModel):
    """What one robot does of a leg."""

    model_config = ConfigDict(frozen=True)

    robot: str = Field(description="whose part it is in the first plan")
    tags: tuple[str, ...] = Field(description="of its actions")
    conversation: str = Field(description="the id of the conversations with those who were called")
    bids: tuple[BidBody, ...] = ()

    def offers(self, *, of_busy: Collection[str] = ()) -> Mapping[str, Offer]:
        """The bids that may be awarded, by robot. :param of_busy: robots whose bids count though missions need them."""
        return {
            bid.robot: bid.offer.offer()
            for bid in self.bids
            if bid.offer is not None
            and (bid.state is BidState.OFFERED or (bid.state is BidState.BUSY and bid.robot in of_busy))
        }

    @property
    def is_unheard(self) -> bool:
        """True if the robot that the first plan has for it has not answered, or takes no calls."""
        return any(
            bid.robot == self.robot and bid.state in (BidState.SILENT, BidState.UNCALLED) for bid in self.bids
        )


_NOT_RECRUITED = (BidState.DECLINED, BidState.BUSY, BidState.WITHHELD)
SAVED_S = 10.0
"""How much cheaper busy robots must make the dearest leg, at least, for a goal to wait for them (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Postponement:
    """Busy robots with which the dearest of a goal's legs is cheaper than without, though their missions come first.

    :param robots: by name, from now until each is free, by its bid, seconds.
    :param price_s: of the dearest leg with them. :param otherwise_s: without; None: too few robots bid for some leg.
    """

    robots: Mapping[str, float]
    price_s: float
    otherwise_s: float | None

    def __str__(self) -> str:
        names = joined(sorted(self.robots), last="and")
        asks = "asks" if len(self.robots) == 1 else "ask"
        free = "too few robots that are free bid"
        if self.otherwise_s is not None:
            free = f"robots that are free ask {self.otherwise_s:.0f} s"
        return f"{names} {asks} {self.price_s:.0f} s, {free}"


class LegBody(BaseModel):
    """A leg of the first plan: what a robot, or several together, do for a goal."""

    model_config = ConfigDict(frozen=True)

    id: str
    goal: SymbolicFact
    parts: tuple[PartBody, ...]
    team: tuple[str, ...] = Field(default=(), description="who is awarded it, a robot a part; empty: nobody")
    price_s: float | None = Field(default=None, description="what teams were compared by")
    why: str = ""
    failed: tuple[str, ...] = Field(
        default=(), description="robots that were awarded it and have not managed it"
    )
    is_planned: bool | None = Field(default=None, description="whether the plan has its team do it")

    def tendered(self, *, of_busy: Collection[str] = ()) -> TenderedLeg:
        parts = [part.offers(of_busy=of_busy) for part in self.parts]
        return without(TenderedLeg(id=self.id, parts=parts), self.failed)

    def candidates(self, robots: Collection[str]) -> frozenset[str]:
        """Who may be recruited for it: its team or, where nobody bids enough, who has not declined a part."""
        if self.team:
            return frozenset(self.team)
        declined = frozenset[str](robots).intersection(
            *({bid.robot for bid in part.bids if bid.state in _NOT_RECRUITED} for part in self.parts)
        )
        return frozenset(robots) - declined - set(self.failed)


class TenderBody(BaseModel):
    """A goal's tender (FIPA SC00029): the bids for the legs of its first plan, and the awards.

    :param attempt: the planning attempt of the goal that it belongs to.
    :param makespan_s: of the first plan; 0 of tenders of earlier versions.
    :param waits_until_s: by busy robot that the goal has been waiting for, until when it waits at the longest, seconds
        of the world's clock.
    """

    state: str = TenderState.CALLED.value
    reason: str = Field(default="", description="why the goal is planned without awards; empty if it is not")
    attempt: int = 0
    legs: tuple[LegBody, ...] = ()
    makespan_s: float = 0.0
    waits_until_s: Mapping[str, float] = Field(default_factory=dict)

    @property
    def conversations(self) -> tuple[str, ...]:
        return tuple(part.conversation for leg in self.legs for part in leg.parts)

    @property
    def has_bids(self) -> bool:
        return any(part.offers() for leg in self.legs for part in leg.parts)

    @property
    def declines(self) -> Sequence[str]:
        """Who has declined the legs that nobody is awarded, and why, in words."""
        return [f"{bid.robot} declines {leg.id}: {bid.reason}" for leg, bid in self._declined()]

    @property
    def passing(self) -> Blockers:
        """The robots that have declined legs that nobody is awarded, for reasons that may pass."""
        robots = {
            bid.robot: f"which declines {leg.id}: {bid.reason}"
            for leg, bid in self._declined()
            if bid.declining in PASSING
        }
        return Blockers(robots=robots)

    def _declined(self) -> Iterator[tuple[LegBody, BidBody]]:
        """The refusals of the legs that nobody is awarded."""
        for leg in self.legs:
            for part in leg.parts:
                for bid in part.bids:
                    if not leg.team and bid.state is BidState.DECLINED:
                        yield leg, bid

    def with_bids(self, bids: Mapping[str, Sequence[BidBody]]) -> "TenderBody":
        """:param bids: by conversation."""
        legs = tuple(
            leg.model_copy(
                update={
                    "parts": tuple(
                        part.model_copy(update={"bids": tuple(bids[part.conversation])}) for part in leg.parts
                    )
                }
            )
            for leg in self.legs
        )
        return self.model_copy(update={"legs": legs})

    def postponement(self, *, impatient: Collection[str] = (), within_s: float = inf) -> Postponement | None:
        """The busy robots that are worth waiting for; None if there are none.

        Nobody is waited for where a first plan's robot has not answered: how soon it would be done is not known.

        :param impatient: robots that are not waited for any longer. :param within_s: how long may be waited.
        """
        busy = {
            bid.robot: bid.offer.release_s
            for leg in self.legs
            for part in leg.parts
            for bid in part.bids
            if bid.state is BidState.BUSY and bid.offer is not None and bid.robot not in impatient
        }
        busy = {robot: release_s for robot, release_s in busy.items() if release_s <= within_s}
        if not busy or any(part.is_unheard for leg in self.legs for part in leg.parts):
            return None
        now = allocate([leg.tendered() for leg in self.legs])
        later = allocate([leg.tendered(of_busy=busy) for leg in self.legs])
        wanted = {robot: busy[robot] for award in later.values() for robot in award.team if robot in busy}
        price_s, otherwise_s = (_dearest_s(awards, len(self.legs)) for awards in (later, now))
        if not wanted or price_s is None or (otherwise_s is not None and otherwise_s < price_s + SAVED_S):
            return None
        return Postponement(robots=wanted, price_s=price_s, otherwise_s=otherwise_s)

    def allocated(self) -> "TenderBody":
        """With a team for each leg that enough robots bid for, by a sequential single-item auction."""
        awards = allocate([leg.tendered() for leg in self.legs])
        return self.model_copy(update={"legs": tuple(_awarded(leg, awards.get(leg.id)) for leg in self.legs)})

    def reallocated(self, has_failed: Callable[[LegBody, str], bool]) -> "TenderBody":
        """With the legs at which a robot has failed awarded to the next best bids; one without others keeps its team.

        :param has_failed: whether a robot of its team has failed at a leg.
        """
        legs = []
        for leg in self.legs:
            lost = tuple(robot for robot in leg.team if has_failed(leg, robot))
            now = leg.model_copy(update={"failed": tuple(dict.fromkeys((*leg.failed, *lost)))})
            award = allocate([now.tendered()]).get(leg.id) if lost else None
            legs.append(leg if award is None else _awarded(now, award))
        return self.model_copy(update={"legs": tuple(legs)})

    def without_awards(self) -> "TenderBody":
        legs = tuple(leg.model_copy(update={"team": (), "price_s": None, "why": ""}) for leg in self.legs)
        return self.model_copy(update={"legs": legs})

    def recruits(self, robots: Collection[str]) -> Mapping[SymbolicFact, frozenset[str]]:
        """By goal, who may be recruited for it, where not all may. :param robots: the world's."""
        found: dict[SymbolicFact, frozenset[str]] = {}
        for leg in self.legs:
            found[leg.goal] = found.get(leg.goal, frozenset()) | leg.candidates(robots)
        return {goal: those for goal, those in found.items() if len(those) < len(robots)}

    def as_planned(self, teams: Mapping[SymbolicFact, frozenset[str]]) -> "TenderBody":
        """:param teams: by goal, the robots of the plan's legs."""
        legs = tuple(
            leg.model_copy(
                update={
                    "is_planned": bool(leg.team) and teams.get(leg.goal, frozenset()).issuperset(leg.team)
                }
            )
            for leg in self.legs
        )
        return self.model_copy(update={"legs": legs})


def _dearest_s(awards: Mapping[str, Award], legs: int) -> float | None:
    """The price of the dearest leg; None if not all are awarded."""
    return max((award.price_s for award in awards.values()), default=0.0) if len(awards) == legs else None


def _awarded(leg: LegBody, award: Award | None) -> LegBody:
    if award is None:
        why = "too few robots bid for it; who has declined is not recruited" if leg.parts else ""
        return leg.model_copy(update={"team": (), "price_s": None, "why": why})
    return leg.model_copy(update={"team": award.team, "price_s": award.price_s, "why": _why(leg, award)})


def _why(leg: LegBody, award: Award) -> str:
    """Why this team, in words."""
    words = [
        f"{joined(award.team, last='and')} {'asks' if len(award.team) == 1 else 'ask'} {award.price_s:.0f} s"
    ]
    words += [
        f"of which {robot} is busy for {busy:.0f} s with earlier awards"
        for robot, busy in award.busy_s.items()
    ]
    if award.next_price_s is None:
        words.append("nobody else bids")
    else:
        words.append(f"the next best, {joined(award.next_team, last='and')}, {award.next_price_s:.0f} s")
    if leg.failed:
        words.append(f"{joined(leg.failed, last='and')} failed at it")
    return ", ".join(words)
