"""`macta alive`: health checks of the planning worker and the fleet, for supervisors that restart them.

Supervisors call them every few seconds, so they import little: no SQLAlchemy, no workflow engine, no simulation.
"""

import os
import socket
import threading
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING

from app.database_url import DatabaseUrl
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Invalid, Unavailable
from app.domain.heartbeats import DEAD_AFTER_S, PLANNING_QUEUE

if TYPE_CHECKING:
    from robots.world import WorldFile

TIMEOUT_S = 10.0
"""How long to wait for the fleet; it sends its clock every second."""
CONNECT_TIMEOUT_S = "5"
HEARTBEATS = """
    SELECT pid, serves, extract(epoch FROM clock_timestamp())::float - seen_at FROM executors
    WHERE host = %s ORDER BY started_at, id
"""
"""The processes of a host: its id, the queues that it serves, seconds since its heartbeat by the server's clock."""


def worker_alive() -> str:
    """The state of the planning worker on this host.

    :raises Unavailable: if no worker has sent a heartbeat lately.
    """
    import psycopg

    server = _server()
    host = socket.gethostname()
    try:
        with closing(psycopg.connect(server)) as connection:
            known = connection.execute(HEARTBEATS, (host,)).fetchall()
    except psycopg.Error as error:
        raise Unavailable("the database does not answer; check MACTA_DATABASE_URL") from error
    for pid, serves, silent_s in known:
        if PLANNING_QUEUE in serves and silent_s < DEAD_AFTER_S:
            return f"process {pid} plans; last heartbeat {max(silent_s, 0.0):.0f} s ago"
    raise Unavailable(
        f"no running planning process of {host} is registered in the database; start `macta worker` there"
    )


def _server() -> str:
    """The worker's database; read without `app.settings`, which takes longer to import than all else here.

    :raises Invalid: if it is not set, or not a server's.
    """
    from psycopg import ProgrammingError
    from psycopg.conninfo import make_conninfo

    url = os.environ.get("MACTA_DATABASE_URL")
    try:
        database = DatabaseUrl.of(url) if url else None
        if database is not None and database.is_shared:
            return make_conninfo(**{"connect_timeout": CONNECT_TIMEOUT_S, **database.server_parameters()})
    except (ValueError, ProgrammingError) as error:
        raise Invalid(f"MACTA_DATABASE_URL: {error}".strip()) from error
    raise Invalid("MACTA_DATABASE_URL: set the PostgreSQL database that the worker and the service share")


def fleet_alive(world: "WorldFile", *, wall: WallClock = SYSTEM_CLOCK) -> str:
    """The state of the world's fleet.

    :raises Unavailable: if it announces nothing within `TIMEOUT_S`; what the broker has kept of it does not count.
    """
    from app.cli.settings import settings_of
    from robots.link.mqtt import Broker, ServiceLink
    from robots.world import digest_of

    broker = settings_of({}, keeps_folder=False).broker()
    if broker is None:
        raise Invalid("MACTA_BROKER_URL: set the broker's address")
    make = partial(ServiceLink, broker=broker) if isinstance(broker, Broker) else broker.service_end
    with closing(make(world.name, (), digest=digest_of(world))) as fleet:
        fleet.start()
        never = threading.Event()
        give_up = wall.monotonic_s() + TIMEOUT_S
        # A package's link tells of a run when it is announced; of a broker what it has kept does not count.
        while not (fleet.is_driven if isinstance(fleet, ServiceLink) else fleet.run):
            if wall.monotonic_s() > give_up:
                raise Unavailable(
                    f"the fleet of {world.name} does not announce itself on broker {broker}; start `macta fleet`"
                )
            wall.wait(never, 0.05)
        return f"the fleet of {world.name} is running, at {fleet.clock.now_s():.0f} s"
