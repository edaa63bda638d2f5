"""PDDL files, in and out, for `macta plan`."""

from pathlib import Path

from app.errors import Invalid
from planner import KnowledgeBase, PlanningProblem
from planner.errors import Unsupported
from planner.interchange.foreign import ReadProblem, import_problem
from planner.interchange.pddl import Form, Vocabulary, domain_text, problem_text


def write_files(folder: Path, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
    """Write `domain.pddl` and `problem.pddl`, temporal, and both with action costs in the folder `classical`.

    :raises Invalid: if they cannot be written.
    """
    for form, place in ((Form.TEMPORAL, folder), (Form.CLASSICAL, folder / "classical")):
        words = Vocabulary(knowledge_base, form)
        try:
            place.mkdir(parents=True, exist_ok=True)
            (place / "domain.pddl").write_text(domain_text(words))
            (place / "problem.pddl").write_text(problem_text(words, problem))
        except OSError as error:
            raise Invalid(f"--pddl: {place} cannot be written: {error.strerror}") from error


def read_files(domain: Path, problem: Path, agents: list[str]) -> ReadProblem:
    """:raises Invalid: if a file cannot be read, is no PDDL, or has features we cannot plan with."""
    try:
        return import_problem(domain.read_text(), problem.read_text(), agents=agents)
    except OSError as error:
        raise Invalid(f"{error.filename} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise Invalid(f"{domain} or {problem} is no text: {error.reason}") from error
    except Unsupported as error:
        raise Invalid(f"{domain}, {problem}: {error}") from error
