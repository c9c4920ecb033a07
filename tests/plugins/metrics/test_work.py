"""Mechanical work of an episode."""

from harness.record import EpisodeFacts
from harness.record.trace import with_episode_facts
from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import Work


def test_mean_over_the_finished_episodes():
    """However they ended; an env whose episode was left unfinished does not count."""
    trace = recorded_trace(0, ("reached", "ground", ""))
    trace["env"][:], trace["episode"][:] = trace["episode"].copy(), 0
    assert Work()(with_episode_facts(trace, EpisodeFacts(work=(1.0, 4.0, 100.0)))) == 2.5


def test_none_where_it_is_not_told():
    """Of an arm that jumps, or in a training."""
    assert Work()(with_episode_facts(recorded_trace(0, ("reached",)), EpisodeFacts())) is None
