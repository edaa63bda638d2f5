"""The events of the log: each is defined once, told somewhere, documented and published."""

from collections import Counter
from pathlib import Path

from app.api.event_schema import event_schemas, event_table, references
from app.domain.events import GoalEvent, MissionEvent, PlanEvent, event_classes

ROOT = Path(__file__).parents[3]
SOURCES = [path for path in (ROOT / "app").rglob("*.py") if path.name != "events.py"]


def test_each_type_of_event_is_defined_once() -> None:
    counts = Counter(type_ for event in event_classes() for type_ in event.types())
    assert [type_ for type_, count in counts.items() if count > 1] == []


def test_each_class_of_events_is_used() -> None:
    text = "\n".join(path.read_text() for path in SOURCES) + (ROOT / "app/domain/events.py").read_text()
    unused = [event.__name__ for event in event_classes() if text.count(event.__name__) < 2]
    assert unused == []


def test_no_event_is_written_but_by_the_log() -> None:
    writers = [path.name for path in SOURCES if "EventRow, type=" in path.read_text()]
    assert writers == ["event_log.py"]


def test_events_of_goals_plans_and_missions_carry_the_state() -> None:
    for event in event_classes():
        subject = event.types()[0].partition(".")[0]
        base = {"goal": GoalEvent, "plan": PlanEvent, "mission": MissionEvent}.get(subject)
        assert base is None or issubclass(event, base), event


def test_the_document_lists_every_event_as_it_is() -> None:
    assert (ROOT / "docs/events.md").read_text().endswith("\n\n" + event_table())


def test_every_event_has_a_line_of_documentation_and_a_schema() -> None:
    schemas = event_schemas()
    for one in references():
        assert one.summary.endswith("."), one.name
        assert schemas[one.name]["description"] == one.summary
        assert "(" not in one.summary[:1]
    mapping = schemas["Event"]["discriminator"]["mapping"]
    assert {type_ for event in event_classes() for type_ in event.types()} < mapping.keys()
