"""A search as a user writes it."""

import pytest

from harness.errors import UsageError
from harness_plugins.tune.tuning import FIRST_SEED, check_tuning, read_tuning, resolve


def test_rewards_are_the_baseline_and_the_proposed_ones(make_setup):
    """One search of all by default, one search each with per_reward; a reward named twice is tuned once."""
    setup = make_setup(reward="arp,baseline,arp:k2=3")
    assert [[r.label for r in rewards] for rewards in setup.searches] == [["baseline", "arp", "arp:k2=3"]]
    setup = make_setup(reward="arp", per_reward=True)
    assert [[r.label for r in rewards] for rewards in setup.searches] == [["baseline"], ["arp"]]


def test_seeds_are_apart_from_those_of_a_run(make_setup):
    """A run counts from 0; a search from a million."""
    assert make_setup(seeds=3).seeds == [FIRST_SEED, FIRST_SEED + 1, FIRST_SEED + 2]
    assert FIRST_SEED == 1_000_000


def test_trials_alone_do_not_make_another_search(make_setup):
    """More trials go on with the same; any other key is another search."""
    assert make_setup(trials=9).id == make_setup(trials=4).id
    assert make_setup(steps=4).id != make_setup().id
    assert make_setup(search={"effort": "0..0.9"}).id != make_setup().id


def test_file_has_the_same_keys(toys, make_setup, tmp_path):
    """A TOML file with a table [search] is the same search; an override wins."""
    path = tmp_path / "tuning.toml"
    path.write_text(
        'sim = "ideal"\nalgo = ["sweep"]\nreward = "arp"\ntask = "fd100-reach:epsilon=0.2,horizon=5"\nsteps = 9\n'
        'seeds = 1\nvalidation_episodes = 10\n[search]\neffort = "0..1"\n'
    )
    assert resolve(read_tuning(path, {"steps": 2}), toys).keys == make_setup().keys


def test_what_a_folder_says_reads_as_the_same_search(toys, make_setup):
    """The keys with everything resolved give the same keys again."""
    setup = make_setup(algo="sweep:mode=wild", search={"effort": "0..1", "layers": "4|8x8"})
    assert resolve(check_tuning(setup.keys), toys).keys == setup.keys


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"sim": ""}, "Search names no sim: give --sim NAME, or the key 'sim' in a file"),
        ({"sim": "ideal,stuck"}, "--sim names 2: a search is of one simulator"),
        ({"algo": "sweep,wander"}, "--algo names 2: a search is of one algorithm"),
        ({"algo": "sweep:num_envs=3"}, "Nothing to search: steps=2 is not a multiple of the 3 envs"),
        ({"algo": "sweeep"}, "Did you mean 'sweep'?"),
        ({"reward": "arb"}, "Did you mean 'arp'?"),
        ({"trials": 0}, "trials=0: Input should be greater than 0"),
        ({"seeds": 0}, "seeds=0"),
        ({"pruner": "hyperband"}, "Input should be 'median' or 'none'"),
        ({"learning_rate": 1}, "no parameter 'learning_rate'"),
        ({"search": {"efort": "0..1"}}, "Did you mean 'effort'?"),
        ({"search": {"effort": 0.5}}, "search 'effort=0.5': one value is no search"),
        ({"search": "effort=0..1"}, "search='effort=0..1': write a table [search] with a line for each parameter"),
    ],
    ids=str,
)
def test_what_cannot_be_searched_is_refused(make_setup, keys, told):
    """One line, before anything is written."""
    with pytest.raises(UsageError) as refused:
        make_setup(**keys)
    assert told in str(refused.value)


def test_missing_file_is_named(tmp_path):
    """Of a file that is not there, and of one that is no TOML."""
    with pytest.raises(UsageError, match="No tuning file"):
        read_tuning(tmp_path / "none.toml", {})
    (tmp_path / "bad.toml").write_text("= 3")
    with pytest.raises(UsageError, match="cannot be read"):
        read_tuning(tmp_path / "bad.toml", {})
