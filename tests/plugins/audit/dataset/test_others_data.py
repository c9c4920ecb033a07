"""Data sets as others write them: each answer is that of pairs counted one by one, or the data set is refused."""

import copy
import json
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from harness.errors import SchemaError, UsageError
from harness.eta.auc import AGAINST, CANNOT_TELL, RANKS
from harness.payoff.dataset.step_by_step import Unseen
from harness.recorder.sealed import Sealer
from harness_plugins.audit.dataset.audit_dataset import audit_dataset
from tests.record.dataset.frames import info_of, write_frames
from tests.record.dataset.written import episode, write_minari

STEPS = 10


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


def made(number: int, reward, **columns):
    """An episode of LeRobot: numbers that are drawn, and columns of a value for each frame or one for all."""
    rng = np.random.default_rng(number)
    steps = len(reward)
    told = {key: np.broadcast_to(np.asarray(value), (steps,)) for key, value in columns.items()}
    return {
        "observation.state": rng.normal(size=(steps, 3)),
        "action": rng.normal(size=(steps, 2)),
        "next.reward": reward,
        **told,
    }


def last(success: bool, steps: int = STEPS):
    """True in the last frame alone."""
    return np.arange(steps) == (steps - 1 if success else steps)


def ask(folder: Path, **asked):
    """The audit of a LeRobot data set."""
    return audit_dataset(f"lerobot:{folder}", **asked)


def terminal(number: int, success: bool):
    """-1 a frame, +100 in the last frame of a success, which takes longer."""
    steps = 12 + 6 * success + number % 5
    return made(number, -1.0 + 100.0 * last(success, steps), **{"next.success": last(success, steps)})


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_the_last_frame_s_pay_counts(tmp_path: Path, version: str):
    """A verdict at the end is what decides."""
    episodes = [terminal(number, number % 2 == 0) for number in range(40)]
    returns = [it["next.reward"].sum() for it in episodes]
    (found,) = ask(write_frames(tmp_path / "d", episodes, version)).rewards
    assert found.by_success.value == share_of_pairs(returns, np.arange(40) % 2 == 0) == 1.0
    assert found.by_success.answer == RANKS


def test_a_function_that_needs_the_next_observation_gets_no_word_where_the_last_step_decides(tmp_path: Path):
    """It is paid -1 a step here and cannot be asked for its verdict at the end."""
    folder = write_frames(tmp_path / "d", [terminal(number, number % 2 == 0) for number in range(40)])

    def arrives(observation, action, next_observation, info):
        return 99.0 if next_observation[0] > 1e9 else -1.0

    (found,) = ask(folder, rewards={"arrives": arrives}).rewards
    assert found.by_success.value < 0.2
    assert found.by_success.answer == CANNOT_TELL
    assert "cannot be paid the last step" in found.by_success.reason
    assert found.unpaid == ("not paid the last step of 40 episodes, since it looks at what came then",)


def test_a_function_that_could_pay_anything_in_the_step_that_succeeds_gets_no_word(tmp_path: Path):
    """Nothing is recorded by which its pay could be judged."""
    episodes = [terminal(number, number % 2 == 0) for number in range(40)]
    for one in episodes:
        del one["next.reward"]
    (found,) = ask(
        write_frames(tmp_path / "d", episodes), rewards={"late": lambda o, a, n, i: -1.0 - 0.0 * n[0]}
    ).rewards
    assert (found.by_success.answer, found.by_success.low is None) == (CANNOT_TELL, False)
    assert "looks at next_observation" in found.by_success.reason


def test_a_function_gets_its_word_where_the_last_step_cannot_turn_it(tmp_path: Path):
    """Success shows earlier, and one step more moves no episode past another."""
    episodes = [
        made(it, np.full(STEPS, it % 2), **{"next.success": np.arange(STEPS) > (5 if it % 2 else STEPS)})
        for it in range(40)
    ]
    for number, one in enumerate(episodes):
        one["observation.state"][:, 0] = number % 2 + 0.001 * number
    (found,) = ask(write_frames(tmp_path / "d", episodes), rewards={"place": lambda o, a, n, i: float(n[0])}).rewards
    assert (found.by_success.value, found.by_success.answer) == (1.0, RANKS)


