"""Event files that TensorBoard's own writers, torch's and stable-baselines3 write, and what happens to such files."""

import warnings

import numpy as np
import pytest

from harness.errors import SchemaError, UsageError
from tests.plugins.logs.reading import Reader

pytest.importorskip("tensorboard", reason="needs the extra tensorboard")

REWARD, SUCCESS, LENGTH = "rollout/ep_rew_mean", "rollout/success_rate", "rollout/ep_len_mean"


def write(folder, tags, stamp=1):
    """An event file by TensorBoard's own writer of records, as old writers keep scalars; its path."""
    from tensorboard.compat.proto.event_pb2 import Event
    from tensorboard.compat.proto.summary_pb2 import Summary
    from tensorboard.summary.writer.record_writer import RecordWriter

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"events.out.tfevents.{stamp:010}.host"
    with path.open("wb") as file:
        writer = RecordWriter(file)
        writer.write(Event(file_version="brain.Event:2").SerializeToString())
        for tag, points in tags.items():
            for step, value in points:
                summary = Summary(value=[Summary.Value(tag=tag, simple_value=value)])
                writer.write(Event(step=step, summary=summary).SerializeToString())
        writer.flush()
    return path


read = Reader("tensorboard")


def curve(begin, end):
    """A point each 10 steps."""
    return [(step, step / 4) for step in range(begin, end, 10)]


def test_a_training_of_stable_baselines3_is_read_as_its_own_logger_dumped_it(counted, tmp_path):
    """Returns, lengths, success and steps, against what its csv logger wrote of the same training."""
    pytest.importorskip("stable_baselines3", reason="needs the extra sb3")
    from stable_baselines3 import A2C
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.logger import configure

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = A2C("MlpPolicy", make_vec_env(counted), n_steps=20, device="cpu")
        model.set_logger(configure(str(tmp_path), ["csv", "tensorboard"]))
        model.learn(200, log_interval=1)
    model.logger.close()
    log = read(tmp_path)
    told = np.genfromtxt(tmp_path / "progress.csv", delimiter=",", names=True, deletechars="")
    for column, name in [("reward/recorded", REWARD), ("length", LENGTH), ("behaviour/success", SUCCESS)]:
        assert log[column] == pytest.approx(told[name], rel=1e-6)
    assert log["time"].tolist() == told["time/total_timesteps"].tolist()
    assert log.facts.unit == "point"
    assert "a mean over the last 100 episodes" in log.facts.thinned


def test_all_of_20000_points_are_read_where_tensorboards_own_reader_keeps_10000(tmp_path):
    """Issue 4047 of TensorBoard: exports of more than its sample are thinned without a word."""
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    points = [(step, float(step % 97)) for step in range(20_000)]
    write(tmp_path, {REWARD: points})
    own = EventAccumulator(str(tmp_path))
    own.Reload()
    assert len(own.Scalars(REWARD)) == 10_000
    log = read(tmp_path)
    assert log["time"].tolist() == [step for step, _ in points]
    assert log["reward/recorded"].tolist() == [value for _, value in points]


@pytest.mark.parametrize("kind", ["torch", "tensorboard", "bare"])
def test_scalars_of_every_writer_are_the_same(tmp_path, kind):
    """Torch's and old writers keep a simple value, new ones a tensor."""
    points = curve(0, 50)
    if kind == "bare":
        write(tmp_path, {REWARD: points})
    else:
        module = "torch.utils.tensorboard" if kind == "torch" else "tensorboard.summary"
        writer_type = {"torch": "SummaryWriter", "tensorboard": "Writer"}[kind]
        writer = getattr(pytest.importorskip(module), writer_type)(str(tmp_path))
        for step, value in points:
            writer.add_scalar(REWARD, value, step)
        writer.close()
    log = read(tmp_path)
    assert log["time"].tolist() == [0, 10, 20, 30, 40]
    assert log["reward/recorded"].tolist() == [0.0, 2.5, 5.0, 7.5, 10.0]


def test_a_training_that_was_continued_has_its_later_file_count(tmp_path):
    """From a checkpoint at step 60: what the first part logged from there on was not kept by the training."""
    write(tmp_path, {REWARD: curve(0, 100)}, stamp=1)
    write(tmp_path, {REWARD: [(step, -1.0) for step in range(60, 120, 10)]}, stamp=2)
    log = read(tmp_path)
    assert log["time"].tolist() == list(range(0, 120, 10))
    assert log["reward/recorded"].tolist() == [value for _, value in curve(0, 60)] + [-1.0] * 6
    assert any("1 times it goes back" in note for note in log.facts.notes)


