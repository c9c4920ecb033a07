"""What a user reads who picks a reward."""

from harness.describe import describe_name
from tests.project import page_of
from tests.registered import REGISTRY

BUILT_IN = [name for name in REGISTRY.names("rewards") if REGISTRY.get("rewards", name).plugin == "rewards"]
PAGE = page_of("rewards")


def test_description_has_formula_and_source(subtests):
    """Every reward says what it computes, and from where, or that it is the project's own."""
    for name in BUILT_IN:
        with subtests.test(name=name):
            text = describe_name(REGISTRY, "rewards", name, "fd100")
            assert any(line.startswith("    ") and "=" in line for line in text.splitlines())
            assert "NOTE" in text or "ARP" in text or "of this project" in text


def test_page_has_a_section(subtests):
    """docs/rewards.md has a section and a row for every reward."""
    for name in BUILT_IN:
        with subtests.test(name=name):
            assert f"\n## `{name}`\n" in PAGE
            assert f"\n| `{name}` |" in PAGE


def test_contradictions_are_told(subtests):
    """Where the sources contradict one another, or say nothing, the description says so."""
    for name, told in [
        ("baseline-eq21", ["eq. 21", "ARP eq. 20", "the reverse of the code", "sqrt(6.25) - sqrt(4.25)"]),
        ("baseline", ["the other way round"]),
        ("relative", ["eq. 31", "sqrt(4.25)", "sqrt(6.25) - sqrt(4.25)"]),
        ("arp", ["k2 = 1.5", "k1 = 1, k2 = 2", "k2 = 1.1", "eq. 20", "larger I_P"]),
        ("adaptive", ["This project's own definition", "less thoughtful design"]),
        ("aarp", ["This project's own definition"]),
    ]:
        with subtests.test(name=name):
            text = " ".join(describe_name(REGISTRY, "rewards", name, "fd100").split())
            assert [phrase for phrase in told if phrase not in text] == []
