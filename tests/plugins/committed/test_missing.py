"""The cells of a combination that are not done."""

from harness_plugins.committed.markdown import missing_text


def test_failed_and_pending_cells_are_counted(build):
    """Of both rewards of the combination, and of no other."""
    ended = {("arp", 1): ("failed", "it broke"), ("baseline", 2): ("pending", ""), ("relative", 0): ("failed", "x")}
    results = build(proposed={"arp": (9, 30), "relative": (9, 30)}, ended=ended)
    told = {combination.proposed: missing_text(results, combination) for combination in results.combinations}
    assert told == {"arp": "1 failed, 1 pending of 6 cells", "relative": "1 failed, 1 pending of 6 cells"}


def test_nothing_is_said_where_all_are_done(build):
    """An empty text."""
    results = build()
    assert missing_text(results, results.combinations[0]) == ""


def test_null_control_counts_both_trainings_of_the_baseline(build):
    """Those with other seeds belong to it alone."""
    results = build(a_a=True, ended={("baseline", 0): ("failed", "it broke")})
    told = {combination.proposed: missing_text(results, combination) for combination in results.combinations}
    assert told == {"baseline": "1 failed of 6 cells", "arp": "1 failed of 6 cells"}
    results = build(a_a=True, ended={("baseline", 5): ("failed", "it broke")})
    told = {combination.proposed: missing_text(results, combination) for combination in results.combinations}
    assert told == {"baseline": "1 failed of 6 cells", "arp": ""}
