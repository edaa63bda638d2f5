"""Sets, constraints and times in sentences, resolved against a world."""

from datetime import datetime, timedelta, timezone

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.domain.goal_language.check import blocking, check_request
from app.domain.goal_language.completion import completions
from app.domain.goal_language.constraints import Constraints
from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.goal_language.syntax import grammar
from app.domain.goal_language.verbs import shipped_verbs
from app.domain.world_model import Facts, revise_beliefs
from benchmarks.sentence_fuzz import NOUNS, damaged, drawn_sentence, outcome
from planner import Fact
from robots.wire import SymbolicFact
from robots.world import WorldFile, generate_world, store_shape
from robots.world.parts import Location
from tests.app.berthed_store import berthed_store
from tests.app.sample_store import Store

STORE = Store()
RACKS = Store(berthed_store())
NOW = datetime(2026, 3, 1, 14, 0, tzinfo=timezone(timedelta(hours=1), "CET"))


def read(text: str, store: Store = STORE, facts: Facts | None = None) -> Understood:
    understood = understand(text, store.world, store.facts if facts is None else facts, now=NOW)
    assert isinstance(understood, Understood), understood
    return understood


def goals(text: str, store: Store = STORE) -> list[str]:
    return [str(goal) for goal in read(text, store).goals]


def asked(text: str, facts: Facts = STORE.facts) -> Clarification:
    question = understand(text, STORE.world, facts, now=NOW)
    assert isinstance(question, Clarification), question
    return question


def test_every_sample_of_an_aisle_is_those_that_lie_there() -> None:
    understood = read("bring every sample of aisle_1 to door_2")
    assert [str(goal) for goal in understood.goals] == ["in(sample_2, door_2)", "in(sample_3, door_2)"]
    assert [(one.said, one.means) for one in understood.readings] == [
        ("every sample of aisle_1", ("sample_2", "sample_3"))
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("move sample_1 and sample_2 to bay_7", ["in(sample_1, bay_7)", "in(sample_2, bay_7)"]),
        ("move all samples in aisle_2 to door_2", ["in(sample_4, door_2)"]),
        ("move the samples at door_1 to bay_7", ["in(sample_1, bay_7)"]),
        ("bring two samples to door_1", ["in(sample_2, door_1)", "in(sample_3, door_1)"]),
        ("move both samples of aisle_1 to any bay", ["in(sample_2, bay_1)", "in(sample_3, bay_3)"]),
        (
            "move sample_1 to bay_7 and the other two samples of aisle_1 to free bays",
            ["in(sample_1, bay_7)", "in(sample_2, bay_1)", "in(sample_3, bay_3)"],
        ),
        (
            "move both samples of aisle_1 to any bay of aisle_2",
            ["in(sample_2, bay_7)", "in(sample_3, bay_8)"],
        ),
        ("move sample_1 of door_1 to bay_7 of aisle_2", ["in(sample_1, bay_7)"]),
        ("swap sample_1 and sample_2", ["in(sample_1, bay_2)", "in(sample_2, door_1)"]),
        ("exchange sample_1 with sample_2", ["in(sample_1, bay_2)", "in(sample_2, door_1)"]),
        ("park yard_1", ["near(yard_1, home_yard_1)"]),
        ("park yard_1 and store_2", ["near(yard_1, home_yard_1)", "near(store_2, home_store_2)"]),
        ("park all robots of the yard", ["near(yard_1, home_yard_1)", "near(yard_2, home_yard_2)"]),
        ("send yard_2 to door_1", ["near(yard_2, door_1)"]),
        ("park yard_2 at door_1", ["near(yard_2, door_1)"]),
    ],
)
def test_sets_and_verbs_are_resolved_against_the_world(text: str, expected: list[str]) -> None:
    assert goals(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("move sample_1 to any bay, keep bay_1 empty", ["in(sample_1, bay_3)"]),
        ("move sample_1 to any bay avoiding bay_1", ["in(sample_1, bay_3)"]),
        ("move sample_1 to any bay without store_1", ["in(sample_1, bay_7)"]),
        ("move sample_1 to any bay with yard_1 and store_2", ["in(sample_1, bay_7)"]),
        ("move any sample to bay_7, not through door_1", ["in(sample_2, bay_7)"]),
        ("park any robot without store_1", ["near(store_2, home_store_2)"]),
        ("send yard_1 and yard_2 to any door", ["near(yard_1, door_1)", "near(yard_2, door_2)"]),
        ("send yard_1 to any door avoiding door_1", ["near(yard_1, door_2)"]),
    ],
)
def test_what_a_sentence_leaves_open_is_chosen_within_its_constraints(text: str, expected: list[str]) -> None:
    assert goals(text) == expected


