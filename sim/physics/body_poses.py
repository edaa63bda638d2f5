"""Where the scene's bodies are: the physics engine is asked once, and again only after a body has moved."""

from math import atan2, cos, remainder, sin, tau

from sim.physics.quiet import quietly

with quietly():
    import pybullet

Upright = tuple[float, float, float, float]
"""Where a body is: x, y, z of its middle in metres and its heading in radians; it does not tilt."""


class Whereabouts:
    """The places of one PyBullet world's bodies. Whoever lets a body move must have it forgotten."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._known: dict[int, Upright] = {}

    def at(self, body: int) -> Upright:
        known = self._known.get(body)
        if known is None:
            (x, y, z), turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
            known = (x, y, z, _about_z(turn))
            self._known[body] = known
        return known

    def forget(self, body: int) -> None:
        self._known.pop(body, None)

    def place(self, body: int, middle: tuple[float, float, float], heading_rad: float) -> None:
        """Put a body somewhere, upright."""
        turn = (0.0, 0.0, sin(heading_rad / 2), cos(heading_rad / 2))
        pybullet.resetBasePositionAndOrientation(body, middle, turn, physicsClientId=self._client)
        self.forget(body)

    def level(self, body: int, height_m: float) -> None:
        """Put a body that moved back into its plane, if a push has lifted or tilted it."""
        (x, y, z), turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
        heading = _about_z(turn)
        if z != height_m or turn[0] or turn[1]:
            self.place(body, (x, y, height_m), heading)
        self._known[body] = (x, y, height_m, heading)


def _about_z(turn: tuple[float, float, float, float]) -> float:
    """The heading of a body that only turns in the plane, by its quaternion x, y, z, w."""
    return remainder(2 * atan2(turn[2], turn[3]), tau)
