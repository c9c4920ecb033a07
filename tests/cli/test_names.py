from harness.cli.names import EXPLAINED
from harness.hookspecs import KINDS


def test_every_kind_is_listed(harness):
    """`harness describe` shows each kind with its names and summaries."""
    out = harness("describe").out
    for kind in KINDS:
        assert f"{kind}:" in out
    assert "accelerated reward policy" in out


def test_one_kind_can_be_asked_for(harness):
    """`harness describe rewards` shows rewards alone."""
    out = harness("describe", "rewards").out
    assert "baseline" in out
    assert "simulators" not in out


def test_an_unknown_kind_names_the_nearest(harness):
    """A wrong kind ends with status 2 and the nearest match."""
    answer = harness("describe", "rewadrs")
    assert answer.status == 2
    assert "Did you mean 'rewards'?" in answer.err


def test_a_missing_library_is_shown_with_its_extra(harness, distant):
    """What cannot be used for want of a library says which extra brings it."""
    assert "not here [missing no_such_engine: pip install 'far-away[engine]']" in harness("describe", "simulators").out


def test_every_kind_is_explained(harness):
    """In words that nobody has to look up, with the flag that takes its names."""
    out = harness("describe").out
    assert set(EXPLAINED) == set(KINDS)
    assert all(f"{kind}: {told}" in out for kind, told in EXPLAINED.items())
    assert "NOTE" not in out


def test_an_option_of_a_plugin_is_no_command_that_is_listed(harness):
    """`harness report--summary` cannot be typed: the plugin writes what an option of ours asks for."""
    out = harness("describe", "commands").out
    assert "  export " in out
    assert "report--" not in out
