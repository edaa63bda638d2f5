"""Instant actions that a vehicle is asked for: when they are due again, and under which ids they go."""

from collections.abc import Callable

from robots.adapters.vda5050.messages import Action, ActionParameter, BlockingType, Headed, InstantActions
from robots.adapters.vda5050.orders import ORDER_PREFIX
from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.clock import Clock

RESEND_S = 2.0
"""What the vehicle's state does not show is sent again after this time."""
SELDOM_S = 35.0
"""A factsheet is asked for as seldom once `OFTEN_ASKED` requests had no answer."""
OFTEN_ASKED = 5


class InstantRequests:
    """Of one vehicle. Who asks decides what is still needed; here is what was sent, and when."""

    def __init__(self, vehicle: VehicleId, clock: Clock, post: Callable[[Topic, Headed], None]) -> None:
        self._vehicle = vehicle
        self._clock = clock
        self._post = post
        self._sent_s: dict[str, float] = {}
        self._asked_s = float("-inf")
        self._sheet_asked_s = float("-inf")
        self._sheets_asked = 0

    def id_of(self, kind: str, number: int) -> str:
        """The id of the request of that number: the same after a restart."""
        return f"{ORDER_PREFIX}{kind}.{self._vehicle.serial_number}.{number}"

    def is_due(self, kind: str) -> bool:
        """False if it was sent less than `RESEND_S` ago."""
        return self._clock.now_s() - self._sent_s.get(kind, float("-inf")) >= RESEND_S

    def send(self, kind: str, action_id: str, **parameters: str) -> None:
        self._sent_s[kind] = self._clock.now_s()
        self._send(kind, action_id, **parameters)

    def forget(self, kind: str) -> None:
        """It has had its effect: the next one is due at once."""
        self._sent_s.pop(kind, None)

    def forget_all(self) -> None:
        self._sent_s = {}

    def once(self, kind: str) -> None:
        """A request without a trace in memory: its answer is a message."""
        self._send(kind, f"{ORDER_PREFIX}{kind}.{self._vehicle.serial_number}.at{self._clock.now_s():.3f}")

    def ask_for_state(self) -> None:
        if self._clock.now_s() - self._asked_s >= RESEND_S:
            self._asked_s = self._clock.now_s()
            self.once("stateRequest")

    def ask_anew(self) -> None:
        """A state may be asked for at once: the vehicle was away."""
        self._asked_s = float("-inf")

    def ask_for_factsheet(self) -> None:
        """Often at first, then now and then."""
        now_s = self._clock.now_s()
        interval_s = RESEND_S if self._sheets_asked < OFTEN_ASKED else SELDOM_S
        if now_s - self._sheet_asked_s >= interval_s:
            self._sheet_asked_s = now_s
            self._sheets_asked += 1
            self.once("factsheetRequest")

    def _send(self, kind: str, action_id: str, **parameters: str) -> None:
        given = tuple(ActionParameter(key=key, value=value) for key, value in parameters.items())
        action = Action(  # its blocking type is always NONE (§6.2.1)
            action_type=kind,
            action_id=action_id,
            blocking_type=BlockingType.NONE,
            action_parameters=given,
        )
        self._post(Topic.INSTANT_ACTIONS, InstantActions(actions=(action,)))
