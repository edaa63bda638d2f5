"""A robot's script goes on in another program from wherever it is, and its document is whole or refused."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.executive.hand_over import MindDocument, MindUnfit, Pieces, pieces_of, read_document
from robots.physical.body import Pose
from robots.wire import (
    Message,
    MindOrder,
    MindOrderReport,
    MindVerb,
    PacketState,
    Performative,
    Program,
    ScriptState,
)
from tests.robots.stories import EAST, Service, carry, room, run, run_for

START = Pose(x_m=4.0, y_m=1.5, heading_rad=EAST)


def told(service: Service, verb: MindVerb) -> MindOrderReport:
    """What the robot answers to the order to its mind, which is repeated as the service does."""
    piece = 0 if verb is MindVerb.REST else None
    order = MindOrder(verb=verb, fence=1, to=Program.OWN, piece=piece)
    service.send(order, Performative.REQUEST)

    def reports() -> list[MindOrderReport]:
        bodies = [one.body for one in service.heard]
        return [one for one in bodies if isinstance(one, MindOrderReport) and one.verb is verb]

    assert run(service.world, [service], lambda: bool(reports()), limit_s=40.0)
    return reports()[-1]


@settings(max_examples=10, deadline=None)
@given(at_s=st.floats(0.0, 60.0))
def test_a_script_comes_to_its_end_once_in_another_program_from_wherever_it_is(at_s: float) -> None:
    world = room({"s1": 1 + 0.4j})
    service = Service(world, world.add("fred", START), "fred")
    service.order(carry("fred", "s1", "door", "yard"))
    run_for(world, [service], at_s)
    rest = told(service, MindVerb.REST)
    assert rest.mind is not None
    text = Pieces().put(rest.mind)
    assert text is not None
    heard = len(service.heard)
    run_for(world, [service], 2.0)
    assert len(service.heard) == heard, "it is silent"
    world.take_over("fred", read_document(text), None)
    assert told(service, MindVerb.GO_ON).reason == ""
    assert run(world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state is ScriptState.FINISHED, service.report
    finished = [tag for tag, state in service.packets if state is PacketState.FINISHED]
    assert finished == ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]


def document() -> MindDocument:
    world = room()
    world.add("fred", START)
    return world.agents["fred"].hand_over()


@given(st.text(max_size=400), st.integers(1, 50), st.randoms())
def test_a_text_in_pieces_is_the_same_in_any_order_however_often_a_piece_comes(
    text: str, size: int, random: object
) -> None:
    pieces = pieces_of(text, size=size)
    order = [*pieces, *pieces[:2]]
    random.shuffle(order)  # type: ignore[attr-defined]
    put = Pieces()
    whole = [found for piece in order if (found := put.put(piece)) is not None]
    assert set(whole) == {text}


def test_pieces_of_two_documents_make_none() -> None:
    one, other = pieces_of("abcd", size=2), pieces_of("efgh", size=2)
    put = Pieces()
    assert put.put(one[0]) is None
    assert put.put(other[1]) is None
    assert put.put(other[0]) == "efgh"
    forged = one[1].model_copy(update={"text": "xx"})
    assert put.put(one[0]) is None
    with pytest.raises(MindUnfit, match="do not fit together"):
        put.put(forged)


def test_a_document_is_read_as_it_was_written_and_another_version_is_refused() -> None:
    written = document()
    text = written.model_dump_json()
    assert read_document(text) == written
    later = written.model_copy(update={"version": 2}).model_dump_json()
    with pytest.raises(MindUnfit, match="of version 2; this program takes version 1"):
        read_document(later)


def test_an_answer_that_brought_a_document_is_no_part_of_the_next_one() -> None:
    world = room()
    service = Service(world, world.add("fred", START), "fred")
    first = told(service, MindVerb.REST)
    assert first.mind is not None
    kept = world.agents["fred"].hand_over().mind.mailbox.answers
    (answer,) = [one for one in kept if isinstance(one.body, MindOrderReport)]
    assert isinstance(answer, Message)
    assert answer.body == first.model_copy(update={"mind": None})
