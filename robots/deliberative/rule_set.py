"""The rule files of one robot together: its agents in order of rank, and the roles that any of them may take."""

from collections.abc import Mapping, Sequence

from robots.deliberative.lint import check
from robots.deliberative.program import RuleFile
from robots.deliberative.reader import rules_of
from robots.errors import RuleError
from robots.repertoire import Repertoire


def read_rule_set(files: Mapping[str, str]) -> list[RuleFile]:
    """Read texts by the name of their agent or role.

    :raises RuleError: naming file, line and column.
    """
    read = [rules_of(text, name) for name, text in files.items()]
    for name, file in zip(files, read, strict=True):
        if file.name != name:
            raise RuleError(f"{name}:1:1: the file says that it is {file.name}")
    return read


def check_rule_set(files: Mapping[str, str], repertoire: Repertoire) -> None:
    """Read and check texts by the name of their agent or role.

    :raises RuleError: naming file, line and column of each fault, and the way out.
    """
    teams_of(read_rule_set(files), repertoire)


def teams_of(files: Sequence[RuleFile], repertoire: Repertoire) -> list[tuple[RuleFile, ...]]:
    """Each agent's file with those of the roles, checked together.

    :raises RuleError: naming file, line and column of each fault, and the way out.
    """
    roles = [file for file in files if file.is_role]
    teams = [(file, *roles) for file in files if not file.is_role]
    for team in teams or ([tuple(roles)] if roles else []):
        check(team, repertoire)
    if roles and not teams:
        raise RuleError(
            f"{roles[0].origin}: a role needs the file of an agent beside it, such as duty, which ships"
        )
    return teams
