"""What we use of viser that is not part of its public interface. Each name has a contract test of this module."""

import warnings

import viser


def request_path(server: viser.ViserServer, client_id: int) -> str:
    """The path at which a browser opened its socket, empty once it has left.

    Needs `ViserServer._websock_server._live_connections`: viser has no public way to ask for it. Without it no browser
    could be assigned to the page that embeds it, and every page would show the first world with nothing selected.
    """
    connection = server._websock_server._live_connections.get(client_id)
    return "" if connection is None or connection.request is None else connection.request.path


def ignore_closed_connections() -> None:
    """Do not warn of browsers that leave while they are drawn for.

    Needs the text of viser's warning. Without it the log fills with warnings, and nothing else changes.
    """
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
