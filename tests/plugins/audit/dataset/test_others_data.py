"""Data sets as others write them: each answer is that of pairs counted one by one, or the data set is refused."""

import copy
import json
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.random import default_rng

from harness.errors import SchemaError
from harness.payoff.dataset.step_by_step import Unseen
from harness.recorder.sealed import Sealer
from harness_plugins.audit import audit_dataset
from tests.plugins.audit.dataset.test_dataset_audit import AGAINST, CANNOT_TELL, RANKS
from tests.record.dataset.frames import info_of, write_frames
from tests.record.dataset.written import episode, write_minari
from tests.refusals import refused

STEPS = 10
EVEN, LATE = np.arange(40) % 2 == 0, np.arange(20) >= 10
VERSIONS = pytest.mark.parametrize("version", ["v2.1", "v3.0"])


def share_of_pairs(paid, success, tasks=None):
    """The share of pairs of a success and a failure in which the success is paid more; ties count half."""
    tasks = [0] * len(paid) if tasks is None else tasks
    scores = [
        (paid[one] > paid[other]) + 0.5 * (paid[one] == paid[other])
        for one in range(len(paid))
        for other in range(len(paid))
        if success[one] and not success[other] and tasks[one] == tasks[other]
    ]
    return sum(scores) / len(scores)


def made(number, reward, **columns):
    """An episode of LeRobot: numbers that are drawn, and columns of a value for each frame or one for all."""
    rng, steps = default_rng(number), len(reward)
    seen = {"observation.state": rng.normal(size=(steps, 3)), "action": rng.normal(size=(steps, 2))}
    columns = {key.replace("__", "."): np.broadcast_to(value, steps) for key, value in columns.items()}
    return {**seen, "next.reward": reward, **columns}


def last(success, steps=STEPS):
    """True in the last frame alone."""
    return np.arange(steps) == (steps - 1 if success else steps)


def terminal(number):
    """-1 a frame, +100 in the last frame of a success, which takes longer."""
    success = EVEN[number]
    ends = last(success, 12 + 6 * success + number % 5)
    return made(number, -1.0 + 100.0 * ends, next__success=ends)


def labelled(labels, **more):
    """Episodes of which the pay is their number, with a label in every frame."""
    return [made(it, np.full(STEPS, it * 1.0), next__success=label, **more) for it, label in enumerate(labels)]


TERMINAL = [terminal(number) for number in range(40)]
UNTOLD = [made(number, np.full(STEPS, number * 1.0)) for number in range(20)]


def without_pay(episodes):
    """Nothing is recorded by which pay could be judged."""
    return [{key: it for key, it in one.items() if key != "next.reward"} for one in episodes]


@pytest.fixture
def write(tmp_path):
    """Writes a LeRobot data set."""
    return lambda episodes, *how, **more: write_frames(tmp_path / "d", episodes, *how, **more)


def ask(folder, **asked):
    """The audit of a LeRobot data set."""
    return audit_dataset(f"lerobot:{folder}", **asked)


def told(found):
    """Successes, failures, and how often a success is paid more."""
    return found.successes, found.failures, found.rewards[0].by_success.value


def says(found, text):
    """Whether a note does."""
    return any(text in line for line in found.notes)


def rewrite(folder, name, change):
    """Change a column of the one file."""
    (path,) = folder.glob("data/*/*.parquet")
    table = pq.read_table(path)
    rows = table[name].to_pylist()
    kind = change(rows)
    pq.write_table(table.set_column(table.column_names.index(name), name, pa.array(rows, kind)), path)


@VERSIONS
def test_the_last_frame_s_pay_counts(write, version):
    """A verdict at the end is what decides."""
    (found,) = ask(write(TERMINAL, version)).rewards
    assert found.by_success.value == share_of_pairs([it["next.reward"].sum() for it in TERMINAL], EVEN) == 1.0
    assert found.by_success.answer == RANKS


def test_a_function_that_needs_the_next_observation_gets_no_word_where_the_last_step_decides(write):
    """It is paid -1 a step here and cannot be asked for its verdict at the end; one that looks at the info can."""
    folder = write(TERMINAL)
    rewards = {
        "arrives": lambda o, a, n, i: 99.0 if n[0] > 1e9 else -1.0,
        "told": lambda o, a, n, info: 100.0 * info["next.success"] - 1.0,
    }
    arrives, sees = ask(folder, rewards=rewards).rewards
    assert arrives.by_success.value < 0.2
    assert arrives.by_success.answer == CANNOT_TELL
    assert "cannot be paid the last step" in arrives.by_success.reason
    assert arrives.unpaid == ("not paid the last step of 40 episodes, since it looks at what came then",)
    assert (sees.by_success.value, sees.by_success.answer, sees.unpaid) == (1.0, RANKS, ())