def test_a_free_place_is_chosen_within_the_constraints_beside_the_sentence() -> None:
    beside = Constraints(keep_empty=("bay_1",))
    understood = understand("move sample_1 to any bay", STORE.world, STORE.facts, beside=beside)
    assert isinstance(understood, Understood)
    assert [str(goal) for goal in understood.goals] == ["in(sample_1, bay_3)"]
    assert understood.constraints == Constraints()


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("keep bay_1 and bay_3 empty and move sample_1 to bay_7", ("bay_1", "bay_3")),
        ("keep bay_1, bay_3 and bay_4 free, move sample_1 to bay_7", ("bay_1", "bay_3", "bay_4")),
        ("move sample_1 to bay_7, keep bay_1 empty and bay_3 empty", ("bay_1", "bay_3")),
    ],
)
def test_several_places_are_kept_empty(text: str, places: tuple[str, ...]) -> None:
    understood = read(text)
    assert understood.constraints.keep_empty == places
    assert [str(goal) for goal in understood.goals] == ["in(sample_1, bay_7)"]


@pytest.mark.parametrize(
    ("text", "code", "at"),
    [
        ("keep bay_1 and bay_3 and move sample_1 to bay_7", "goal-not-understood", ""),
        ("move sample_1 to bay_7 and bay_3 empty", "unknown-verb", "bay_3"),
        ("bay_3 empty", "unknown-verb", "bay_3"),
    ],
)
def test_places_are_kept_empty_only_by_keep_and_empty(text: str, code: str, at: str) -> None:
    question = asked(text)
    assert question.span is not None
    assert (question.code, text[slice(*question.span)]) == (code, at)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("move sample 1 to bay 7 unless lunch", "unless"),
        ("move sample_1 or sample_2 to bay_7", "or"),
        ("park all robots except yard_1", "except"),
        ("move every sample of aisle_1 whenever to door_2", "whenever"),
    ],
)
def test_what_follows_a_known_name_is_what_is_not_understood(text: str, word: str) -> None:
    question = asked(text)
    assert question.span is not None
    assert (question.code, question.thing, text[slice(*question.span)]) == ("goal-not-understood", word, word)
    assert {"and", "to", "with", "of"} <= set(question.choices)


def test_an_area_is_no_target_but_its_places_are_choices() -> None:
    text = "move sample_1 to Aisle 2"
    question = asked(text)
    assert (question.code, question.choices[:2]) == ("unknown-place", ("any place of aisle_2", "bay_7"))
    assert completions(text, question, STORE.world, STORE.facts)[0] == "move sample_1 to any place of aisle_2"
    assert goals("move sample_1 to any place of aisle_2") == ["in(sample_1, bay_7)"]


def test_to_avoid_an_area_is_to_avoid_its_places() -> None:
    avoided = read("move sample_1 to bay_7, not through aisle_1").constraints.avoid
    assert {"bay_1", "bay_6", "interchange_1"} <= set(avoided)
    assert not {"bay_7", "interchange_2", "door_1"} & set(avoided)


def test_a_robot_that_must_not_act_may_stay_where_it_stands() -> None:
    text = "move sample_1 to bay_7 with yard_2 and store_2, then park all robots"
    understood = read(text)
    issues = check_request(understood.goals, understood.constraints, STORE.world, STORE.facts, STORE.base)
    assert blocking(issues) == ()


def test_first_and_only_may_be_said() -> None:
    ordered = read("first send yard_2 to door_2, then park store_1")
    assert ordered.constraints.stages == (0, 1)
    assert read("move sample_1 to bay_7 only with yard_2").constraints.robots == ("yard_2",)
    # In another place "first" would change the order, and is not understood.
    assert asked("move sample_1 to bay_7, first park yard_1").code == "unknown-sample"


