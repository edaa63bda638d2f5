"""Robots' roles in the record: those that operators have given, else those of the world's file."""

from collections.abc import Mapping

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.store.tables import RoleRow
from app.store.world_summary import summary_of
from robots.world import RobotSpec, RoleSpec, WorldFile


def role_in_force(row: RoleRow | None, spec: RobotSpec) -> RoleSpec | None:
    """The robot's role; None if it plays none.

    :param row: what operators have given it; None: nothing.
    """
    if row is None:
        return spec.role
    if not row.role:
        return None
    return RoleSpec(name=row.role, tags=None if row.tags is None else tuple(row.tags), rules=row.rules)


def roles_of(session: Session, world: WorldFile) -> Mapping[str, RoleSpec]:
    """The robots of a world that play a role."""
    rows: Mapping[str, RoleRow] = {}
    if summary_of(session, world.name).has_roles:
        query = select(RoleRow).where(RoleRow.world == world.name)
        rows = {row.robot: row for row in session.scalars(query)}
    roles = {spec.name: role_in_force(rows.get(spec.name), spec) for spec in world.robots}
    return {robot: role for robot, role in roles.items() if role is not None}


def with_roles_in_force(session: Session, world: WorldFile) -> WorldFile:
    """The world with the roles that its robots play now; the same one if they are those of its file."""
    roles = roles_of(session, world)
    if all(roles.get(spec.name) == spec.role for spec in world.robots):
        return world
    robots = tuple(spec.model_copy(update={"role": roles.get(spec.name)}) for spec in world.robots)
    return world.model_copy(update={"robots": robots})


def withheld_tags(session: Session, world: WorldFile) -> Mapping[str, tuple[RoleSpec, frozenset[str]]]:
    """The robots of a world that are not recruited for all that they can, with their role and what is left out."""
    withheld: dict[str, tuple[RoleSpec, frozenset[str]]] = {}
    for robot, role in roles_of(session, world).items():
        if role.tags is not None and (left_out := frozenset(world.robot(robot).repertoire) - {*role.tags}):
            withheld[robot] = (role, left_out)
    return withheld
