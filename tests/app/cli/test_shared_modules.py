"""What the child processes of a service share depends on what it starts."""

import pytest

from app.cli.shared_modules import PLANNING, SIMULATING, shared_by_service


@pytest.mark.parametrize(
    ("broker", "environment", "shared"),
    [
        pytest.param(None, {}, [PLANNING, SIMULATING], id="everything embedded"),
        pytest.param("mqtt://127.0.0.1", {}, [PLANNING], id="worlds behind a broker"),
        pytest.param(None, {"MACTA_BROKER_URL": "mqtt://127.0.0.1"}, [PLANNING], id="broker by environment"),
        pytest.param(None, {"MACTA_PLANNING_PROCESSES": "0"}, [SIMULATING], id="workers plan"),
        pytest.param("mqtt://127.0.0.1", {"MACTA_PLANNING_PROCESSES": "0"}, [], id="only the API"),
    ],
)
def test_a_service_shares_what_its_processes_need(
    monkeypatch: pytest.MonkeyPatch, broker: str | None, environment: dict[str, str], shared: list[str]
) -> None:
    for name in ("MACTA_BROKER_URL", "MACTA_PLANNING_PROCESSES"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert shared_by_service(broker) == shared
