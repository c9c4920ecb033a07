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
    """HARNESS_PLUGINS restricts what loads, and the others are shown as off; a name of no plugin is told."""
    monkeypatch.setenv("HARNESS_PLUGINS", "-simulators,-ryas")
    statuses = {plugin["name"]: plugin["status"] for plugin in json.loads(harness("plugins", "--json").out)["plugins"]}
    assert statuses["rewards"] == "ok"
    assert (statuses["simulators"], statuses["toys"]) == ("off", "ok")
    assert "conflict: HARNESS_PLUGINS names 'ryas', which is no plugin." in harness("plugins").out


def test_target_that_does_not_exist_makes_its_plugin_broken(harness, install):
    """Without importing what it stands in; what was meant is offered."""
    module = install(
        "typos",
        "import harness\n@harness.hookimpl\ndef register_rewards(register):\n"
        "    register('mine', __name__ + '_code:Mnie', summary='')\n",
        code="raise SystemExit\nclass Mine: ...\n",
    )
    (typos,) = [it for it in json.loads(harness("plugins", "--json").out)["plugins"] if it["name"] == "typos"]
    assert typos["status"] == "broken"
    told = f"Reward 'mine' of package typos 1.0: module '{module}_code' has no 'Mnie'. Did you mean 'Mine'?"
    assert typos["reason"] == told


def test_remarks_stand_below_the_plugin(harness, install):
    """What its author should change, though it works."""
    source = "import harness\n@harness.hookimpl\ndef register_rewards(register): pass\n"
    install("earlier", f"harness_api = 1\n{source}")
    out = harness("plugins").out
    assert "registers nothing\n  written for harness_api 1, this is 2: docs/renamed.md says what changed\n" in out
