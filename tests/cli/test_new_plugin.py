"""``harness new-plugin`` as it is typed."""

import pytest

from harness_plugins.kit.new_plugin import kinds


def test_package_is_written_and_the_next_commands_are_told(harness, tmp_path):
    """Three commands, which may be typed as they stand."""
    answer = harness("new-plugin", "reward", "zz-reward")
    assert answer.status == 0
    for line in ("pip install -e 'zz-reward[test]'", "pytest zz-reward", "harness audit --reward zz-reward"):
        assert f"\n  {line}\n" in answer.out
    assert "zz-reward/zz_reward/reward.py" in answer.out
    assert (tmp_path / "zz-reward" / "zz_reward" / "reward.py").is_file()


def test_kind_of_two_words_is_typed_as_one(harness, tmp_path):
    """Files have that word too; sentences have both."""
    out = harness("new-plugin", "log", "zz-log").out
    assert "The log format is zz-log/zz_log/log.py" in out
    assert "A log format for fd100-harness" in (tmp_path / "zz-log" / "README.md").read_text()


def test_another_folder_may_be_named(harness, tmp_path):
    """It has to be there."""
    assert harness("new-plugin", "metric", "zz-metric", "--into", "mine").status == 2
    (tmp_path / "mine").mkdir()
    assert "pytest mine/zz-metric" in harness("new-plugin", "metric", "zz-metric", "--into", "mine").out
    assert (tmp_path / "mine" / "zz-metric" / "pyproject.toml").is_file()


def test_commands_hold_a_folder_with_a_blank(harness, tmp_path):
    """What is told can be typed."""
    (tmp_path / "my plugins").mkdir()
    out = harness("new-plugin", "metric", "zz-metric", "--into", "my plugins").out
    assert "\n  pytest 'my plugins/zz-metric'\n" in out
    assert "\n  pip install -e 'my plugins/zz-metric[test]'\n" in out


@pytest.mark.parametrize(
    "arguments",
    [
        ("exporter", "zz", "No kind of plugin 'exporter'"),
        ("reward", "Arp", "Did you mean 'arp'"),
        ("reward", "arp", "The name 'arp' is taken: there is a reward"),
        ("reward", "rewards", "The name 'rewards' is taken: there is a plugin"),
        ("command", "status", "The name 'status' is taken"),
        ("command", "export", "The name 'export' is taken"),
    ],
    ids=["kind", "name", "taken", "taken by a plugin", "own command", "plugin's command"],
)
def test_what_cannot_be_is_a_usage_error(harness, tmp_path, arguments):
    """One line, exit status 2, nothing written: two that claim one name stand in each other's way."""
    *given, told = arguments
    answer = harness("new-plugin", *given)
    assert (answer.status, answer.out, len(answer.err.splitlines())) == (2, "", 1)
    assert told in answer.err
    assert not list(tmp_path.iterdir())


def test_name_of_another_kind_is_free(harness):
    """A metric may be called as a reward is: nobody mixes them up."""
    assert harness("new-plugin", "metric", "arp").status == 0


def test_help_names_every_kind(harness):
    """Those that there are templates for."""
    out = harness("new-plugin", "--help").out
    assert all(kind in out for kind in kinds())
