import pytest
from hypothesis import given, strategies as st

from harness.errors import UsageError
from harness.results.logs.names import labels_of, sort_by_template, sort_names, templates_of

LAYOUTS = (
    "{reward}/{seed}",
    "{reward}_seed{seed}",
    "PPO_{reward}_{seed}",
    "ppo/{reward}/Pendulum-v1_{seed}",
    "reward={reward},seed={seed}",
    "wandb.csv/{reward}-seed{seed}",
    "Pendulum-v1__{reward}__{seed}__17140000{seed:02d}",
    "seed_{seed}/{reward}",
    "{seed}/{reward}/run",
    "2024-05-01_10-20-{seed:02d}/{reward}_{seed}",
    "{reward}_{seed}/PPO_1",
)
REWARDS = st.lists(st.sampled_from(["base", "prop", "dense", "gentle", "sparse"]), min_size=2, unique=True)
SEEDS = st.lists(st.integers(0, 99), min_size=2, max_size=6, unique=True)


def told(names):
    """By name, the reward and the seed."""
    return {name: (of.reward, of.seed) for name, of in zip(names, sort_names(names), strict=True)}


@given(layout=st.sampled_from(LAYOUTS), rewards=REWARDS, seeds=SEEDS)
def test_usual_layouts_are_taken_apart(layout, rewards, seeds):
    """Whatever the rewards and the seeds are called, the names of both come back."""
    names = {layout.format(reward=reward, seed=seed): (reward, seed) for reward in rewards for seed in seeds}
    assert told(list(names)) == names


@given(layout=st.sampled_from(LAYOUTS), rewards=REWARDS, seeds=SEEDS, data=st.data())
def test_the_order_of_names_says_nothing(layout, rewards, seeds, data):
    """A folder that lists its files in another order is sorted the same."""
    names = [layout.format(reward=reward, seed=seed) for reward in rewards for seed in seeds]
    assert told(data.draw(st.permutations(names))) == told(names)


def test_what_is_a_seed_and_what_is_not(subtests):
    """Versions, decimal numbers and numbers that all share belong to the reward, or to nothing."""
    rows = [
        (["v1/0", "v1/1", "v2/0", "v2/1"], ["v1", "v1", "v2", "v2"], [0, 1, 0, 1]),
        (["k1_0", "k1_1", "k2_0", "k2_1"], ["k1", "k1", "k2", "k2"], [0, 1, 0, 1]),
        (["arp:k2=0.5_1", "arp:k2=0.5_2", "base_1", "base_2"], ["arp:k2=0.5"] * 2 + ["base"] * 2, [1, 2, 1, 2]),
        (
            ["base1", "base2", "base_shaped1", "base_shaped2"],
            ["base", "base", "base_shaped", "base_shaped"],
            [1, 2] * 2,
        ),
        (["ppo/Pendulum-v1_1", "ppo/Pendulum-v1_2"], ["Pendulum-v1"] * 2, [1, 2]),
        (["base/20240501-1200", "base/20240502-1230"], ["base", "base"], [None, None]),
        (["ppo/T_1/0", "ppo/T_2/0", "ppo/T_fast_1/0", "ppo/T_fast_2/0"], ["T", "T", "T_fast", "T_fast"], [1, 2] * 2),
        (["0", "1"], ["", ""], [0, 1]),
        (["base", "prop"], ["base", "prop"], [None, None]),
        (["base_0", "base_1", "prop_7"], ["base", "base", "prop"], [0, 1, 7]),
    ]
    for names, rewards, seeds in rows:
        with subtests.test(names=names, rewards=rewards, seeds=seeds):
            found = sort_names(names)
            assert [it.reward for it in found] == rewards
            assert [it.seed for it in found] == seeds


def test_labels_keep_a_word_where_one_begins_like_another():
    """``base`` and ``base_shaped`` begin alike: nothing is cut, or the first one would have no name."""
    assert labels_of(["base", "base_shaped"]) == ["base", "base_shaped"]


@pytest.mark.parametrize(
    ("template", "name", "found"),
    [
        ("{reward}/{seed}", "runs/base/0", ("base", 0, "runs/base/0")),
        ("*_{reward}_s{seed}", "x_base_s3/deep/monitor", ("base", 3, "x_base_s3")),
        ("{reward}_{seed}", "my_base_v2_1", ("my_base_v2", 1, "my_base_v2_1")),
        ("{reward}", "base/0", ("base", None, "base")),
        ("{reward}/*", "base/0", ("base", None, "base/0")),
    ],
)
def test_a_template_says_how_names_are_made(template, name, found):
    """The reward, the seed, and the part of the name that is one training."""
    assert sort_by_template(template, [name]) == [found]


@pytest.mark.parametrize(
    ("places", "folder", "each_file"),
    [
        (["base", "prop"], "{reward}", "{reward}/{seed}"),
        (["base_1", "base_2", "prop_1"], "{reward}_{seed}", "{reward}_*/*"),
        (["base/seed_1", "base/seed_2", "prop/seed_1"], "{reward}/seed_{seed}", "{reward}/seed_*/*"),
        (["ppo/base", "ppo/prop"], "*/{reward}", "*/{reward}/{seed}"),
    ],
)
def test_templates_say_what_numbered_files_are(places, folder, each_file):
    """One for each reading; each makes as many trainings as there are folders, or files."""
    assert {(it.folder, it.each_file) for it in templates_of(places)} == {(folder, each_file)}
    files = [f"{place}/{number}" for place in places for number in range(2)]
    assert len({it.place for it in sort_by_template(folder, files)}) == len(places)
    assert len({it.place for it in sort_by_template(each_file, files)}) == len(files)


@pytest.mark.parametrize("template", ["{seed}", "{reward}/{seed}/{seed}", "{reward}-{seed}"])
def test_a_template_that_cannot_say_it_is_refused(template):
    """Without a reward, with two seeds, or of other names: the message shows the template."""
    with pytest.raises(UsageError, match="--sort"):
        sort_by_template(template, ["base/0"])