def test_without_and_avoiding_any_mean_all_of_them() -> None:
    assert read("move sample_1 to bay_7 without any robot of the yard").constraints.without == (
        "yard_1",
        "yard_2",
    )
    avoided = read("move sample_1 to bay_7, not through any bay of aisle_1").constraints.avoid
    assert avoided == ("bay_1", "bay_2", "bay_3", "bay_4", "bay_5", "bay_6")


def test_any_place_is_a_free_one_and_racks_take_several() -> None:
    assert goals("move sample_1 and sample_3 to any bay", RACKS) == [
        "in(sample_1, bay_1)",
        "in(sample_3, bay_1)",
    ]


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (("in", "sample_2", "bay_1"), "in(sample_1, bay_3)"),
        (("in", "sample_1", "bay_1"), "in(sample_1, bay_1)"),  # it is the same that is asked for again
        (("near", "yard_1", "bay_1"), "in(sample_1, bay_1)"),  # which puts nothing there
    ],
)
def test_any_place_is_none_that_another_goal_aims_at(other: tuple[str, ...], expected: str) -> None:
    said = "move sample_1 to any bay"
    fact = SymbolicFact(predicate=other[0], args=other[1:])
    understood = understand(said, STORE.world, STORE.facts, aims=lambda: [fact])
    assert isinstance(understood, Understood)
    assert [str(goal) for goal in understood.goals] == [expected]


def test_where_other_goals_aim_at_every_free_place_the_answer_names_them() -> None:
    world, facts = STORE.world, STORE.facts  # sample_1 lies at door_1
    asked = [0]

    def aims() -> list[SymbolicFact]:
        asked[0] += 1
        return [SymbolicFact(predicate="in", args=("sample_4", "door_2"))]

    question = understand("move sample_2 to any door", world, facts, aims=aims)
    assert isinstance(question, Clarification)
    assert question.detail == "there is no free door for sample_2: goals aim at door_2 already"
    assert asked == [1]
    understand("move sample_2 to bay_7", world, facts, aims=aims)
    assert asked == [1], "nothing was left open"


def test_a_robot_without_a_home_is_parked_where_nobody_stands() -> None:
    data = STORE.world.model_dump(mode="json")
    (yard_1,) = (robot for robot in data["robots"] if robot["name"] == "yard_1")
    yard_1["home"] = None
    world = WorldFile.model_validate(data)
    assert world.robot("yard_1").home is None
    question = understand("park yard_1", world, STORE.facts)
    assert isinstance(question, Understood)
    assert [str(goal) for goal in question.goals] == ["near(yard_1, home_yard_1)"]
    other = SymbolicFact(predicate="near", args=("yard_2", "home_yard_1"))
    elsewhere = understand("park yard_1", world, STORE.facts, aims=lambda: [other])
    assert isinstance(elsewhere, Clarification)
    assert elsewhere.code == "place-needed", "no other place of the yard is for parking"


@pytest.mark.parametrize(
    ("text", "code", "word", "choice"),
    [
        ("bring three samples of aisle_1 to door_2", "sample-needed", "three samples of aisle_1", "sample_2"),
        ("move sample_1 of aisle_1 to bay_7", "sample-elsewhere", "sample_1 of aisle_1", "door_1"),
        ("move sample_1 to bay_7 of aisle_1", "unknown-place", "bay_7 of aisle_1", "bay_1"),
        ("move sample_1 to any bay of aisle_9", "unknown-place", "aisle_9", "aisle_1"),
        ("move the other sample to bay_7", "sample-needed", "other sample", "sample_1"),
        ("swap sample_1", "sample-needed", "", "sample_2"),
        ("swap sample_1 and sample_1", "goal-not-understood", "sample_1", "sample_2"),
        ("swap sample_1 with two samples", "goal-not-understood", "two samples", "sample_4"),
        ("park sample_1", "unknown-robot", "sample_1", "yard_1"),
        ("park", "robot-needed", "", "yard_1"),
        ("send yard_1", "place-needed", "", "door_1"),
        ("move sample_1 to bay_7 with yard_9", "unknown-robot", "yard_9", "yard_2"),
        ("move sample_1 to bay_7 with", "robot-needed", "", "yard_1"),
        ("move sample_1 to bay_7 not through bay_77", "unknown-place", "bay_77", "bay_7"),
        ("move sample_1 to bay_7 not", "goal-not-understood", "", "through"),
        ("move sample_1 to bay_7 by noon", "time-not-understood", "noon", "15:00"),
        ("move sample_1 to bay_7 by", "time-not-understood", "", "15:00"),
        ("keep bay_3", "goal-not-understood", "", "empty"),
        ("move sample_1 to bay_7 by 15:00 bay_8", "goal-not-understood", "bay_8", "with"),
    ],
)
def test_a_bad_sentence_is_answered_with_code_word_place_and_choices(
    text: str, code: str, word: str, choice: str
) -> None:
    question = asked(text)
    assert question.code == code
    assert question.span is not None
    assert text[slice(*question.span)] == word
    assert choice in question.choices
    assert question.detail


