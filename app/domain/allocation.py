"""Who is awarded which leg of a plan: a sequential single-item auction of bids, with teams for joint legs.

Leg after leg goes to the team of bidders that is cheapest then (Koenig et al. 2006, "The power of sequential
single-item auctions for agent coordination"), each robot's earlier awards counting as time in which it is busy. Robots
bid once, for each leg by itself: what the way between two of its legs takes is left to planning.
"""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import prod

from robots.executive.offer import Offer

MOST_TEAMS = 2000
"""Teams of one leg that are compared; of more, only those of the cheapest bidders for each part are (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TenderedLeg:
    """A leg that robots were called for.

    :param parts: for each robot that the leg takes, the offers for its part, by bidder.
    """

    id: str
    parts: Sequence[Mapping[str, Offer]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Award:
    """A leg's team, one robot a part.

    :param price_s: what teams were compared by, seconds.
    :param busy_s: by robot, the time that its earlier awards take; robots without any are left out.
    :param next_team: the next best one of other robots at that point, if there was one, and its price.
    """

    leg: str
    team: tuple[str, ...]
    price_s: float
    busy_s: Mapping[str, float] = field(default_factory=dict)
    next_team: tuple[str, ...] = ()
    next_price_s: float | None = None


def allocate(legs: Sequence[TenderedLeg]) -> Mapping[str, Award]:
    """The awards by leg; a leg without enough bidders has none."""
    busy_s: dict[str, float] = defaultdict(float)
    awards: dict[str, Award] = {}
    left = list(legs)
    while left:
        priced = [(leg, _ranked(leg, busy_s)) for leg in left]
        open_legs = [(teams[0], place, leg, teams) for place, (leg, teams) in enumerate(priced) if teams]
        if not open_legs:
            break
        (price_s, team), _, leg, teams = min(open_legs, key=lambda one: (one[0][0], one[1]))
        rivals = ((cost_s, other) for cost_s, other in teams if set(other) != set(team))
        other_s, others = next(rivals, (None, ()))
        awards[leg.id] = Award(
            leg=leg.id,
            team=team,
            price_s=round(price_s, 3),
            busy_s={robot: round(busy_s[robot], 3) for robot in team if busy_s.get(robot)},
            next_team=others,
            next_price_s=None if other_s is None else round(other_s, 3),
        )
        for robot, part in zip(team, leg.parts, strict=True):
            busy_s[robot] += part[robot].way_s + part[robot].work_s
        left.remove(leg)
    return awards


def price_of(offers: Sequence[Offer], busy_s: Sequence[float]) -> float:
    """What a team asks for a leg, seconds.

    The members begin once the last of them is there and work together; what else their bids count, such as charging
    afterwards, is added up. Of one robot it is the cost of its bid and the time in which it is busy.
    """
    there_s = max(busy + offer.release_s + offer.way_s for busy, offer in zip(busy_s, offers, strict=True))
    rest_s = sum(offer.cost_s - offer.release_s - offer.way_s - offer.work_s for offer in offers)
    return there_s + max(offer.work_s for offer in offers) + rest_s


def without(leg: TenderedLeg, robots: Collection[str]) -> TenderedLeg:
    """The leg without what these robots have bid."""
    parts = [{robot: offer for robot, offer in part.items() if robot not in robots} for part in leg.parts]
    return TenderedLeg(id=leg.id, parts=parts)


def _ranked(leg: TenderedLeg, busy_s: Mapping[str, float]) -> list[tuple[float, tuple[str, ...]]]:
    """The prices of all teams, least first; of equal ones by name."""
    parts = [
        [
            robot
            for _, robot in sorted(
                (offer.cost_s + busy_s.get(robot, 0.0), robot) for robot, offer in part.items()
            )
        ]
        for part in leg.parts
    ]
    most = max((len(part) for part in parts), default=0)
    while prod(len(part[:most]) for part in parts) > MOST_TEAMS:
        most -= 1
    return sorted(
        (
            price_of(
                [part[robot] for part, robot in zip(leg.parts, team, strict=True)],
                [busy_s.get(robot, 0.0) for robot in team],
            ),
            team,
        )
        for team in product(*(part[:most] for part in parts))
        if len(set(team)) == len(team)
    )
