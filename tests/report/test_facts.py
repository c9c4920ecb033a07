"""What was so in the cells that ran."""

from dataclasses import replace

from harness.report import shared_facts


def test_shared_facts_stand_once(build):
    """What is equal in all cells stands once, without a count; two rewards have two sources."""
    facts = shared_facts(build().manifests)
    assert [fact[1:] for fact in facts if fact.name == "numpy"] == [("2.4.0", "")]
    assert {"source of baseline", "source of arp"} <= {fact.name for fact in facts}


def test_differing_facts_are_all_listed(build):
    """Where cells differ, every value stands with the number of its cells; cells that never ran do not count."""
    first, *others = build(ended={("arp", 2): ("pending", "")}).manifests
    moved = replace(first, environment={**first.environment, "commit": "fedcba"})
    facts = [fact[1:] for fact in shared_facts([moved, *others]) if fact.name == "commit"]
    assert facts == [("fedcba", "1 of 5 cells"), ("0123456789abcdef", "4 of 5 cells")]
