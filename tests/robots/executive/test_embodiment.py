"""Whether a robot's mind may act: it rests at a safe point, and goes on under the newest fencing number."""

from robots.executive.embodiment import Embodiment
from robots.physical.body import Pose
from robots.wire import Message, MindOrder, MindVerb, Performative

HERE = Pose(x_m=1.0, y_m=2.0, heading_rad=0.0)
THERE = Pose(x_m=1.1, y_m=2.0, heading_rad=0.0)


def order(verb: MindVerb, fence: int = 1, *, lease_until_s: float | None = None) -> tuple[Message, MindOrder]:
    body = MindOrder(verb=verb, fence=fence, within_s=5.0, lease_until_s=lease_until_s)
    message = Message(
        performative=Performative.REQUEST, sender="service", receiver="fred", sent_at_s=0.0, body=body
    )
    return message, body


def test_it_acts_until_it_is_safe_stands_until_it_is_still_and_rests_then() -> None:
    mind = Embodiment()
    assert mind.follow(*order(MindVerb.REST), 0.0) is None
    assert mind.settle(HERE, 0.1, unsafe="DOCK moves the jaws") is None
    assert not mind.stands(0.1), "the packet goes on"
    assert mind.settle(THERE, 0.2, unsafe="") is None
    assert mind.stands(0.2)
    answer = mind.settle(THERE, 0.3, unsafe="")
    assert answer is not None
    assert (answer.performative, answer.report.fence, mind.memory().rests) == (Performative.AGREE, 1, True)
    assert mind.stands(1e6)


def test_a_mind_that_comes_to_no_safe_point_in_time_refuses_with_the_reason_and_acts() -> None:
    mind = Embodiment()
    mind.follow(*order(MindVerb.REST), 0.0)
    for at_s in (1.0, 4.9):
        assert mind.settle(HERE, at_s, unsafe="DOCK moves the jaws") is None
    answer = mind.settle(HERE, 5.1, unsafe="DOCK moves the jaws")
    assert answer is not None
    assert answer.performative is Performative.REFUSE
    assert answer.report.reason == "it has come to no safe point in time: DOCK moves the jaws"
    assert not mind.stands(5.1)
    assert mind.memory().fence == 0, "the move's number was not followed"


def test_an_order_to_go_on_overtakes_the_one_to_rest() -> None:
    mind = Embodiment()
    mind.follow(*order(MindVerb.REST, 2), 0.0)
    gone_on = mind.follow(*order(MindVerb.GO_ON, 2), 0.1)
    assert gone_on is not None
    assert mind.settle(HERE, 0.2, unsafe="") is None
    assert not mind.stands(0.2)
    late = mind.follow(*order(MindVerb.REST, 2), 0.3)
    assert late is not None
    assert late.performative is Performative.REFUSE


def test_a_mind_acts_until_its_lease_ends_also_after_a_power_failure() -> None:
    mind = Embodiment()
    mind.follow(*order(MindVerb.GO_ON, lease_until_s=10.0), 0.0)
    again = Embodiment()
    again.recall(mind.memory())
    assert [again.stands(at_s) for at_s in (9.9, 10.1)] == [False, True]
    answer = again.follow(*order(MindVerb.GO_ON, lease_until_s=20.0), 11.0)
    assert answer is not None
    assert answer.report.lease_until_s == 20.0
    assert not again.stands(11.0)