def test_constraints_in_a_sentence() -> None:
    constraints = read(
        "with yard_2 and store_2, move sample_1 to bay_7 not through interchange_1 and bay_8, without store_1, "
        "and keep bay_3 empty"
    ).constraints
    assert constraints.robots == ("yard_2", "store_2")
    assert constraints.without == ("store_1",)
    assert constraints.avoid == ("interchange_1", "bay_8")
    assert constraints.keep_empty == ("bay_3",)


def test_a_constraint_does_not_swallow_the_next_goal() -> None:
    understood = read("move sample_1 to bay_7 with yard_2 and store_2 and sample_2 to door_2")
    assert [str(goal) for goal in understood.goals] == ["in(sample_1, bay_7)", "in(sample_2, door_2)"]
    assert understood.constraints.robots == ("yard_2", "store_2")


@pytest.mark.parametrize(
    ("said", "in_s", "at"),
    [
        ("by 14:30", 1800, "2026-03-01T14:30+01:00"),
        ("before 15:00", 3600, "2026-03-01T15:00+01:00"),
        ("by 13:59", 86_340, "2026-03-02T13:59+01:00"),
        ("in ten minutes", 600, None),
        ("within 90 seconds", 90, None),
        ("in half an hour", 1800, None),
        ("within an hour", 3600, None),
    ],
)
def test_times_are_resolved_by_the_services_clock_and_zone(said: str, in_s: float, at: str | None) -> None:
    due = read(f"move sample_1 to bay_7 {said}").due
    assert due is not None
    assert (due.in_s, due.at) == (in_s, at)


def test_more_goals_or_names_than_are_allowed_are_refused() -> None:
    many = asked(" then ".join(["park all robots"] * 26))
    assert many.code == "too-many-goals"
    goals = read("park yard_1").goals
    wide = Constraints(avoid=tuple(f"bay_{number}" for number in range(1001)))
    issues = check_request(goals, wide, STORE.world, STORE.facts, STORE.base)
    assert "too-many-names" in {issue.code for issue in issues}


MISSIONS = {"mission-2c7ee919cecc": 90.0, "mission-0123456789ab": 12.0}


@pytest.mark.parametrize(
    "said", ["mission-2c7ee919cecc", "Mission 2c7ee919cecc", "mission mission-2c7ee919cecc"]
)
def test_before_a_mission_is_before_its_expected_end(said: str) -> None:
    understood = understand(
        f"park yard_1 before {said}", STORE.world, STORE.facts, now=NOW, missions=lambda: MISSIONS
    )
    assert isinstance(understood, Understood)
    assert understood.due is not None
    assert (understood.due.in_s, understood.due.mission) == (90.0, "mission-2c7ee919cecc")


def test_a_mission_that_is_not_open_is_asked_about() -> None:
    text = "park yard_1 before mission-9"
    question = understand(text, STORE.world, STORE.facts, now=NOW, missions=lambda: MISSIONS)
    assert isinstance(question, Clarification)
    assert (question.code, question.choices) == ("unknown-mission", tuple(MISSIONS))
    assert "park yard_1 before mission-0123456789ab" in completions(text, question, STORE.world, STORE.facts)