def test_two_writers_of_one_training_are_one_log(tmp_path):
    """One logs returns and another success, into files of their own."""
    write(tmp_path, {REWARD: curve(0, 50)}, stamp=1)
    write(tmp_path, {SUCCESS: [(step, 0.5) for step in range(0, 50, 10)]}, stamp=2)
    assert read(tmp_path)["behaviour/success"].tolist() == [0.5] * 5


@pytest.mark.parametrize("lost", [1, 13, 30])
def test_an_event_that_is_not_yet_whole_is_left_out_and_told(tmp_path, lost):
    """The training writes on, or was killed."""
    path = write(tmp_path, {REWARD: curve(0, 100)})
    path.write_bytes(path.read_bytes()[:-lost])
    log = read(tmp_path)
    assert log["time"].tolist() == list(range(0, 90, 10))
    assert any("no whole event yet" in note for note in log.facts.notes)


def test_events_that_are_written_while_it_is_read_are_no_damage(tmp_path, monkeypatch):
    """The last event was not whole when the library came to it, and is when it is looked at again."""
    from tensorboard.backend.event_processing.event_file_loader import RawEventFileLoader

    path = write(tmp_path, {REWARD: curve(0, 100)})
    whole = path.read_bytes()
    path.write_bytes(whole[:-30])
    load = RawEventFileLoader.Load

    def load_then_grow(self):
        yield from load(self)
        path.write_bytes(whole)

    monkeypatch.setattr(RawEventFileLoader, "Load", load_then_grow)
    assert len(read(tmp_path)) == 9


def test_a_tail_of_zeros_is_left_out_and_told(tmp_path):
    """A disk that lost power leaves them."""
    path = write(tmp_path, {REWARD: curve(0, 100)})
    path.write_bytes(path.read_bytes() + bytes(300))
    assert len(read(tmp_path)) == 10


@pytest.mark.parametrize("place", [60, 200, -20])
def test_a_file_that_is_damaged_before_its_end_is_refused(tmp_path, place):
    """A bit that fell over: its checksum does not fit any more."""
    path = write(tmp_path, {REWARD: curve(0, 100)})
    data = bytearray(path.read_bytes())
    data[place] ^= 4
    path.write_bytes(bytes(data))
    with pytest.raises(SchemaError, match="is damaged from byte"):
        read(tmp_path)


def test_what_is_no_event_file_is_refused(tmp_path):
    """Whatever its name says."""
    (tmp_path / "events.out.tfevents.1.host").write_text("step,value\n" + 100 * "1,2\n")
    with pytest.raises(SchemaError, match="is damaged from byte 0"):
        read(tmp_path)


def test_cleanrl_tells_environment_algorithm_seed_and_budget(tmp_path):
    """In the text of its hyperparameters, as its scripts write it by torch's writer."""
    tensorboard = pytest.importorskip("torch.utils.tensorboard")
    told = {"exp_name": "ppo", "seed": 7, "env_id": "Hopper-v4", "total_timesteps": 1000}
    writer = tensorboard.SummaryWriter(str(tmp_path))
    rows = "\n".join(f"|{key}|{value}|" for key, value in told.items())
    writer.add_text("hyperparameters", f"|param|value|\n|-|-|\n{rows}")
    writer.add_scalar("charts/episodic_return", 1.0, 10)
    writer.close()
    facts = read(tmp_path).facts
    assert (facts.env, facts.algorithm, facts.seed, facts.asked) == ("Hopper-v4", "ppo", 7, 1000)


SOME = [(0, 0.0), (10, 2.5), (20, 5.0)]
OF_RLLIB = {
    "ray/tune/env_runners/episode_return_mean": [(1, -5.0), (2, -4.0)],
    "ray/tune/num_env_steps_sampled_lifetime": [(1, 4000.0), (2, 8000.0)],
}
OWN = {
    REWARD: SOME,
    "my/score": [(0, 5.0), (10, 6.0), (20, 7.0)],
    "my/reached": [(10, 0.5), (20, 1.0)],
    "my/error": [(0, 3.0), (10, 2.0), (20, 1.0)],
}


