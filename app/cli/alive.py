"""`macta alive`: whether a part of the production shape on this host is well, for whoever restarts it if not."""

import socket
import time

from sqlalchemy.exc import SQLAlchemyError

from app.cli.long_running import world_over_broker
from app.cli.settings import settings_of
from app.domain.errors import Invalid, Unavailable
from app.store import Database
from app.workflows import PLANNING
from app.workflows.leases import executors
from robots.world import WorldFile

PATIENCE_S = 10.0
"""How long a fleet may take to be heard; it says where it is every second."""


def worker_alive() -> str:
    """What there is to say of the planning worker on this host.

    :raises Unavailable: if none has said of late that it lives.
    """
    settings = settings_of({}, keeps_folder=False)
    if not settings.database_is_shared:
        raise Invalid("MACTA_DATABASE_URL: say on which PostgreSQL the worker and the others are")
    database = Database(settings.resolved_database_url())
    try:
        known = executors(database)
    except SQLAlchemyError as error:
        raise Unavailable("the database does not answer") from error
    finally:
        database.close()
    host = socket.gethostname()
    for one in known:
        if one.alive and one.host == host and PLANNING.name in one.serves:
            return f"process {one.pid} plans; it said so {one.seen_s:.0f} s ago"
    raise Unavailable(f"no living process on {host} plans")


def fleet_alive(world: WorldFile) -> str:
    """What there is to say of the world's fleet.

    :raises Unavailable: if it is not heard of.
    """
    broker = settings_of({}, keeps_folder=False).broker()
    if broker is None:
        raise Invalid("MACTA_BROKER_URL: say where the broker is")
    with world_over_broker(broker, world) as running:
        assert running.fleet is not None
        running.fleet.start()
        give_up = time.monotonic() + PATIENCE_S
        while running.fleet.run is None:
            if time.monotonic() > give_up:
                raise Unavailable(f"the fleet of {world.name} is not heard of at {broker}")
            time.sleep(0.05)
        return f"the fleet of {world.name} is at {running.clock.now_s():.0f} s of its run"