def test_after_missions_is_a_constraint_on_when_it_is_planned() -> None:
    text = "move sample_1 to bay_2 after mission-2c7ee919cecc and mission 0123456789ab"
    understood = understand(text, STORE.world, STORE.facts, now=NOW, missions=lambda: MISSIONS)
    assert isinstance(understood, Understood)
    assert understood.constraints.after == ("mission-2c7ee919cecc", "mission-0123456789ab")
    # sample_2 lies in bay_2; it may lie elsewhere by then
    stated = (understood.goals, understood.constraints, STORE.world, STORE.facts, STORE.base)
    assert [(one.code, one.kind) for one in check_request(*stated)] == [("place-occupied", "note")]


def test_through_an_interchange_is_not_through_the_others() -> None:
    understood = read("move sample_1 to bay_7 via interchange_2")
    assert understood.constraints.avoid == ("interchange_1",)
    assert understood.readings[-1].said == "through interchange_2"
    assert read("move sample_1 to bay_7 through interchange_1 and interchange_2").constraints.avoid == ()
    question = asked("move sample_1 to bay_7 through door_2")
    assert (question.code, question.choices) == ("no-interchange", ("interchange_1", "interchange_2"))


def test_then_puts_goals_in_stages() -> None:
    understood = read(
        "move sample_1 to bay_7 and sample_2 to bay_1, then park yard_1 and yard_2; and then park store_1"
    )
    assert understood.constraints.stages == (0, 0, 1, 1, 2)
    assert understood.readings[-1].said == "then"
    assert read("move sample_1 to bay_7 and park yard_1").constraints.stages == ()


def test_goals_of_which_one_ends_the_other_are_refused_also_one_after_the_other() -> None:
    understood = read("send yard_2 to door_1 then park yard_2")
    issues = check_request(understood.goals, understood.constraints, STORE.world, STORE.facts, STORE.base)
    found = [issue for issue in issues if issue.kind != "note"]
    assert found[0].code == "one-thing-in-two-places"
    assert "all goals must be true at the end" in found[0].detail


def test_stages_are_those_of_the_goals() -> None:
    goals = read("park yard_1 and yard_2").goals
    wrong = check_request(goals, Constraints(stages=(0, 1, 2)), STORE.world, STORE.facts, STORE.base)
    assert [issue.code for issue in wrong if issue.kind != "note"] == ["stages-of-other-goals"]


def test_in_is_a_place_or_a_time() -> None:
    understood = read("store sample_1 in bay_7 in two minutes")
    assert [str(goal) for goal in understood.goals] == ["in(sample_1, bay_7)"]
    assert understood.due is not None
    assert understood.due.in_s == 120


@pytest.mark.parametrize(
    ("text", "code", "part"),
    [
        ("move sample_1 to bay_7 with yard_2", "constraints-too-tight", "only with yard_2"),
        (
            "move sample_1 to bay_3 not through interchange_1",
            "constraints-too-tight",
            "avoiding interchange_1",
        ),
        ("move sample_1 to bay_7 avoiding bay_7", "constraint-contradicts-goal", "which is to be avoided"),
        ("move sample_1 to bay_7 avoiding door_1", "constraint-contradicts-goal", "sample_1 lies in door_1"),
        ("move sample_1 to bay_7 and keep bay_7 empty", "constraint-contradicts-goal", "kept empty"),
        ("move sample_1 to bay_7 and keep bay_2 empty", "place-occupied", "sample_2 lies there"),
        (
            "send yard_1 to door_1 without yard_1",
            "constraint-contradicts-goal",
            "yard_1, which is not to act",
        ),
        ("park yard_1 with yard_1 without yard_1", "no-robot-left", "no robot is left"),
    ],
)
def test_constraints_that_cannot_be_kept_are_refused_before_planning(text: str, code: str, part: str) -> None:
    understood = read(text)
    issues = check_request(understood.goals, understood.constraints, STORE.world, STORE.facts, STORE.base)
    found = [issue for issue in issues if issue.kind != "note"]
    assert found[0].code == code
    assert part in found[0].detail


def test_a_place_that_is_emptied_may_be_kept_empty() -> None:
    understood = read("move sample_2 to bay_7 and keep bay_2 empty")
    assert not check_request(understood.goals, understood.constraints, STORE.world, STORE.facts, STORE.base)


