"""A body that can be exchanged while the robot's software goes on (SRA: altering a robot's embodied format)."""

from robots.physical.body import Body, Pose, Readings


class ExchangeableBody:
    """What a robot's software senses and acts through, whichever body that is now. Implements `Body`."""

    def __init__(self, body: Body) -> None:
        self.body = body

    def set_velocity(self, linear_m_s: float, angular_rad_s: float) -> None:
        self.body.set_velocity(linear_m_s, angular_rad_s)

    def set_gripper(self, *, closed: bool) -> None:
        self.body.set_gripper(closed=closed)

    def get_position(self) -> Pose:
        return self.body.get_position()

    def run_sensors(self, sensors: frozenset[str]) -> None:
        self.body.run_sensors(sensors)

    def sense(self) -> Readings:
        return self.body.sense()
