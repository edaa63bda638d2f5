"""How the scripts stand that a robot was given, of the last ones."""

from collections.abc import Mapping

from robots.wire import ScriptState

ENDED = (ScriptState.FINISHED, ScriptState.FAILED, ScriptState.CANCELLED)
KEPT_STATES = 1024
"""How a script ended is forgotten after so many others."""


class Standing:
    """Each script's state, the newest noted last."""

    def __init__(self) -> None:
        self._states: dict[str, ScriptState] = {}

    def __contains__(self, script_id: str) -> bool:
        return script_id in self._states

    def of(self, script_id: str) -> ScriptState | None:
        """None for a script that is not known."""
        return self._states.get(script_id)

    def note(self, script_id: str, state: ScriptState) -> None:
        self._states[script_id] = state
        if len(self._states) > KEPT_STATES:
            del self._states[next(iter(self._states))]

    def memory(self) -> dict[str, ScriptState]:
        return dict(self._states)

    def recall(self, states: Mapping[str, ScriptState]) -> None:
        self._states = dict(states)

    def why_not(self, script_id: str) -> str:
        """Why nothing can be done about a script that is not under way, in words."""
        known = self.of(script_id)
        return f"script {script_id} has ended: {known}" if known else f"no script {script_id} here"
