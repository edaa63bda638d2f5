"""What is known of the facts that a hold keeps: which have been true, and which have ceased to be."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from pydantic import BaseModel, ConfigDict, Field

from app.domain.goal_language.kept_facts import HoldFact, believed_now, is_kept_true
from app.domain.world_model.beliefs import Facts
from robots.world import WorldFile


class LostFact(BaseModel):
    """A fact that a hold keeps and that has ceased to be true."""

    model_config = ConfigDict(frozen=True)

    fact: HoldFact
    now: str = Field(description="what is believed instead, in words")
    number: int = Field(description="the number of the loss among those of its hold, from 1")
    goal: str | None = Field(default=None, description="the goal that is to bring it about again")
    reason: str = Field(default="", description="why there is no such goal")

    @property
    def is_unanswered(self) -> bool:
        """True if no goal was submitted for it, nor refused."""
        return self.goal is None and not self.reason


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptRecord:
    """What is known of the facts that a hold keeps.

    :param achieved: those that have been true since it began.
    :param lost: those of them that are not true any longer.
    :param losses: the number of the newest loss.
    """

    achieved: tuple[HoldFact, ...] = ()
    lost: tuple[LostFact, ...] = ()
    losses: int = 0

    def observe(
        self, kept: Sequence[HoldFact], world: WorldFile, facts: Facts, *, in_work: Collection[HoldFact]
    ) -> "KeptRecord":
        """The record once these facts are believed.

        What a goal has yet to bring about, or to bring about again, does not count as true while its mission runs: a
        robot may only pass the place. What is lost, and for which no goal could be submitted, is a new loss once it is
        believed to be elsewhere.

        :param in_work: the facts that a running mission brings about.
        """
        achieved = list(self.achieved)
        lost = {one.fact: one for one in self.lost}
        losses = self.losses
        for fact in kept:
            if is_kept_true(fact, world, facts):
                if fact not in in_work:
                    lost.pop(fact, None)
                    achieved.extend([fact] if fact not in achieved else [])
                continue
            now = believed_now(fact, facts)
            before = lost.get(fact)
            if fact not in achieved or (before is not None and before.now == now):
                continue
            if before is not None and not before.reason:
                lost[fact] = before.model_copy(update={"now": now})
                continue
            losses += 1
            lost[fact] = LostFact(fact=fact, now=now, number=losses)
        return KeptRecord(achieved=tuple(achieved), lost=tuple(lost.values()), losses=losses)

    def answered(self, number: int, *, goal: str | None = None, reason: str = "") -> "KeptRecord":
        """The record once a goal was submitted for the loss of this number, or refused for a reason."""
        return replace(
            self,
            lost=tuple(
                one.model_copy(update={"goal": goal, "reason": reason}) if one.number == number else one
                for one in self.lost
            ),
        )