def test_a_function_that_could_pay_anything_in_the_step_that_succeeds_gets_no_word(write):
    """Nothing is recorded by which its pay could be judged."""
    (found,) = ask(write(without_pay(TERMINAL)), rewards={"late": lambda o, a, n, i: -1.0 - 0.0 * n[0]}).rewards
    assert (found.by_success.answer, found.by_success.low is None) == (CANNOT_TELL, False)
    assert "looks at next_observation" in found.by_success.reason


def test_a_function_gets_its_word_where_the_last_step_cannot_turn_it(write):
    """Success shows earlier, and one step more moves no episode past another."""
    episodes = [
        made(it, np.full(STEPS, it % 2), next__success=np.arange(STEPS) > (5 if it % 2 else 99)) for it in range(40)
    ]
    for number, one in enumerate(episodes):
        one["observation.state"][:, 0] = number % 2 + 0.001 * number
    (found,) = ask(write(episodes), rewards={"place": lambda o, a, n, i: float(n[0])}).rewards
    assert (found.by_success.value, found.by_success.answer) == (1.0, RANKS)


def test_an_episode_of_which_no_step_can_be_paid_is_no_pay_of_0(write):
    """An episode of one frame, and a function that needs the next one: the others are compared without it."""
    runs = [made(it, [0.0] * steps, next__success=last(it < 3, steps)) for it, steps in enumerate([3] * 6 + [1])]
    (answer,) = ask(write(runs), rewards={"needs": lambda now, did, then, info: -float(then[0] ** 2)}).rewards
    assert (answer.by_success.above, answer.by_success.below) == (3, 3)


def test_a_copy_of_what_is_not_known_is_no_look_at_it():
    """Functions get copies of their own once torch is imported, or a step holds what only a copy protects."""
    unseen = Unseen()
    assert copy.deepcopy(Sealer().seal(unseen)) is unseen
    assert not unseen.looked_at


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int64, np.float32, np.float64])
def test_labels_are_true_and_false_in_every_type(write, kind):
    """The same answer."""
    assert told(ask(write(labelled(LATE.astype(kind))))) == (10, 10, 1.0)


@pytest.mark.parametrize("unknown", [np.nan, -1.0])
def test_a_label_that_is_not_known_leaves_the_episode_out(write, unknown):
    """With the number of them."""
    labels = np.array([0.0, 1.0, unknown] * 10)
    found = ask(write(labelled(labels)))
    kept = np.flatnonzero(np.arange(30) % 3 != 2)
    assert told(found) == (10, 10, pytest.approx(share_of_pairs(kept, labels[kept] == 1.0)))
    assert "Episodes left out, since nothing says whether they succeeded: 10" in found.notes


def test_a_probability_is_refused_with_what_to_type(write):
    """And read with a threshold."""
    folder = write(labelled(np.arange(40) / 40.0))
    with refused(r"--success 'next\.success>0\.5'"):
        ask(folder)
    assert [ask(folder, success=f"next.success{it}0.5").successes for it in (">", " >= ")] == [19, 20]


@VERSIONS
def test_success_stands_in_the_list_of_episodes(write, version):
    """Of both layouts."""
    folder = write(UNTOLD, version, {"goal_achieved": LATE.tolist()})
    assert told(ask(folder, success="goal_achieved")) == (10, 10, 1.0)


def test_labels_stand_in_a_file(write, tmp_path):
    """A line for each episode; one without is not known. Those that count from 1 would be of the next episode."""
    folder, path = write(UNTOLD), tmp_path / "labels.csv"
    lines = [f"{number},{'true' if number >= 10 else 'false'}" for number in range(1, 20)]
    path.write_text("\n".join(["episode,success", *lines, "99,1"]))
    found = ask(folder, labels=path)
    assert told(found) == (10, 9, 1.0)
    assert "Labels of episodes that are not there: 1 (the first is 99)" in found.notes
    path.write_text("\n".join(["episode,success", *lines, "20,1"]))
    with refused("counts the episodes from 1"):
        ask(folder, labels=path)