def test_an_episode_of_which_no_step_can_be_paid_is_no_pay_of_0(tmp_path: Path):
    """An episode of one frame, and a function that needs the next one: the others are compared without it."""
    lengths = [3, 3, 3, 3, 3, 3, 1]
    runs = [
        made(number, [0.0] * steps, **{"next.success": last(number < 3, steps)}) for number, steps in enumerate(lengths)
    ]
    folder = write_frames(tmp_path / "it", runs)
    (answer,) = ask(folder, rewards={"needs": lambda now, did, then, info: -float(then[0] ** 2)}).rewards
    assert (answer.by_success.above, answer.by_success.below) == (3, 3)


def test_a_function_that_does_not_look_at_the_next_observation_is_paid_every_step(tmp_path: Path):
    """By what the info says of the last frame."""
    folder = write_frames(tmp_path / "d", [terminal(number, number % 2 == 0) for number in range(40)])
    told = {"told": lambda o, a, n, info: 100.0 * info["next.success"] - 1.0}
    (found,) = ask(folder, rewards=told).rewards
    assert (found.by_success.value, found.by_success.answer, found.unpaid) == (1.0, RANKS, ())


def test_a_copy_of_what_is_not_known_is_no_look_at_it():
    """Functions get copies of their own once torch is imported, or a step holds what only a copy protects."""
    unseen = Unseen()
    assert copy.deepcopy(Sealer().seal(unseen)) is unseen
    assert not unseen.looked_at


def paid_by(number: int, label, **more):
    """An episode of which the pay is its number, and a label in every frame."""
    return made(number, np.full(STEPS, number * 1.0), **{"next.success": label}, **more)


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int64, np.float32, np.float64])
def test_labels_are_true_and_false_in_every_type(tmp_path: Path, kind):
    """The same answer."""
    episodes = [paid_by(number, kind(number >= 10)) for number in range(20)]
    found = ask(write_frames(tmp_path / "d", episodes))
    assert (found.successes, found.failures, found.rewards[0].by_success.value) == (10, 10, 1.0)


@pytest.mark.parametrize("unknown", [np.nan, -1.0])
def test_a_label_that_is_not_known_leaves_the_episode_out(tmp_path: Path, unknown: float):
    """With the number of them."""
    labels = [unknown if number % 3 == 2 else float(number % 3) for number in range(30)]
    found = ask(write_frames(tmp_path / "d", [paid_by(number, label) for number, label in enumerate(labels)]))
    kept = [number for number in range(30) if number % 3 != 2]
    assert (found.successes, found.failures) == (10, 10)
    assert "Episodes left out, since nothing says whether they succeeded: 10" in found.notes
    expected = share_of_pairs(kept, [labels[number] == 1.0 for number in kept])
    assert found.rewards[0].by_success.value == pytest.approx(expected)


def test_a_probability_is_refused_with_what_to_type(tmp_path: Path):
    """And read with a threshold."""
    folder = write_frames(tmp_path / "d", [paid_by(number, number / 40.0) for number in range(40)])
    with pytest.raises(UsageError, match=r"--success 'next\.success>0\.5'"):
        ask(folder)
    assert ask(folder, success="next.success>0.5").successes == 19
    assert ask(folder, success="next.success >= 0.5").successes == 20


def test_success_stands_in_the_list_of_episodes(tmp_path: Path):
    """Of both layouts."""
    episodes = [made(number, np.full(STEPS, number * 1.0)) for number in range(20)]
    listed = {"goal_achieved": [bool(number >= 10) for number in range(20)]}
    for version in ("v2.1", "v3.0"):
        folder = write_frames(tmp_path / version, episodes, version, listed)
        found = ask(folder, success="goal_achieved")
        assert (found.successes, found.rewards[0].by_success.value) == (10, 1.0)


def test_labels_stand_in_a_file(tmp_path: Path):
    """A line for each episode; one without is not known."""
    folder = write_frames(tmp_path / "d", [made(number, np.full(STEPS, number * 1.0)) for number in range(20)])
    lines = [f"{number},{'true' if number >= 10 else 'false'}" for number in range(1, 20)]
    (tmp_path / "labels.csv").write_text("\n".join(["episode,success", *lines, "99,1"]))
    found = ask(folder, labels=tmp_path / "labels.csv")
    assert (found.successes, found.failures, found.rewards[0].by_success.value) == (10, 9, 1.0)
    assert "Labels of episodes that are not there: 1 (the first is 99)" in found.notes


