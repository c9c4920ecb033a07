"""What HARNESS_PLUGINS says of each plugin."""

import pytest

from harness.registry.chosen_plugins import VARIABLE, Wanted
from harness.registry.spec import OURS


def _loads(monkeypatch: pytest.MonkeyPatch, value: str | None, *plugin: str) -> bool:
    monkeypatch.delenv(VARIABLE, raising=False)
    if value is not None:
        monkeypatch.setenv(VARIABLE, value)
    return not Wanted.from_environment().why_off(*plugin)


def test_third_party_plugin(subtests: pytest.Subtests):
    """By its entry point, its distribution or both; a minus leaves out, and wins."""
    rows = [
        (None, True),
        ("", False),
        ("clash", True),
        ("other", False),
        ("-clash", False),
        ("-other", True),
        (" -other , -more ", True),
        ("other,-clash", False),
        ("clash,-clash", False),
        ("-clash-algo", False),
        ("-Clash_Algo/clash", False),
        ("clash-algo/clash", True),
        ("-other/clash", True),
    ]
    for value, loads in rows:
        with subtests.test(value=value, loads=loads), pytest.MonkeyPatch.context() as monkeypatch:
            assert _loads(monkeypatch, value, "clash", "Clash_Algo") == loads


@pytest.mark.parametrize(
    ("value", "loads"), [("", True), ("clash", True), ("-clash", True), ("-rewards", False), (f"-{OURS}/tasks", True)]
)
def test_built_in_plugin_stays_unless_it_is_left_out(monkeypatch: pytest.MonkeyPatch, value: str, loads: bool):
    """Whoever names one plugin does not lose the simulators."""
    assert _loads(monkeypatch, value, "rewards", OURS) == loads


def test_name_of_no_plugin_is_told(monkeypatch: pytest.MonkeyPatch):
    """A mistyped one leaves nothing out."""
    monkeypatch.setenv(VARIABLE, "-clsh,one")
    told = Wanted.from_environment().unknown([("clash", "clash-algo"), ("one", "ones")])
    assert told == ["HARNESS_PLUGINS names 'clsh', which is no plugin. Did you mean 'clash'?"]
