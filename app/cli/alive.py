"""`macta alive`: health checks of the planning worker and the fleet, for supervisors that restart them."""

import socket
import threading

from app.cli.long_running import fleet_over_broker
from app.cli.settings import settings_of
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Invalid, Unavailable
from robots.world import WorldFile

TIMEOUT_S = 10.0
"""How long to wait for the fleet; it sends its clock every second."""


def worker_alive() -> str:
    """The state of the planning worker on this host.

    :raises Unavailable: if no worker has sent a heartbeat lately.
    """
    from sqlalchemy.exc import SQLAlchemyError

    from app.store import Database
    from app.workflows import PLANNING
    from app.workflows.leases import executors

    settings = settings_of({}, keeps_folder=False)
    if not settings.database_is_shared:
        raise Invalid("MACTA_DATABASE_URL: set the PostgreSQL database that the worker and the service share")
    database = Database(settings.resolved_database_url())
    try:
        known = executors(database)
    except SQLAlchemyError as error:
        raise Unavailable("the database does not answer; check MACTA_DATABASE_URL") from error
    finally:
        database.close()
    host = socket.gethostname()
    for one in known:
        if one.alive and one.host == host and PLANNING.name in one.serves:
            return f"process {one.pid} plans; last heartbeat {one.seen_s:.0f} s ago"
    raise Unavailable(
        f"no running planning process of {host} is registered in the database; start `macta worker` there"
    )


def fleet_alive(world: WorldFile, *, wall: WallClock = SYSTEM_CLOCK) -> str:
    """The state of the world's fleet.

    :raises Unavailable: if it announces nothing within `TIMEOUT_S`.
    """
    broker = settings_of({}, keeps_folder=False).broker()
    if broker is None:
        raise Invalid("MACTA_BROKER_URL: set the broker's address")
    with fleet_over_broker(broker, world) as fleet:
        fleet.start()
        never = threading.Event()
        give_up = wall.monotonic_s() + TIMEOUT_S
        while fleet.run is None:
            if wall.monotonic_s() > give_up:
                raise Unavailable(
                    f"the fleet of {world.name} does not announce itself on broker {broker}; start `macta fleet`"
                )
            wall.wait(never, 0.05)
        return f"the fleet of {world.name} is running, at {fleet.clock.now_s():.0f} s"