def test_a_return_may_say_what_succeeds(write):
    """But says nothing of the reward that it is the return of; one that is no number would make all fail."""
    folder = write(UNTOLD)
    rewards = {"less": lambda o, a, n, info: -float(info["next.reward"])}
    assert ask(folder, success_above=95.0, rewards=rewards).rewards[0].by_success.answer == AGAINST
    (own,) = ask(folder, success_above=95.0).rewards
    assert (own.by_success.value, own.by_success.answer) == (1.0, CANNOT_TELL)
    assert own.by_success.reason == "success is told by this very reward"
    for above in (np.nan, np.inf):
        with refused("give a finite return"):
            ask(folder, success_above=above)


def test_neither_reward_nor_success_is_one_message(write):
    """That names both."""
    with refused(r"no recorded reward, and nothing says which episodes succeeded.*--labels"):
        ask(write(without_pay(UNTOLD)))


def test_pairs_are_compared_within_a_task(write):
    """Which a task that pays more would turn round."""
    task = np.arange(40) // 20
    success = np.where(task == 0, np.arange(40) % 10 > 0, np.arange(40) % 10 == 0)
    paid = 5.0 * task + success + 0.01 * np.arange(40)
    folder = write(
        [made(it, np.full(STEPS, paid[it]), next__success=success[it], task_index=task[it]) for it in range(40)]
    )
    (folder / "meta/info.json").write_text(json.dumps({**info_of(folder), "total_tasks": 1}))
    found = ask(folder)
    assert "The metadata declares 1 tasks, and 2 are in what is used" in found.notes
    assert share_of_pairs(paid, success) < 0.3
    assert found.rewards[0].by_success.value == share_of_pairs(paid, success, task) == 1.0
    assert found.tasks == ("0", "1")
    assert "2 tasks (0, 1)" in str(found).replace("\n", " ")


def test_copies_count_once(write, tmp_path):
    """In whatever order, precision and row groups they are stored."""
    distinct = labelled([number in (1, 4, 5, 7) for number in range(8)])
    one = ask(write_frames(tmp_path / "one", distinct))
    stored = [distinct[number] for number in default_rng(0).permutation(np.repeat(np.arange(8), 9))]
    often = ask(write(stored, row_group_size=7, compression="gzip"))
    assert often.rewards[0].by_success == one.rewards[0].by_success
    assert says(often, "which counts once: 64 episodes")


def test_copies_that_contradict_one_another_are_not_known(write):
    """One is a success, the other a failure."""
    found = ask(write([*labelled(EVEN[:8]), *labelled([False])]))
    assert (found.episodes, found.successes, found.failures) == (8, 3, 4)
    assert says(found, "a success here and a failure there")


@pytest.mark.parametrize(
    ("column", "lost"),
    [("next.reward", ["recorded"]), ("observation.state", ["seen"]), ("action", ["moved"])],
)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_one_number_that_is_none_costs_the_rewards_that_read_it(write, tmp_path, column, value, lost):
    """That episode, which is told; what the others say stays, to the last figure."""
    episodes = labelled(LATE)
    rewards = {"seen": lambda step: step.observation.sum() > 0.0, "moved": lambda step: step.action.sum() > 0.0}

    def answers(folder):
        return [ask(folder).rewards[0], *audit_dataset(f"lerobot:{folder}", rewards).rewards]

    whole = answers(write_frames(tmp_path / "whole", episodes))
    episodes[3][column][2] = value
    torn = answers(write(episodes))
    assert [it.name for it in torn if any("left out of this answer" in line for line in it.unpaid)] == lost
    assert [it.by_success for it in torn if it.name not in lost] == [
        it.by_success for it in whole if it.name not in lost
    ]


def test_a_gap_in_the_pay_is_as_a_number_that_is_none(write):
    """As pandas writes it."""
    folder = write(labelled(LATE))

    def tear(rows):
        rows[3 * STEPS + 2] = None
        return pa.float32()

    rewrite(folder, "next.reward", tear)
    (recorded,) = ask(folder).rewards
    assert "1 episodes (the first is 3)" in recorded.unpaid[0]


def test_a_row_that_lacks_a_value_is_named(write):
    """Another that has one too many makes the sum right."""
    folder = write(labelled(EVEN[:4]))

    def shift(rows):
        rows[5], rows[-1] = rows[5][:-1], [*rows[-1], 0.0]
        return pa.list_(pa.float32())

    rewrite(folder, "observation.state", shift)
    with pytest.raises(SchemaError, match="the first is row 5"):
        ask(folder)