def test_a_return_may_say_what_succeeds(tmp_path: Path):
    """But says nothing of the reward that it is the return of."""
    folder = write_frames(tmp_path / "d", [made(number, np.full(STEPS, number * 1.0)) for number in range(20)])
    rewards = {"less": lambda o, a, n, info: -float(info["next.reward"])}
    assert ask(folder, success_above=95.0, rewards=rewards).rewards[0].by_success.answer == AGAINST
    (own,) = ask(folder, success_above=95.0).rewards
    assert (own.by_success.value, own.by_success.answer) == (1.0, CANNOT_TELL)
    assert own.by_success.reason == "success is told by this very reward"


def test_neither_reward_nor_success_is_one_message(tmp_path: Path):
    """That names both."""
    episodes = [made(number, np.zeros(STEPS)) for number in range(4)]
    for one in episodes:
        del one["next.reward"]
    with pytest.raises(UsageError, match=r"no recorded reward, and nothing says which episodes succeeded.*--labels"):
        ask(write_frames(tmp_path / "d", episodes))


def test_pairs_are_compared_within_a_task(tmp_path: Path):
    """Which a task that pays more would turn round."""
    task = np.arange(40) // 20
    success = np.where(task == 0, np.arange(40) % 10 > 0, np.arange(40) % 10 == 0)
    paid = 5.0 * task + success + 0.01 * np.arange(40)
    episodes = [
        made(it, np.full(STEPS, paid[it]), **{"next.success": bool(success[it]), "task_index": task[it]})
        for it in range(40)
    ]
    folder = write_frames(tmp_path / "d", episodes)
    (folder / "meta/info.json").write_text(json.dumps({**info_of(folder), "total_tasks": 1}))
    found = ask(folder)
    assert "The metadata declares 1 tasks, and 2 are in what is used" in found.notes
    assert share_of_pairs(paid, success) < 0.3
    assert found.rewards[0].by_success.value == share_of_pairs(paid, success, task) == 1.0
    assert found.tasks == ("0", "1")
    assert "2 tasks (0, 1)" in str(found).replace("\n", " ")


def test_copies_count_once(tmp_path: Path):
    """In whatever order, precision and row groups they are stored."""
    distinct = [paid_by(number, number in (1, 4, 5, 7)) for number in range(8)]
    one = ask(write_frames(tmp_path / "one", distinct))
    stored = [distinct[number] for number in np.random.default_rng(0).permutation(np.repeat(np.arange(8), 9))]
    often = ask(write_frames(tmp_path / "often", stored, row_group_size=7, compression="gzip"))
    assert often.rewards[0].by_success == one.rewards[0].by_success
    assert any("which counts once: 64 episodes" in line for line in often.notes)


def test_copies_that_contradict_one_another_are_not_known(tmp_path: Path):
    """One is a success, the other a failure."""
    episodes = [*(paid_by(number, number % 2 == 0) for number in range(8)), paid_by(0, False)]
    found = ask(write_frames(tmp_path / "d", episodes))
    assert (found.episodes, found.successes, found.failures) == (8, 3, 4)
    assert any("a success here and a failure there" in line for line in found.notes)


