"""``harness new-plugin`` as it is typed."""


def test_package_is_written_and_the_next_commands_are_told(harness, tmp_path):
    """Three commands, which may be typed as they stand."""
    answer = harness("new-plugin reward zz-reward")
    assert answer.status == 0
    for line in ("pip install -e 'zz-reward[test]'", "pytest zz-reward", "harness audit --reward zz-reward"):
        assert f"\n  {line}\n" in answer.out
    assert "zz-reward/zz_reward/reward.py" in answer.out
    assert (tmp_path / "zz-reward" / "zz_reward" / "reward.py").is_file()


def test_kind_of_two_words_is_typed_as_one(harness, tmp_path):
    """Files have that word too; sentences have both."""
    assert "The log format is zz-log/zz_log/log.py" in harness("new-plugin log zz-log").out
    assert "A log format for fd100-harness" in (tmp_path / "zz-log" / "README.md").read_text()


def test_another_folder_may_be_named(harness, tmp_path):
    """It has to be there."""
    assert harness("new-plugin metric zz-metric --into mine").status == 2
    (tmp_path / "mine").mkdir()
    assert "pytest mine/zz-metric" in harness("new-plugin metric zz-metric --into mine").out
    assert (tmp_path / "mine" / "zz-metric" / "pyproject.toml").is_file()


def test_commands_hold_a_folder_with_a_blank(harness, tmp_path):
    """What is told can be typed."""
    (tmp_path / "my plugins").mkdir()
    out = harness("new-plugin metric zz-metric --into 'my plugins'").out
    assert "\n  pytest 'my plugins/zz-metric'\n" in out
    assert "\n  pip install -e 'my plugins/zz-metric[test]'\n" in out


def test_name_of_another_kind_is_free(harness):
    """A metric may be called as a reward is: nobody mixes them up."""
    assert harness("new-plugin metric arp").status == 0