def torn(observation, action, next_observation, info):
    """Pays what is recorded, but no number in episode 12."""
    return float("nan") if info["episode_index"] == 12 else float(info["next.reward"])


def test_a_function_without_a_number_in_one_episode_is_judged_by_the_others(write):
    """No other reward loses that episode."""
    one, other = ask(write(labelled(np.arange(40) >= 10)), rewards={"torn": torn, "n": lambda o, a, n, i: 1.0}).rewards
    assert (one.by_success.above, other.by_success.above) == (29, 30)
    assert (one.by_success.value, one.by_success.answer) == (1.0, RANKS)
    assert "1 episodes (the first is 12)" in one.unpaid[0]


def test_a_function_without_a_number_where_that_could_turn_the_answer_gets_no_word(write):
    """Six of each are few."""
    (found,) = ask(write(labelled(np.arange(14) >= 7)), rewards={"torn": torn}).rewards
    assert (found.by_success.value, found.by_success.answer) == (1.0, CANNOT_TELL)
    assert "no finite number in some episodes" in found.by_success.reason


def declared(folder, count):
    """Says that there are so many episodes."""
    told = {**info_of(folder), "total_episodes": count, "total_frames": count * STEPS}
    (folder / "meta/info.json").write_text(json.dumps(told))
    return folder


@VERSIONS
def test_what_the_metadata_does_not_list_is_left_out(write, version):
    """And told."""
    found = ask(declared(write(labelled(LATE), version, listed=None), 15))
    assert found.episodes == 15
    assert "Left out, since the metadata does not list them: 5 episodes (15, 16, 17, 18, 19)" in found.notes


@VERSIONS
def test_a_gap_is_refused_unless_a_part_is_enough(write, version):
    """With both numbers."""
    folder = declared(write(labelled(LATE), version), 25)
    with pytest.raises(SchemaError, match=r"25 episodes declared, 20 .*--partial"):
        ask(folder)
    found = ask(folder, partial=True)
    assert found.episodes == 20
    assert says(found, "25 episodes declared, 20")


def test_a_file_that_is_gone_is_a_gap(write):
    """Its episode is named."""
    folder = write(labelled(LATE), "v2.1")
    (folder / "data/chunk-000/episode_000007.parquet").unlink()
    with pytest.raises(SchemaError, match=r"1 episode \(7\) declared and not there"):
        ask(folder)


def test_an_older_file_that_no_episode_stands_in_is_left_out(write):
    """Though it has episodes of the same numbers."""
    place = write(labelled(LATE)) / "data/chunk-000"
    (place / "file-001.parquet").write_bytes((place / "file-000.parquet").read_bytes())
    found = ask(place.parents[1])
    assert found.episodes == 20
    assert says(found, "1 files (data/chunk-000/file-001.parquet)")


def test_the_order_of_files_does_not_matter(write):
    """Nor how they are called."""
    folder = write(labelled(np.arange(20) % 3 == 0), "v2.1")
    place, before = folder / "data/chunk-000", ask(folder)
    for number in range(20):
        (place / f"episode_{number:06d}.parquet").rename(place / f"part_{19 - number:06d}.parquet")
    assert ask(folder).rewards[0].by_success == before.rewards[0].by_success


def test_an_episode_of_one_frame_counts(write):
    """It is paid once."""
    found = ask(write([made(it, np.full(1, it * 1.0), next__success=it >= 10) for it in range(20)]))
    assert (found.steps, told(found)) == (20, (10, 10, 1.0))


def test_operators_stand_in_the_list_of_episodes(write):
    """As text."""
    who = {"operator": [f"who {number // 4}" for number in range(20)]}
    assert ask(write(labelled(LATE), "v3.0", who)).clusters == ("operators", 5)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_what_only_rounding_tells_apart_is_a_tie(write, kind):
    """Ten times 0.1 and once 1 are paid the same, whatever type the column has."""
    spread, once = np.full(10, 0.1, kind), np.eye(10, dtype=kind)[9]
    (found,) = ask(
        write([made(it, spread if EVEN[it] else once, next__success=not EVEN[it]) for it in range(40)])
    ).rewards
    assert (found.by_success.value, found.wrong) == (0.5, 0)