@pytest.mark.parametrize("column", ["next.reward", "observation.state", "action"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_one_number_that_is_none_leaves_one_episode_out(tmp_path: Path, column: str, value: float):
    """Wherever it stands; the others are judged."""
    episodes = [paid_by(number, number >= 10) for number in range(20)]
    episodes[3][column] = np.array(episodes[3][column], float)
    episodes[3][column][2] = value
    found = ask(write_frames(tmp_path / "d", episodes))
    assert (found.episodes, found.failures, found.rewards[0].by_success.value) == (19, 9, 1.0)
    assert any(line.startswith("Left out, since they cannot be paid: 1 episode (episode 3") for line in found.notes)


def test_a_gap_in_the_pay_is_as_a_number_that_is_none(tmp_path: Path):
    """As pandas writes it."""
    folder = write_frames(tmp_path / "d", [paid_by(number, number >= 10) for number in range(20)])
    (path,) = folder.glob("data/*/*.parquet")
    table = pq.read_table(path)
    reward = table["next.reward"].to_pylist()
    reward[3 * STEPS + 2] = None
    at = table.column_names.index("next.reward")
    pq.write_table(table.set_column(at, "next.reward", pa.array(reward, pa.float32())), path)
    assert ask(folder).episodes == 19


def torn(observation, action, next_observation, info):
    """Pays what is recorded, but no number in episode 12."""
    return float("nan") if info["episode_index"] == 12 else float(info["next.reward"])


def test_a_function_without_a_number_in_one_episode_is_judged_by_the_others(tmp_path: Path):
    """No other reward loses that episode."""
    folder = write_frames(tmp_path / "d", [paid_by(number, number >= 10) for number in range(40)])
    found = {it.name: it for it in ask(folder, rewards={"torn": torn, "n": lambda o, a, n, i: 1.0}).rewards}
    assert (found["torn"].by_success.above, found["n"].by_success.above) == (29, 30)
    assert (found["torn"].by_success.value, found["torn"].by_success.answer) == (1.0, RANKS)
    assert "1 episodes (the first is 12)" in found["torn"].unpaid[0]


def test_a_function_without_a_number_where_that_could_turn_the_answer_gets_no_word(tmp_path: Path):
    """Six of each are few."""
    folder = write_frames(tmp_path / "d", [paid_by(number, number >= 7) for number in range(14)])
    (found,) = ask(folder, rewards={"torn": torn}).rewards
    assert (found.by_success.value, found.by_success.answer) == (1.0, CANNOT_TELL)
    assert "no finite number in some episodes" in found.by_success.reason


def listed(folder: Path, count: int) -> Path:
    """Says that there are so many episodes."""
    path = folder / "meta" / "info.json"
    told = json.loads(path.read_text())
    path.write_text(json.dumps({**told, "total_episodes": count, "total_frames": count * STEPS}))
    return folder


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_what_the_metadata_does_not_list_is_left_out(tmp_path: Path, version: str):
    """And told."""
    episodes = [paid_by(number, number % 2 == 0) for number in range(20)]
    folder = listed(write_frames(tmp_path / "d", episodes, version, listed=None), 15)
    found = ask(folder)
    assert found.episodes == 15
    assert "Left out, since the metadata does not list them: 5 episodes (15, 16, 17, 18, 19)" in found.notes


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_a_gap_is_refused_unless_a_part_is_enough(tmp_path: Path, version: str):
    """With both numbers."""
    episodes = [paid_by(number, number % 2 == 0) for number in range(20)]
    folder = listed(write_frames(tmp_path / "d", episodes, version), 25)
    with pytest.raises(SchemaError, match=r"25 episodes declared, 20 .*--partial"):
        ask(folder)
    found = ask(folder, partial=True)
    assert found.episodes == 20
    assert any("25 episodes declared, 20" in line for line in found.notes)


def test_a_file_that_is_gone_is_a_gap(tmp_path: Path):
    """Its episode is named."""
    folder = write_frames(tmp_path / "d", [paid_by(number, number % 2 == 0) for number in range(20)], "v2.1")
    (folder / "data/chunk-000/episode_000007.parquet").unlink()
    with pytest.raises(SchemaError, match=r"1 episode \(7\) declared and not there"):
        ask(folder)


def test_an_older_file_that_no_episode_stands_in_is_left_out(tmp_path: Path):
    """Though it has episodes of the same numbers."""
    folder = write_frames(tmp_path / "d", [paid_by(number, number >= 10) for number in range(20)])
    path = folder / "data/chunk-000/file-000.parquet"
    (folder / "data/chunk-000/file-001.parquet").write_bytes(path.read_bytes())
    found = ask(folder)
    assert found.episodes == 20
    assert any("1 files (data/chunk-000/file-001.parquet)" in line for line in found.notes)


def test_the_order_of_files_does_not_matter(tmp_path: Path):
    """Nor how many there are."""
    episodes = [paid_by(number, number % 3 == 0) for number in range(20)]
    one = ask(write_frames(tmp_path / "one", episodes, "v2.1"))
    folder = write_frames(tmp_path / "other", episodes, "v2.1")
    place = folder / "data/chunk-000"
    for number in range(20):
        (place / f"episode_{number:06d}.parquet").rename(place / f"part_{19 - number:06d}.parquet")
    assert ask(folder).rewards[0].by_success == one.rewards[0].by_success


def test_an_episode_of_one_frame_counts(tmp_path: Path):
    """It is paid once."""
    episodes = [made(it, np.full(1, it * 1.0), **{"next.success": it >= 10}) for it in range(20)]
    found = ask(write_frames(tmp_path / "d", episodes))
    assert (found.episodes, found.steps, found.rewards[0].by_success.value) == (20, 20, 1.0)


def test_a_row_that_lacks_a_value_is_named(tmp_path: Path):
    """Another that has one too many makes the sum right."""
    folder = write_frames(tmp_path / "d", [paid_by(number, number % 2 == 0) for number in range(4)])
    (path,) = folder.glob("data/*/*.parquet")
    table = pq.read_table(path)
    rows = table["observation.state"].to_pylist()
    rows[5], rows[-1] = rows[5][:-1], [*rows[-1], 0.0]
    at = table.column_names.index("observation.state")
    changed = table.set_column(at, "observation.state", pa.array(rows, pa.list_(pa.float32())))
    pq.write_table(changed, path)
    with pytest.raises(SchemaError, match="the first is row 5"):
        ask(folder)


@pytest.mark.parametrize(
    "own", [{"next.extra": "recorded"}, {"next.reward": "mine"}, {"next.extra": "a", "next.other": "a"}]
)
def test_no_column_is_called_what_another_is(tmp_path: Path, own: dict[str, str]):
    """``recorded`` is the data set's own reward."""
    more = {"next.extra": 1.0, "next.other": 2.0}
    folder = write_frames(tmp_path / "d", [paid_by(number, number >= 2, **more) for number in range(4)])
    info = info_of(folder)
    (folder / "meta/info.json").write_text(json.dumps({**info, "harness_rewards": own}))
    with pytest.raises(SchemaError, match="harness_rewards calls"):
        ask(folder)


def test_operators_stand_in_the_list_of_episodes(tmp_path: Path):
    """As text."""
    episodes = [paid_by(number, number % 2 == 0) for number in range(20)]
    who = {"operator": [f"who {number // 4}" for number in range(20)]}
    assert ask(write_frames(tmp_path / "d", episodes, "v3.0", who)).clusters == ("operators", 5)


def of_minari(folder: Path, episodes, **metadata) -> Path:
    """With the totals that Minari writes."""
    steps = sum(len(it["rewards"]) for it in episodes)
    return write_minari(folder, episodes, **{"total_episodes": len(episodes), "total_steps": steps, **metadata})


def valued(number: int, **attrs):
    """An episode of Minari that is paid its number, and succeeds from 10 on."""
    one = dict(episode(STEPS, number, success=number >= 10, **attrs))
    one["rewards"] = np.full(STEPS, number * 1.0)
    return one


def test_one_episode_without_the_key_is_not_known(tmp_path: Path):
    """The first, from which the keys of the others cannot be read."""
    episodes = [valued(number) for number in range(20)]
    episodes[0]["infos"] = {"p": np.zeros(STEPS + 1)}
    found = audit_dataset(f"minari:{of_minari(tmp_path / 'd', episodes)}")
    assert (found.successes, found.failures) == (10, 9)


@pytest.mark.parametrize("value", [True, 1, 1.0, "true", np.array([1.0])])
def test_an_attribute_of_an_episode_tells_success(tmp_path: Path, value):
    """Of whatever type a label has."""
    episodes = [valued(number, solved=value if number >= 10 else type(value)(0)) for number in range(20)]
    if isinstance(value, str | np.ndarray):
        off = "false" if isinstance(value, str) else np.array([0.0])
        episodes = [valued(number, solved=value if number >= 10 else off) for number in range(20)]
    for one in episodes:
        one["infos"] = {}
    found = audit_dataset(f"minari:{of_minari(tmp_path / 'd', episodes)}", success="solved")
    assert (found.successes, found.failures, found.rewards[0].by_success.value) == (10, 10, 1.0)


def test_one_number_in_infos_holds_for_the_episode(tmp_path: Path):
    """Of shape (1,)."""
    episodes = [valued(number) for number in range(20)]
    for number, one in enumerate(episodes):
        one["infos"] = {"success": np.array([number >= 10])}
    assert audit_dataset(f"minari:{of_minari(tmp_path / 'd', episodes)}").successes == 10


def test_envs_of_several_tasks_are_not_compared(tmp_path: Path):
    """Their observations need not have the same size."""
    episodes = []
    for number in range(40):
        one = dict(episode(STEPS, number, success=number % 2 == 0, env_id=f"Env{number // 20}-v0"))
        one["rewards"] = np.full(STEPS, number % 2 == 0) + 10.0 * (number // 20)
        one["observations"] = one["observations"][:, : 3 + number // 20]
        episodes.append(one)
    found = audit_dataset(f"minari:{of_minari(tmp_path / 'd', episodes)}")
    assert (found.rewards[0].by_success.value, found.tasks) == (1.0, ("Env0-v0", "Env1-v0"))


@pytest.mark.parametrize("totals", [{"total_episodes": 21}, {"total_steps": 199}])
def test_other_totals_than_minari_declares_are_refused(tmp_path: Path, totals: dict[str, int]):
    """Unless a part is enough."""
    name = f"minari:{of_minari(tmp_path / 'd', [valued(number) for number in range(20)], **totals)}"
    with pytest.raises(SchemaError, match=r"declared, .* there"):
        audit_dataset(name)
    assert audit_dataset(name, partial=True).episodes == 20


def test_an_episode_of_another_length_than_it_says_is_a_gap(tmp_path: Path):
    """A part leaves it out."""
    episodes = [valued(number, total_steps=STEPS + (number == 3)) for number in range(20)]
    name = f"minari:{of_minari(tmp_path / 'd', episodes)}"
    with pytest.raises(SchemaError, match=r"episode 3 has 10 steps, 11 are declared"):
        audit_dataset(name)
    assert audit_dataset(name, partial=True).episodes == 19


def test_another_name_for_an_episode_is_no_other_episode(tmp_path: Path):
    """It lies in the file once."""
    folder = of_minari(tmp_path / "d", [valued(number) for number in range(20)], total_episodes=21, total_steps=210)
    with h5py.File(folder / "data/main_data.hdf5", "a") as file:
        file["episode_20"] = file["episode_3"]
    found = audit_dataset(f"minari:{folder}")
    assert found.episodes == 20
    assert "Names for an episode that has another name already, left out: 1" in found.notes


@pytest.mark.parametrize("kind", ["f2", "f4", "f8", "i4"])
@pytest.mark.parametrize("shape", [(STEPS,), (STEPS, 1)])
def test_the_type_of_the_pay_does_not_matter(tmp_path: Path, kind: str, shape: tuple[int, ...]):
    """Nor whether a step's is a list of one."""
    episodes = [valued(number) for number in range(20)]
    for one in episodes:
        one["rewards"] = one["rewards"].astype(kind).reshape(shape)
    (found,) = audit_dataset(f"minari:{of_minari(tmp_path / 'd', episodes)}").rewards
    assert (found.by_success.value, found.by_success.answer) == (1.0, RANKS)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_what_only_rounding_tells_apart_is_a_tie(tmp_path: Path, kind):
    """Ten times 0.1 and once 1 are paid the same, whatever type the column has."""
    spread, once = np.full(10, 0.1, kind), np.eye(10, dtype=kind)[9]
    episodes = [made(it, once if it % 2 else spread, **{"next.success": it % 2 == 1}) for it in range(40)]
    (found,) = ask(write_frames(tmp_path / "d", episodes)).rewards
    assert (found.by_success.value, found.wrong) == (0.5, 0)


def test_small_differences_of_single_numbers_count(tmp_path: Path):
    """What is ten times as far apart as float32 rounds is told apart."""
    paid = [1.0 + 1.2e-6 * (it % 2) for it in range(40)]
    episodes = [made(it, np.float32([value, 0.5]), **{"next.success": it % 2 == 1}) for it, value in enumerate(paid)]
    (found,) = ask(write_frames(tmp_path / "d", episodes)).rewards
    assert found.by_success.value == 1.0


def test_labels_that_count_from_one_are_refused(tmp_path: Path):
    """They would be those of the next episode."""
    folder = write_frames(tmp_path / "d", [made(it, np.ones(STEPS)) for it in range(6)])
    (tmp_path / "l.csv").write_text("episode,success\n" + "".join(f"{it + 1},{it % 2}\n" for it in range(6)))
    with pytest.raises(UsageError, match="counts the episodes from 1"):
        ask(folder, labels=tmp_path / "l.csv")


@pytest.mark.parametrize("above", [np.nan, np.inf])
def test_a_return_that_is_no_number_is_refused(tmp_path: Path, above: float):
    """All episodes would be failures."""
    with pytest.raises(UsageError, match="give a finite return"):
        ask(write_frames(tmp_path / "d", [made(0, np.ones(STEPS))]), success_above=above)
