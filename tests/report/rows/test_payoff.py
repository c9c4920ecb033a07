"""What the rewards pay for, beside what the robot did."""

from harness.report import Payoffs, Report, write_html
from harness.report.rows.returns import payoff_story

TEMPTED = Payoffs(
    ("Not finishing pays more than finishing.",), {"finish": 1.0, "creep": 9.0}, {"finish": 1.0, "creep": 0.0}
)
SOUND = Payoffs(("Finishing pays most.",), {"finish": 2.0, "creep": 1.0}, {"finish": 1.0, "creep": 0.0})
UNKNOWN = Payoffs(("Not known: there is no robot 'x'",), {}, {})


def audits(**by_reward):
    """In the place of the experiments here."""
    return {("fd100", "fd100-reach", label): payoffs for label, payoffs in by_reward.items()}


def test_verdict_is_connected_to_what_the_robot_did(one):
    """Every failure here is a time-out."""
    story = payoff_story(one, audits(baseline=TEMPTED, arp=SOUND))
    assert story.sentences[0].startswith(
        "baseline: Not finishing pays more than finishing. The robot that learned from it"
    )
    assert "ran out of time in 25.0% of the episodes; on average it came as near as 0.04 m" in story.sentences[0]


def test_policies_are_ordered_by_what_the_proposed_reward_pays(build):
    """The best first, both rewards beside one another."""
    (combination,) = build().combinations
    story = payoff_story(combination, audits(baseline=TEMPTED, arp=SOUND))
    assert story.grid.rows == [("finish", "100%", "1.00", "2.00"), ("creep", "0%", "9.00", "1.00")]


def test_reason_stands_where_a_reward_could_not_be_asked(one):
    """And no row."""
    story = payoff_story(one, audits(baseline=UNKNOWN, arp=UNKNOWN))
    assert story.sentences == tuple(f"{name}: Not known: there is no robot 'x'" for name in ("baseline", "arp"))
    assert story.grid.rows == []


def test_nobody_asked_no_story(one):
    """The page says nothing of it."""
    assert payoff_story(one, {}) is None


def test_page_tells_the_story(build, tmp_path):
    """Under its heading."""
    write_html(Report(build()), tmp_path / "report.html", audits(baseline=TEMPTED, arp=SOUND))
    page = (tmp_path / "report.html").read_text()
    assert "What the rewards pay for" in page
    assert (
        page.index('id="number"')
        < page.index("arp: Finishing pays most.")
        < page.index("Accumulated reward of every training")
    )
