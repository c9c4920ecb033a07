from harness.cli.names import EXPLAINED
from harness.hookspecs import KINDS


def test_a_missing_library_is_shown_with_its_extra(harness, distant):
    """What cannot be used for want of a library says which extra brings it."""
    assert "not here [missing no_such_engine: pip install 'far-away[engine]']" in harness("describe simulators").out


def test_every_kind_is_explained(harness):
    """In words that nobody has to look up, with the flag that takes its names."""
    out = harness("describe").out
    assert set(EXPLAINED) == set(KINDS)
    assert all(f"{kind}: {told}" in out for kind, told in EXPLAINED.items())
    assert "NOTE" not in out
