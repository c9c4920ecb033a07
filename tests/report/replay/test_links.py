"""Links from numbers to episodes."""

from dataclasses import replace

import numpy as np
import pytest

from harness.eta import Change, Quantity
from harness.record.scene import Scene, SceneJoint, write_scene
from harness.report.replay.section import EpisodeLinks, links_of
from harness.results.pairs import Met, Pairs, kinds_of
from harness.results.replay import shows_of

BASELINE, PROPOSED = range(2)
BOTH, FIRST, SECOND, NEITHER = range(4)
ENDS = (("reached", "time-out", "ground", "reached"), ("time-out",) * 4)
TIMES = ((1.0, 10.0, 10.0, 4.0), (10.0,) * 4)


@pytest.fixture
def show(recorded):
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
    met = tuple(Met(0, number, kind, 0.0) for number, kind in ((0, FIRST), (2, NEITHER), (4, NEITHER), (8, NEITHER)))
    pairs = Pairs(kinds_of("reach", "arp", "es"), met)
    return replace(show, numbers=(1, 3, 5, 9), sides=sides, pairs=pairs, first=2, kinds={NEITHER: 2, FIRST: 0})


@pytest.fixture
def links(show):
    """Of the second comparison of a page."""
    return EpisodeLinks(2, show)


def change(name, unit, baseline, proposed):
    """A measure and its means."""
    return Change(Quantity(name, unit, "lower", "deterministic"), baseline, proposed, None, 1)


def test_an_outcome_leads_to_the_first_episode_that_ended_so(links):
    """The title names the episode, its seed and the outcome."""
    assert links.ending(BASELINE, "ground") == ("#replay-2-5-0", "Watch episode 5 of seed 0: ground")


def test_an_outcome_that_no_shown_episode_has_leads_nowhere(links):
    """As one that only another seed has."""
    assert links.ending(PROPOSED, "ground") is None


def test_a_mean_leads_to_the_nearest_episode(links):
    """Of its own side, whose value the title tells."""
    link = links.showing(BASELINE, change("time_to_target", "s", 4.4, 10.0))
    assert link == ("#replay-2-9-0", "Watch episode 9 of seed 0: time to target 4.00, reached")


def test_a_share_leads_to_an_episode_that_it_counts(links):
    """However small it is."""
    link = links.showing(BASELINE, change("success_rate", "", 0.1, 0.0))
    assert link == ("#replay-2-1-0", "Watch episode 1 of seed 0: reached")


def test_a_measure_that_no_episode_has_leads_nowhere(links):
    """Nor one without a mean."""
    assert links.showing(BASELINE, change("work", "J", 1.0, 1.0)) is None
    assert links.showing(BASELINE, change("time_to_target", "s", None, None)) is None


def test_every_kind_of_pair_has_a_link(links):
    """With its share, the most frequent one first, to the typical pair of it."""
    assert links.kinds == [
        ("neither reaches: 3 of 4 pairs", ("#replay-2-5-0", "Watch episode 5 of seed 0: ground | time-out")),
        ("only the baseline reaches: 1 of 4 pairs", ("#replay-2-1-0", "Watch episode 1 of seed 0: reached | time-out")),
    ]


def test_the_still_is_the_typical_pair(links):
    """Its share is said, and how many end otherwise, one of which is a link away."""
    still = links.still
    assert (still.share, still.ends) == ("neither reaches: 3 of 4 pairs", ("baseline: ground", "arp: time-out"))
    assert (still.link.address, still.otherwise) == ("#replay-2-5-0", "1 of 4 end otherwise")
    assert still.other is not None
    assert still.other.address == "#replay-2-1-0"


def test_where_all_end_alike_nothing_ends_otherwise(show):
    """No link to what does not occur."""
    assert show.pairs is not None
    alike = replace(show.pairs, met=tuple(it._replace(kind=NEITHER) for it in show.pairs.met))
    still = EpisodeLinks(1, replace(show, pairs=alike, kinds={NEITHER: 2})).still
    assert (still.share, still.otherwise, still.other) == ("neither reaches: 4 of 4 pairs", "", None)


def test_comparisons_have_the_links_of_their_shows(recorded):
    """One without a show has none."""
    shows, combinations = shows_of(recorded), recorded.combinations
    (found,) = links_of(shows, combinations)
    assert found is not None
    assert (found.place, found.show) == (1, shows[0])
    assert links_of((), combinations) == [None]


def test_pairs_of_all_seeds_are_counted_and_shown(build):
    """Each side reaches as often, in each seed, as its success says."""
    results = build(reached={"arp": lambda seed: (8, 9) if seed == 1 else (8, 9, 10, 11)})
    scene = Scene("arm", (SceneJoint(np.eye(3, 4), np.array([0.0, 0.0, 1.0]), slides=False),), np.eye(3, 4), ())
    for cell in results.done_cells:
        write_scene(scene, results.store.cell_folder(cell))
    show = shows_of(results)[0]
    assert show.pairs is not None
    for side, kinds in zip(show.sides, ({BOTH, FIRST}, {BOTH, SECOND}), strict=True):
        for cell in (it for it in results.done_cells if it.reward.label == side.title.partition(": ")[2]):
            ended = [it.kind in kinds for it in show.pairs.met if it.seed == cell.seed]
            assert np.mean(ended) == pytest.approx(results.measured(cell).manners["deterministic"]["success_rate"])
    assert [set(side.seeds) for side in show.sides] == [set(results.combinations[0].seeds)] * 2
