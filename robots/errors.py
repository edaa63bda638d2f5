"""The errors of on-robot software."""


class RobotError(Exception):
    """Root of what on-robot software raises."""


class RepertoireError(RobotError):
    """Raised when a repertoire's data are malformed, or a packet does not fit them."""


class ExtensionError(RobotError):
    """Raised when what an installed package registered cannot be used; names the entry point and the package."""


class SensorFault(RobotError):
    """Raised when a reading is missing, not a number, or out of its possible range."""


class SensorOff(RobotError):
    """Raised when a percept is read whose sensor is off: a condition or stimulus does not declare that it needs it."""


class ResultError(RobotError):
    """Raised when a packet cannot bring a result; names the camera or quantity."""


class RuleError(RobotError):
    """Raised when a rule file cannot be used; names the file, the line and the column of each fault."""
