import json


def test_every_plugin_is_shown_with_what_it_registered(harness):
    """`harness plugins` names third-party packages like built-in ones."""
    out = harness("plugins").out
    assert "toys  ok  toy-arm 1.0  (toy_arm)" in out
    assert "simulator mujoco" in out


def test_json_has_the_same(harness):
    """`--json` has a list of plugins and one of conflicts."""
    data = json.loads(harness("plugins", "--json").out)
    assert "toys" in {plugin["name"] for plugin in data["plugins"]}
    assert data["conflicts"] == []


def test_plugins_can_be_left_out(harness, monkeypatch):
    """HARNESS_PLUGINS restricts what loads, and the others are shown as off."""
    monkeypatch.setenv("HARNESS_PLUGINS", "rewards")
    statuses = {plugin["name"]: plugin["status"] for plugin in json.loads(harness("plugins", "--json").out)["plugins"]}
    assert statuses["rewards"] == "ok"
    assert statuses["simulators"] == "off"
