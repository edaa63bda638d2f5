"""What an agent tells of itself when its mind is read, of bounded size."""

from itertools import islice

from robots.deliberative.actuators import Utterance
from robots.deliberative.agent import Agent
from robots.deliberative.beliefs import Belief
from robots.deliberative.commitments import Commitment
from robots.deliberative.terms import shown
from robots.deliberative.vocabulary import ROLE
from robots.wire import (
    MAX_TOLD_BINDINGS,
    MAX_TOLD_CHARACTERS,
    ToldAgent,
    ToldBelief,
    ToldCommitment,
    ToldMessage,
)


def told_agent(agent: Agent, most: int) -> ToldAgent:
    """The agent's beliefs and commitments, at most so many of each."""
    beliefs = list(agent.beliefs)
    commitments = [*agent.commitments, *reversed(agent.ended)]
    roles = (one.term.args[0] for one in beliefs if one.term.functor == ROLE and len(one.term.args) == 1)
    return ToldAgent(
        name=_short(agent.name),
        roles=tuple(_short(shown(role)) for role in islice(roles, most)),
        beliefs=tuple(_belief(one) for one in beliefs[-most:]),
        belief_count=len(beliefs),
        commitments=tuple(_commitment(one) for one in commitments[:most]),
        commitment_count=len(commitments),
    )


def told_message(utterance: Utterance, at_s: float) -> ToldMessage:
    return ToldMessage(
        at_s=at_s,
        performative=utterance.performative,
        sender=_short(utterance.other),
        content=_short(shown(utterance.content)),
    )


def _belief(belief: Belief) -> ToldBelief:
    return ToldBelief(
        term=_short(str(belief.about)),
        value=belief.value,
        origin=belief.origin.value,
        source=_short(belief.source),
        words=_short(belief.words),
        since_s=belief.since_s,
    )


def _commitment(commitment: Commitment) -> ToldCommitment:
    bound = islice(commitment.bindings.items(), MAX_TOLD_BINDINGS)
    return ToldCommitment(
        number=commitment.number,
        rule=_short(commitment.origin),
        name=_short(commitment.name),
        towards=_short(commitment.towards),
        bindings={_short(name): _short(shown(value)) for name, value in bound},
        made_s=commitment.made_s,
        due_s=commitment.due_s,
        ended_s=commitment.ended_s,
        state=commitment.state.value,
        reason=None if commitment.reason is None else commitment.reason.value,
        words=_short(commitment.words),
    )


def _short(text: str) -> str:
    return text if len(text) <= MAX_TOLD_CHARACTERS else f"{text[: MAX_TOLD_CHARACTERS - 1]}…"
