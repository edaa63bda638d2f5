"""The expected time of a mission."""

from app.organiser import Margin, enquiry_at_s, estimate_s
from tests.app.store import Store


def test_the_estimate_is_the_plan_nets_span() -> None:
    net = Store().store_sample_1()
    assert estimate_s(net) == max(action.earliest_end_s for action in net.actions) > 0


def test_robots_are_asked_after_the_estimate_and_its_margin() -> None:
    assert enquiry_at_s(100.0, 60.0, Margin(relative=0.5, absolute_s=20.0)) == 100 + 60 + 30 + 20