def test_a_lost_sample_is_not_swapped() -> None:
    facts = revise_beliefs(STORE.facts, [], gone=[STORE.fact("in(sample_1, door_1)")])
    assert asked("swap sample_1 and sample_2", facts).code == "sample-lost"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("sw", "swap"),
        ("swap sample_1", "swap sample_1 with sample_2"),
        ("move sample_1 to bay_7 w", "move sample_1 to bay_7 with"),
        ("move sample_1 to bay_7 with", "move sample_1 to bay_7 with yard_2"),
        ("move sample_1 to bay_7 with yard", "move sample_1 to bay_7 with yard_1"),
        ("move sample_1 to bay_7 not", "move sample_1 to bay_7 not through"),
        ("move sample_1 to bay_7 not thr", "move sample_1 to bay_7 not through"),
        ("move sample_1 to bay_7 by", "move sample_1 to bay_7 by 15:00"),
        ("bring ev", "bring every"),
        ("keep bay_3", "keep bay_3 empty"),
        ("keep bay_3 empty", "keep bay_3 empty until"),
        ("keep bay_3 empty u", "keep bay_3 empty until"),
        ("keep bay_3 empty f", "keep bay_3 empty for"),
        ("keep bay_3 empty until", "keep bay_3 empty until 15:00"),
        ("keep bay_3 empty until 16", "keep bay_3 empty until 16:00"),
        ("keep bay_3 empty for ten", "keep bay_3 empty for ten minutes"),
        ("keep bay_3 until 14:30", "keep bay_3 empty until 14:30"),
        ("keep bay_3 empty until sample_1 is", "keep bay_3 empty until sample_1 is in door_2"),
        ("park", "park yard_1"),
        ("park ya", "park yard_1"),
    ],
)
def test_completions_come_from_the_grammar_and_the_verbs(text: str, sentence: str) -> None:
    assert sentence in completions(text, asked(text), STORE.world, STORE.facts)


WORDS = sorted(
    {*shipped_verbs().words, *NOUNS, *(word for some in grammar().words.values() for word in some)}
)
DRAWN = st.randoms(use_true_random=False).map(
    lambda chance: drawn_sentence(chance, STORE.world, shipped_verbs())
)
DAMAGED = st.tuples(st.randoms(use_true_random=False), DRAWN).map(lambda pair: damaged(*pair))
ANY_TEXT = (
    DRAWN | DAMAGED | st.lists(st.sampled_from(WORDS), max_size=14).map(" ".join) | st.text(max_size=60)
)


@settings(max_examples=400, deadline=None)
@given(ANY_TEXT, st.booleans())
def test_any_text_is_understood_or_asked_about(text: str, is_known: bool) -> None:
    facts = STORE.facts if is_known else frozenset()
    outcome(text, STORE.world, facts, STORE.base, shipped_verbs())


def test_a_robot_without_a_home_is_charged_at_a_charger_that_it_reaches_rather_a_free_one() -> None:
    shape = store_shape(samples=2, aisles=1, yard_robots=2)
    world = generate_world(shape, shared_chargers=True)
    shared = Store(world)
    assert goals("charge store_1", shared) == ["charged(store_1, charger_aisle_1)"]
    assert goals("charge all robots of the yard", shared) == [
        "charged(yard_1, charger_yard)",
        "charged(yard_2, charger_yard)",
    ]
    yard_2 = world.robot("yard_2").start
    second = {"name": "a_charger", "kind": "charger", "at": yard_2[:2], "approach_deg": [0], "capacity": 0}
    two = Store(_with_locations(world, *world.locations, Location.model_validate(second)))
    assert Fact("robot_position", ("yard_2", "near", "a_charger")) in two.facts
    assert goals("charge yard_1", two) == ["charged(yard_1, charger_yard)"], "yard_2 stands at the other one"
    assert goals("charge all robots of the yard", two) == [
        "charged(yard_1, charger_yard)",
        "charged(yard_2, a_charger)",
    ]
    bare = Store(_with_locations(world, *(place for place in world.locations if place.kind != "charger")))
    question = understand("charge yard_1", bare.world, bare.facts, now=NOW)
    assert isinstance(question, Clarification)
    assert question.detail == "yard_1 has no home and reaches no charger; say where to charge it"


def _with_locations(world: WorldFile, *locations: Location) -> WorldFile:
    return WorldFile.model_construct(**{**dict(world), "locations": locations})
