"""The counters of a world's record and which of its rare rows there are, read in one statement.

Planning, approval and monitoring need all of them in most transactions, and rarely find a hold, a role that was given
or a robot that is lost.
"""

from dataclasses import dataclass

from sqlalchemy import BindParameter, bindparam, func, select
from sqlalchemy.orm import Session

from app.domain.lifecycles.hold import HoldState
from app.store.engine import count_writes
from app.store.tables import (
    DurationRow,
    EditionRow,
    HoldRow,
    LostRobotRow,
    OutOfServiceRow,
    RoleRow,
    UnaskedRobotRow,
    WorldRow,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSummary:
    """The run and counters of a world's row, the number of its newest edition, and whether it has rows of other tables.

    :param has_holds: some hold stands.
    :param waiting_workflow: of the world's row.
    """

    run: str | None
    version: int
    numbers_version: int
    releases: int
    waiting_workflow: str | None
    edition: int
    has_holds: bool
    has_roles: bool
    has_lost: bool
    has_out_of_service: bool
    has_unasked: bool
    has_durations: bool


NOTHING = WorldSummary(
    run=None,
    version=0,
    numbers_version=0,
    releases=0,
    waiting_workflow=None,
    edition=0,
    has_holds=False,
    has_roles=False,
    has_lost=False,
    has_out_of_service=False,
    has_unasked=False,
    has_durations=False,
)
_SUMMARIES = "world summaries"
"""Key of `Session.info`: by world, the writes of the transaction before its summary was read, and the summary."""
_WORLD: BindParameter[str] = bindparam("world")
_QUERY = select(
    WorldRow.run,
    WorldRow.version,
    WorldRow.numbers_version,
    WorldRow.releases,
    WorldRow.waiting_workflow,
    func.coalesce(
        select(func.max(EditionRow.edition)).where(EditionRow.world == _WORLD).scalar_subquery(), 0
    ).label("edition"),
    select(HoldRow.id)
    .where(HoldRow.world == _WORLD, HoldRow.state == HoldState.HELD)
    .exists()
    .label("has_holds"),
    select(RoleRow.robot).where(RoleRow.world == _WORLD).exists().label("has_roles"),
    select(LostRobotRow.robot).where(LostRobotRow.world == _WORLD).exists().label("has_lost"),
    select(OutOfServiceRow.robot).where(OutOfServiceRow.world == _WORLD).exists().label("has_out_of_service"),
    select(UnaskedRobotRow.robot).where(UnaskedRobotRow.world == _WORLD).exists().label("has_unasked"),
    select(DurationRow.action).where(DurationRow.world == _WORLD).exists().label("has_durations"),
).where(WorldRow.id == _WORLD)


def summary_of(session: Session, world: str) -> WorldSummary:
    """The world's summary, read once until the transaction writes or locks the world.

    What other transactions commit meanwhile is not seen, as if all were read at once. Of a world that is not recorded,
    all is 0 and False.
    """
    known: dict[str, tuple[int, WorldSummary]] = session.info.setdefault(_SUMMARIES, {})
    writes = count_writes(session)
    read_at, summary = known.get(world, (None, None))
    if summary is not None and read_at == writes:
        return summary
    row = session.connection().execute(_QUERY, {"world": world}).mappings().one_or_none()
    summary = NOTHING if row is None else WorldSummary(**row)
    known[world] = writes, summary
    return summary


def forget_summary(session: Session, world: str) -> None:
    """Read the summary again when it is asked for next: another transaction may have written."""
    session.info.get(_SUMMARIES, {}).pop(world, None)
