"""What a shell offers."""

from harness.cli.flags.shared import names_of


def offered(kind, begun):
    """Names alone."""
    return [name for name, _ in names_of(kind)(begun)]


def test_names_of_plugins_are_offered(toys):
    """Those that begin as what is typed, each with its summary."""
    assert offered("simulators", "ide") == ["ideal"]
    assert all(summary for _, summary in names_of("rewards")(""))


def test_names_are_offered_behind_a_comma(toys):
    """The list stays as it is."""
    assert "arp,scaled" in offered("rewards", "arp,sc")
    assert offered("rewards", "no-such") == []


def test_bash_completes(harness, monkeypatch, subtests):
    """As bash asks, by the environment."""
    for words, name in [
        ("run --sim ide", "ideal"),
        ("run --algo wan", "wander"),
        ("run --reward scal", "scaled"),
        ("run --baseline spa", "sparse"),
        ("run --task fd", "fd100-reach"),
        ("run --robot fd", "fd100"),
        ("run --executor pro", "processes"),
        ("audit --reward ar", "arp"),
        ("parity --sim ide", "ideal"),
        ("parity --reference ide", "ideal"),
        ("parity --robot fd", "fd100"),
        ("transfer --to ide", "ideal"),
        ("audit --task fd", "fd100-reach"),
        ("audit --against spa", "sparse"),
        ("eta --baseline-reward ar", "arp"),
        ("eta --proposed-reward ar", "arp"),
        ("describe --robot fd", "fd100"),
    ]:
        with subtests.test(words=words):
            monkeypatch.setenv("_HARNESS_COMPLETE", "complete_bash")
            monkeypatch.setenv("COMP_WORDS", f"harness {words}")
            monkeypatch.setenv("COMP_CWORD", "3")
            assert name in harness().out.split()


def test_names_of_several_kinds_are_offered(toys):
    """As for ``harness describe``, which takes any."""
    offered = [name for begun in ("ide", "spa") for name, _ in names_of("simulators", "rewards")(begun)]
    assert offered == ["ideal", "sparse"]