@pytest.mark.parametrize(
    ("tags", "given", "told", "columns"),
    [
        # Several episodes may end at one step: CleanRL logs each, with its length
        (
            {"charts/episodic_return": [(8, 1.0), (8, 2.0)], "charts/episodic_length": [(8, 5.0), (8, 6.0)]},
            {},
            "",
            {"time": [8, 8], "reward/recorded": [1, 2], "length": [5, 6]},
        ),
        # RLlib counts environment steps by a tag of its own: newer versions number events by iterations
        (OF_RLLIB, {}, "", {"time": [4000, 8000]}),
        # Tags may be named: one that no table knows, one that it would not have chosen, and one more measure
        (
            OWN,
            {"reward": "my/score", "success": "my/reached", "measure": "my/error", "per_step": 1},
            "1 points that lack one of these",
            {"reward/recorded": [6, 7], "behaviour/success": [0.5, 1], "behaviour/my/error": [2, 1]},
        ),
        # Lengths that some points lack are left out, and no point is: they decide nothing
        (
            {REWARD: SOME, LENGTH: [(10, 5.0)]},
            {},
            f"'{LENGTH}' lacks values: it is left out",
            {"reward/recorded": [0, 2.5, 5], "length": None},
        ),
        # NaN is a point that lacks a value: programs log it before the first episode has ended
        ({REWARD: [(10, float("nan")), (20, 1.0)]}, {}, "", {"time": [20]}),
    ],
)
def test_what_tags_and_their_points_mean(tmp_path, tags, given, told, columns):
    """By their names, or as the user says."""
    write(tmp_path, tags)
    log = read(tmp_path, **given)
    assert told in str(log.facts.notes)
    assert {name: log[name].tolist() if name in log else None for name in columns} == columns


@pytest.mark.parametrize(
    ("tags", "given", "why"),
    [
        # Two seeds that one writer logged are not one training; a restart would have begun a file of its own
        ({REWARD: [*SOME, *SOME[1:]]}, {}, "go from 20 to 10: several trainings log into one file"),
        (OF_RLLIB, {"per_step": 4000}, r"counts environment steps in .*: leave per_step out"),
        ({REWARD: SOME}, {"reward": "rollout/ep_rew"}, "has no 'rollout/ep_rew'.*Did you mean 'rollout/ep_rew_mean'"),
    ],
)
def test_what_tags_cannot_mean_is_refused(tmp_path, tags, given, why):
    """With what there is."""
    write(tmp_path, tags)
    with pytest.raises((SchemaError, UsageError), match=why):
        read(tmp_path, **given)


def test_the_folder_of_a_cleanrl_run_tells_its_seed(tmp_path):
    """Where the text is not there."""
    folder = tmp_path / "Hopper-v4__sac_continuous__3__1700000000"
    write(folder, {"charts/episodic_return": curve(0, 30)})
    facts = read(folder).facts
    assert (facts.env, facts.algorithm, facts.seed) == ("Hopper-v4", "sac", 3)


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e300])
def test_values_beyond_all_returns_are_refused(tmp_path, value):
    """float32 makes an infinity of 1e300."""
    from tensorboard.summary import Writer

    writer = Writer(str(tmp_path))
    with np.errstate(over="ignore"):
        writer.add_scalar(REWARD, value, 10)
    writer.close()
    with pytest.raises(SchemaError, match=r"a value of reward/recorded is -?inf"):
        read(tmp_path)


def test_this_projects_own_tracker_is_read(tmp_path):
    """What `--track tensorboard` has logged of a cell."""
    from harness.executor import TrackedCell
    from harness.record.progress import RETURN, SUCCESS as SHARE
    from harness_plugins.trackers.tensorboard import TensorBoard as Tracker

    cell = TrackedCell(id="0123456789abcdef", title="arm", group="arm", config={}, folder=tmp_path)
    track = Tracker().begin(cell)
    for steps in (1000, 2000):
        track.log(steps, {RETURN: -steps / 100, SHARE: steps / 4000, "Losses/Policy Loss": 1.0})
    track.end("done", "")
    [folder] = (tmp_path / "tensorboard").iterdir()
    log = read(folder)
    assert log["time"].tolist() == [1000, 2000]
    assert log["reward/recorded"].tolist() == [-10.0, -20.0]
    assert log["behaviour/success"].tolist() == [0.25, 0.5]


def test_other_folders_are_not_recognised(tmp_path):
    """Nor files."""
    (tmp_path / "progress.csv").write_text("a\n1\n")
    for name in ("", "progress.csv", "missing"):
        assert not read.is_recognised(tmp_path / name)
