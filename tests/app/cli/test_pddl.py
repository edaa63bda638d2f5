"""`macta plan` with PDDL files, in and out."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.cli.main import app

DOMAIN = """
(define (domain gripper) (:requirements :strips :typing)
 (:types robot room ball)
 (:predicates (at-robby ?b - robot ?r - room) (at ?b - ball ?r - room) (free ?r - robot) (carry ?o - ball ?r - robot))
 (:action move :parameters (?b - robot ?from ?to - room)
  :precondition (at-robby ?b ?from) :effect (and (at-robby ?b ?to) (not (at-robby ?b ?from))))
 (:action pick :parameters (?b - robot ?obj - ball ?room - room)
  :precondition (and (at ?obj ?room) (at-robby ?b ?room) (free ?b))
  :effect (and (carry ?obj ?b) (not (at ?obj ?room)) (not (free ?b))))
 (:action drop :parameters (?b - robot ?obj - ball ?room - room)
  :precondition (and (carry ?obj ?b) (at-robby ?b ?room))
  :effect (and (at ?obj ?room) (free ?b) (not (carry ?obj ?b)))))
"""
PROBLEM = """
(define (problem two-balls) (:domain gripper) (:objects r1 r2 - robot a b - room b1 b2 - ball)
 (:init (at-robby r1 a) (at-robby r2 b) (free r1) (free r2) (at b1 a) (at b2 a))
 (:goal (and (at b1 b) (at b2 b))))
"""


def macta(*words: str) -> Result:
    return CliRunner().invoke(app, ["plan", *words])


def files(folder: Path, domain: str = DOMAIN, problem: str = PROBLEM) -> list[str]:
    (folder / "domain.pddl").write_text(domain)
    (folder / "problem.pddl").write_text(problem)
    return ["--domain", str(folder / "domain.pddl"), "--problem", str(folder / "problem.pddl")]


def test_a_pddl_problem_is_planned(tmp_path: Path) -> None:
    done = macta(*files(tmp_path), "--agent", "robot", "--engine", "fast-downward", "--json")
    assert done.exit_code == 0, done.stderr
    body = json.loads(done.stdout)
    assert {action["tag"] for action in body["actions"]} == {"MOVE", "PICK", "DROP"}
    assert {robot for action in body["actions"] for robot in action["agents"]} <= {"r1", "r2"}


@pytest.mark.parametrize(
    "wrong", ["(define", DOMAIN.replace("(free ?b))\n", "(or (free ?b) (at ?obj ?room)))\n")]
)
def test_what_cannot_be_read_is_a_line_that_names_the_file(tmp_path: Path, wrong: str) -> None:
    refused = macta(*files(tmp_path, domain=wrong))
    assert refused.exit_code == 2
    assert refused.stderr.startswith("macta: ")
    assert "domain.pddl" in refused.stderr
    assert "Traceback" not in refused.stderr


@pytest.mark.parametrize("words", [[], ["--agent", "robot"], ["--domain", "x.pddl"], ["--pddl", "folder"]])
def test_half_of_what_is_needed_is_refused(words: list[str]) -> None:
    refused = macta(*words)
    assert refused.exit_code == 2
    assert "--goal" in refused.stderr


def test_a_goal_is_written_as_pddl(tmp_path: Path) -> None:
    done = macta("--goal", "move sample_1 to bay_7", "--pddl", str(tmp_path / "out"), "--json")
    assert done.exit_code == 0, done.stderr
    for form in (".", "numeric", "classical"):
        folder = tmp_path / "out" / form
        assert (folder / "domain.pddl").read_text().startswith("(define (domain macta)")
        assert "(object_position sample_1 in bay_7)" in (folder / "problem.pddl").read_text()


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    refused = macta("--goal", "move sample_1 to bay_7", "--pddl", str(tmp_path / "taken"))
    assert refused.exit_code == 2
    assert "--pddl" in refused.stderr
