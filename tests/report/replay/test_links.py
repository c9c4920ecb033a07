"""Links from numbers to episodes."""

from dataclasses import replace

import numpy as np
import pytest

from harness.eta.behaviour_change import Change, Quantity
from harness.record.scene import Scene, SceneJoint, write_scene
from harness.report.replay.links import BASELINE, PROPOSED, EpisodeLinks, links_of
from harness.results import Results
from harness.results.replay import Show, shows_of

ENDS = (("reached", "time-out", "ground", "reached"), ("time-out",) * 4)
TIMES = ((1.0, 10.0, 10.0, 4.0), (10.0,) * 4)


@pytest.fixture
def show(recorded: Results) -> Show:
    """Four episodes that end and last as `ENDS` and `TIMES` say, of both sides."""
    (show,) = shows_of(recorded)
    sides = tuple(
        replace(
            side,
            episodes=tuple(
                it._replace(outcome=end, values={"success_rate": float(end == "reached"), "time_to_target": time})
                for it, end, time in zip(side.episodes, ends, times, strict=True)
            ),
        )
        for side, ends, times in zip(show.sides, ENDS, TIMES, strict=True)
    )
    return replace(show, numbers=(1, 3, 5, 9), sides=sides)


@pytest.fixture
def links(show: Show) -> EpisodeLinks:
    """Of the second comparison of a page."""
    return EpisodeLinks(2, show)


def change(name: str, unit: str, baseline: float | None, proposed: float | None) -> Change:
    """A measure and its means."""
    return Change(Quantity(name, unit, "lower", "deterministic"), baseline, proposed, None, 1)


def test_an_outcome_leads_to_the_first_episode_that_ended_so(links: EpisodeLinks):
    """The title names the episode, its seed and the outcome."""
    assert links.ending(BASELINE, "ground") == ("#replay-2-5", "Watch episode 5 of seed 0: ground")


def test_an_outcome_that_no_shown_episode_has_leads_nowhere(links: EpisodeLinks):
    """As one that only another seed has."""
    assert links.ending(PROPOSED, "ground") is None


def test_a_mean_leads_to_the_nearest_episode(links: EpisodeLinks):
    """Of its own side, whose value the title tells."""
    link = links.showing(BASELINE, change("time_to_target", "s", 4.4, 10.0))
    assert link == ("#replay-2-9", "Watch episode 9 of seed 0: time to target 4.00, reached")


def test_a_share_leads_to_an_episode_that_it_counts(links: EpisodeLinks):
    """However small it is."""
    link = links.showing(BASELINE, change("success_rate", "", 0.1, 0.0))
    assert link == ("#replay-2-1", "Watch episode 1 of seed 0: reached")


def test_a_measure_that_no_episode_has_leads_nowhere(links: EpisodeLinks):
    """Nor one without a mean."""
    assert links.showing(BASELINE, change("work", "J", 1.0, 1.0)) is None
    assert links.showing(BASELINE, change("time_to_target", "s", None, None)) is None


def test_success_leads_to_a_success_or_to_a_failure(links: EpisodeLinks):
    """Where nothing succeeds one sees how it fails."""
    told = {column: link.title for column, link in links.success.items()}
    assert told == {
        "success, baseline": "Watch episode 1 of seed 0: reached",
        "success, proposed": "Watch episode 1 of seed 0: time-out",
    }


def test_every_episode_has_a_link(links: EpisodeLinks):
    """With how it ended under both rewards."""
    assert [told for told, _ in links.all] == [
        "1: reached | time-out",
        "3: time-out",
        "5: ground | time-out",
        "9: reached | time-out",
    ]


def test_comparisons_have_the_links_of_their_shows(recorded: Results):
    """One without a show has none."""
    shows, combinations = shows_of(recorded), recorded.combinations
    (found,) = links_of(shows, combinations)
    assert found is not None
    assert (found.place, found.show) == (1, shows[0])
    assert links_of((), combinations) == [None]


def test_the_seed_that_ends_in_most_ways_is_shown(build):
    """Seed 1 alone has failures under the proposed reward."""
    results = build(reached={"arp": lambda seed: (8, 9) if seed == 1 else (8, 9, 10, 11)})
    scene = Scene("arm", (SceneJoint(np.eye(3, 4), np.array([0.0, 0.0, 1.0]), slides=False),), np.eye(3, 4), ())
    for cell in results.done_cells:
        write_scene(scene, results.store.cell_folder(cell))
    assert [side.seed for side in shows_of(results)[0].sides] == [1, 1]
