"""The radio between the shared link and one robot: it loses, delays, reorders and repeats, in the world's time.

What becomes of a message follows from the seed, the robot, the way, the world's time and how many went before it, so a
world that is taken up again needs no random stream of its radio. What is in the air when the process ends is lost; to
send again is the ends' business.
"""

import heapq
from collections import Counter
from collections.abc import Sequence
from enum import StrEnum
from hashlib import blake2b

from robots.wire import Message, Telemetry
from robots.world import LinkSpec, WorldFile

WHOLE = 2.0**64
AIR_HOLDS = 1000
"""So many messages may be under way each way before telemetry, which is never kept, is not sent any more."""


class Way(StrEnum):
    UP = "up"
    """From the robot."""
    DOWN = "down"
    """To the robot."""


class Radio:
    """One robot's radio. Times are the world's and do not go back."""

    def __init__(self, link: LinkSpec = LinkSpec(), *, robot: str = "", seed: int = 0) -> None:  # noqa: B008
        self.link = link
        self._name = f"{seed}/{robot}"
        self._air: dict[Way, list[tuple[float, int, Message]]] = {Way.UP: [], Way.DOWN: []}
        self._sent: Counter[str] = Counter()
        self._order = 0

    def in_contact(self, at_s: float) -> bool:
        return self.link.in_contact(at_s)

    def send(self, way: Way, message: Message, now_s: float) -> None:
        """It leaves now. Whether and when it arrives is the radio's to say."""
        kind = "telemetry" if isinstance(message.body, Telemetry) else "letter"
        if kind == "telemetry" and len(self._air[way]) >= AIR_HOLDS:
            return
        lost, *late, again = self._draw(f"{way}/{kind}", now_s)
        if lost < self.link.loss or not self.in_contact(now_s):
            return
        copies = late if again < self.link.duplication else late[:1]
        for part in copies:
            arrives_s = now_s + self.link.light_time_s + self.link.delay_s + part * self.link.jitter_s
            if self.in_contact(arrives_s):
                self._order += 1
                heapq.heappush(self._air[way], (arrives_s, self._order, message))

    def arrived(self, way: Way, now_s: float) -> Sequence[Message]:
        """What has come by now, in the order of its arrival."""
        air, come = self._air[way], []
        while air and air[0][0] <= now_s:
            come.append(heapq.heappop(air)[2])
        return come

    def _draw(self, stream: str, now_s: float) -> tuple[float, float, float, float]:
        """Four numbers in [0, 1). Telemetry has a stream of its own, for how much of it is sent is the wall clock's."""
        if self.link.is_sure:
            return 0.0, 0.0, 0.0, 0.0
        self._sent[stream] += 1
        drawn = blake2b(
            f"{self._name}/{stream}/{now_s:.6f}/{self._sent[stream]}".encode(), digest_size=32
        ).digest()
        one, two, three, four = (
            int.from_bytes(drawn[at : at + 8], "little") / WHOLE for at in range(0, 32, 8)
        )
        return one, two, three, four


def radios_of(world: WorldFile, seed: int) -> dict[str, Radio]:
    """Every robot's, as the world file says."""
    return {spec.name: Radio(world.link_of(spec), robot=spec.name, seed=seed) for spec in world.robots}