def test_small_differences_of_single_numbers_count(write):
    """What is ten times as far apart as float32 rounds is told apart."""
    paid = [np.float32([1.0 + 1.2e-6 * even, 0.5]) for even in EVEN]
    episodes = [made(it, paid[it], next__success=EVEN[it]) for it in range(40)]
    assert ask(write(episodes)).rewards[0].by_success.value == 1.0


def valued(infos=None, **attrs):
    """Episodes of Minari that are paid their number, and succeed from 10 on; attributes are functions of the number."""
    for number in range(20):
        more = {key: it(number) for key, it in attrs.items()}
        one = {**episode(STEPS, number, success=number >= 10, **more), "rewards": np.full(STEPS, number * 1.0)}
        yield one if infos is None else {**one, "infos": infos(number, one)}


@pytest.fixture
def minari(tmp_path):
    """The name of a data set of such episodes, with the totals that Minari writes."""

    def write(episodes, **metadata):
        episodes = [*episodes]
        steps = sum(len(it["rewards"]) for it in episodes)
        metadata = {"total_episodes": len(episodes), "total_steps": steps, **metadata}
        return f"minari:{write_minari(tmp_path / 'd', episodes, **metadata)}"

    return write


def test_one_episode_without_the_key_is_not_known(minari):
    """The first, from which the keys of the others cannot be read."""
    found = audit_dataset(minari(valued(lambda it, one: one["infos"] if it else {"p": np.zeros(STEPS + 1)})))
    assert (found.successes, found.failures) == (10, 9)


@pytest.mark.parametrize(
    ("off", "on"), [(False, True), (0, 1), (0.0, 1.0), ("false", "true"), (np.array([0.0]), np.array([1.0]))]
)
def test_an_attribute_of_an_episode_tells_success(minari, off, on):
    """Of whatever type a label has."""
    name = minari(valued(lambda *_: {}, solved=lambda it: on if it >= 10 else off))
    assert told(audit_dataset(name, success="solved")) == (10, 10, 1.0)


def test_one_number_in_infos_holds_for_the_episode(minari):
    """Of shape (1,)."""
    assert audit_dataset(minari(valued(lambda it, one: {"success": np.array([it >= 10])}))).successes == 10


def test_envs_of_several_tasks_are_not_compared(minari):
    """Their observations need not have the same size."""
    episodes = []
    for number in range(40):
        one = dict(episode(STEPS, number, success=EVEN[number], env_id=f"Env{number // 20}-v0"))
        one["rewards"] = np.full(STEPS, EVEN[number]) + 10.0 * (number // 20)
        one["observations"] = one["observations"][:, : 3 + number // 20]
        episodes.append(one)
    found = audit_dataset(minari(episodes))
    assert (found.rewards[0].by_success.value, found.tasks) == (1.0, ("Env0-v0", "Env1-v0"))


@pytest.mark.parametrize(
    ("steps", "totals", "why", "left"),
    [
        (10, {"total_episodes": 21}, r"declared, .* there", 20),
        (10, {"total_steps": 199}, r"declared, .* there", 20),
        (11, {}, r"episode 3 has 10 steps, 11 are declared", 19),
    ],
)
def test_other_totals_than_minari_declares_are_refused(minari, steps, totals, why, left):
    """Of the data set or of an episode, unless a part is enough."""
    name = minari(valued(total_steps=lambda it: steps if it == 3 else STEPS), **totals)
    with pytest.raises(SchemaError, match=why):
        audit_dataset(name)
    assert audit_dataset(name, partial=True).episodes == left


def test_another_name_for_an_episode_is_no_other_episode(minari):
    """It lies in the file once."""
    name = minari(valued(), total_episodes=21, total_steps=210)
    with h5py.File(Path(name.removeprefix("minari:")) / "data/main_data.hdf5", "a") as file:
        file["episode_20"] = file["episode_3"]
    found = audit_dataset(name)
    assert found.episodes == 20
    assert "Names for an episode that has another name already, left out: 1" in found.notes


@pytest.mark.parametrize("kind", ["f2", "f4", "f8", "i4"])
@pytest.mark.parametrize("shape", [(STEPS,), (STEPS, 1)])
def test_the_type_of_the_pay_does_not_matter(minari, kind, shape):
    """Nor whether a step's is a list of one."""
    name = minari({**one, "rewards": one["rewards"].astype(kind).reshape(shape)} for one in valued())
    (found,) = audit_dataset(name).rewards
    assert (found.by_success.value, found.by_success.answer) == (1.0, RANKS)
