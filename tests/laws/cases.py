"""Logs and data sets of others that once got a wrong word or number: what writes each, and what is right of it."""

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from tests.laws.said import INTERIM, REFUSED, Said
from tests.laws.writers import SUCCESS, chart, evaluations, events, lines, monitor, paid, progress, table

NEAR, APART = 4.0, 1.6
"""Points of success that a share may differ from what is right, as what a coarse curve's end is depends on its points;
and those of the difference of two shares, as the noise of a curve does."""
TWO = (("base", 0.6, 0), ("prop", 0.95, 100))
WIDE = (("base", 0.4, 0), ("prop", 0.9, 100))
ONE = (("base", 0.9, 0), ("prop", 0.9, 100))
RUNS = tuple((reward, seed) for reward in ("base", "prop") for seed in range(5))


@dataclass(frozen=True)
class Case:
    """An input, the lines that one types, and what is right.

    Attributes:
        write: Writes it into a folder.
        line: What one types behind ``harness``, in the folder above the one that has the name.
        words: Any of these is right.
        shares: Success in percent at the end, of the baseline and of each proposed reward; none if it is not told.
        trainings: How many there are of each reward.
        is_asked: Whether a refusal is right that tells what to type.
        is_refused: Whether nothing but a refusal is right.
        says: What stands in the answer.
        knows: What stands for a word in capitals that a remedy has.
        untrue: Remedies that say what is not so of this input: whoever types them lies.
        then: Which of the words is right once a remedy was typed; any of them if none is named.
        without: How many trainings stay of each reward if one leaves those out that have no end.
    """

    name: str
    write: Callable[[Path], None]
    line: str
    words: tuple[str, ...] = ()
    shares: tuple[float, ...] = ()
    trainings: tuple[int, ...] = (6, 6)
    is_asked: bool = False
    is_refused: bool = False
    says: str = ""
    knows: Mapping[str, str] = field(default_factory=dict)
    untrue: str = "(?!)"
    then: tuple[str, ...] = ()
    without: tuple[int, ...] = ()

    def wrong(self, said: Said) -> str:
        """What is wrong with an answer; empty where it is right."""
        if self.is_refused:
            return "" if said.word == REFUSED and self.says in said.text else f"{said.word}, not refused: {said.text}"
        if said.word not in self.words:
            return f"{said.word}: {said.text[:400]}"
        if self.trainings and said.trainings != self.trainings:
            return f"{said.trainings} trainings"
        off = np.subtract(self.shares, said.shares) if len(said.shares) == len(self.shares) else np.full(1, np.inf)
        if self.shares and said.shares and (abs(off).max() > NEAR or np.ptp(off) > APART):
            return f"{said.shares} %, not {self.shares}"
        return "" if self.says in said.text else f"does not say '{self.says}': {said.text[:400]}"


def curve(final, seed, points=40, noise=0.02):
    """Success that rises on a line from 0 to its final share."""
    drawn = np.random.default_rng(seed).normal(0, noise, points)
    return np.clip(final * np.linspace(1 / points, 1, points) + drawn, 0, 1)


def at(points, total=100_000):
    """The steps of the points of a curve."""
    return np.arange(1, points + 1) * (total // points)


def episodes(final, seed, count=150):
    """Returns, lengths and successes of episodes, of which more and more succeed."""
    rng = np.random.default_rng(seed)
    success = rng.random(count) < final * np.linspace(0.2, 1, count)
    lengths = np.where(success, rng.integers(10, 30, count), 50)
    return -lengths + 20.0 * success + rng.normal(0, 0.5, count), lengths, success


def monitors(folder, name, final, seed):
    """Such episodes as Monitor keeps them."""
    monitor(folder / f"{name}monitor.csv", *episodes(final, seed), 1.7e9 + 1e5 * seed)


def grids(points, shift=0):
    """One law for both rewards, logged at steps of two grids."""

    def write(folder):
        for reward, count, by, first in (("base", points[0], 0, 1000), ("prop", points[1], shift, 1100)):
            for seed in range(6):
                progress(
                    folder / f"{reward}_{seed}/progress.csv", at(count) + by, curve(0.9, first + seed, count, 0.01)
                )

    return write


def evaluated(every):
    """One law of success, evaluated every so many steps by reward."""

    def write(folder):
        for (reward, _, first), steps in zip(TWO, every, strict=True):
            for seed in range(8):
                times = at(10, 10 * steps)
                share = np.clip((times - 40_000) / 55_000, 0, 1)
                success = np.random.default_rng(seed + first).random((10, 20)) < share[:, None]
                evaluations(folder / reward / str(seed) / "evaluations.npz", times, success)

    return write


def failing(pay, kept=150):
    """Three of six trainings of the proposed reward fail from episode 50 on, whose returns are told so."""

    def write(folder):
        for reward, final, first in TWO:
            for seed in range(6):
                returns, lengths, success = episodes(final, seed + first)
                count = 150
                if reward == "prop" and seed < 3:
                    success[50:], lengths[50:], returns[50:], count = False, 50, pay, kept
                path = folder / reward / str(seed) / "monitor.csv"
                monitor(path, returns[:count], lengths[:count], success[:count], 1.7e9 + 1e5 * (seed + first))

    return write


def cleanrl(folder, reward, final, first, points, name, cut=40):
    """Six trainings as CleanRL logs them; three are cut."""
    for seed in range(1, 7):
        kept = cut if seed <= 3 else points
        values, steps = curve(final, seed + first, points)[:kept], at(points)[:kept]
        place = folder / f"Reach-v1__{name}__{seed}__170000{seed}{first:03}"
        told = {"exp_name": name, "seed": seed, "total_timesteps": 100_000, "env_id": "Reach-v1"}
        events(place, steps, values, "charts/episodic_return", "charts/success", **told)


def crashed_cleanrl(folder):
    """Three of six stop at 30,000 of 100,000 steps."""
    cleanrl(folder / "base", *TWO[0], 40, "ppo")
    cleanrl(folder / "prop", *TWO[1], 40, "ppo", cut=12)


def named_by_experiment(folder):
    """CleanRL's --exp-name names the variant."""
    for reward, final, first in TWO:
        cleanrl(folder, reward, final, first, 10, f"ppo_{reward}")


def percent(folder):
    """Four of six tell success in percent."""
    for reward, _, first in TWO:
        for seed in range(6):
            learned = 100 * curve(0.85, seed + first, 20) if first and seed > 1 else np.zeros(20)
            progress(folder / f"{reward}_{seed}/progress.csv", at(20), learned)


def empty(leave):
    """Three of six trainings of the proposed reward left next to nothing."""

    def write(folder):
        for reward, final, first in TWO:
            for seed in range(6):
                path = folder / f"{reward}_{seed}/progress.csv"
                progress(path, at(40), curve(final, seed + first))
                if first and seed < 3:
                    leave(path)

    return write


def d4rl(folder):
    """Two data sets of equal pay: in one, observations of a quarter of the episodes hold NaN."""
    rng = np.random.default_rng(5)
    pays = ((0.4, 0.6), (0.9, 1.0), (0.4, 0.6), (0.0, 0.1))
    ends = np.tile(np.arange(10) == 9, 60)
    observed = rng.normal(size=(600, 4))
    columns = {
        "actions": rng.normal(size=(600, 2)),
        "rewards": np.concatenate([rng.uniform(*pays[number % 4], 10) for number in range(60)]),
        "infos/success": ends * (np.arange(600) // 10 % 2 == 0),
    }
    for name, unknown in (("finite", 0.0), ("nan", np.nan)):
        spoilt = np.where((np.arange(600) // 10 % 4 == 1) & (np.arange(600) % 10 > 7), unknown, 0.0)[:, None]
        with h5py.File(folder / f"{name}.hdf5", "w") as file:
            for column, values in {**columns, "observations": observed + spoilt}.items():
                file[column] = values.astype(np.float32)
            file["terminals"], file["timeouts"] = ends, np.zeros(600, bool)


def robomimic(folder):
    """Demonstrations that are paid 1 at their end, if they succeed."""
    rng, total = np.random.default_rng(1), 0
    with h5py.File(folder / "sparse.hdf5", "w") as file:
        data = file.create_group("data")
        data.attrs["env_args"] = json.dumps({"env_name": "Lift", "type": 1})
        for number in range(40):
            count = int(rng.integers(8, 15))
            seen, last, demo = rng.normal(size=(count + 1, 3)), np.arange(count) == count - 1, f"demo_{number}"
            group, total = data.create_group(demo), total + count
            group["obs/robot0_eef_pos"], group["next_obs/robot0_eef_pos"] = seen[:-1], seen[1:]
            group["actions"], group["dones"] = rng.uniform(-1, 1, (count, 7)), last.astype(int)
            group["rewards"], group.attrs["num_samples"] = last * float(number % 2 == 0), count
        data.attrs["total"] = total


def seeds_first(folder):
    """Four weights of five seeds, whose folders stand above."""
    for seed in range(5):
        for number, (weight, final) in enumerate(((0, 0.2), (1, 0.5), (10, 0.8), (100, 0.95))):
            monitors(folder / str(seed), f"penalty{weight}/", final, 10 * seed + number)


def run_is_reward(folder):
    """Six rewards that are called runs."""
    for run in range(1, 7):
        for seed in range(5):
            monitors(folder, f"run{run}_{seed}/", 0.15 * run, 100 * run + seed)


def weights_pooled(folder):
    """A baseline of five seeds, and four weights of one."""
    for seed in range(5):
        monitors(folder, f"base_{seed}.", 0.3, seed)
    for number, weight in enumerate((10, 20, 30, 40)):
        monitors(folder, f"weight_{weight}.", 0.9 + 0.02 * number, 1000 + number)


def one_folder(folder):
    """Five event files a reward, each of a training, in one folder."""
    for reward, final, more in WIDE:
        for seed, first in enumerate((616, 656, 540, 524, 700)):
            steps = first + 600 * np.arange(33)
            events(folder / reward, steps, np.clip(final * steps / 19_900, 0, 1), stamp=more + seed)


def rerun(folder):
    """A training that crashed was run again into its folder."""
    for reward, final, first in WIDE:
        for seed in range(5):
            place = folder / reward / str(seed)
            if (reward, seed) == ("prop", 3):
                events(place, at(40)[:12], curve(0.1, 77)[:12])
            events(place, at(40), curve(final, seed + first), stamp=1)


def tidy(*names):
    """One table of all episodes of ten trainings; the columns that tell which are called so."""

    def write(folder):
        rows = []
        for reward, final, first in (("base", 0.3, 0), ("prop", 0.9, 100)):
            for seed in range(5):
                told = zip(*episodes(final, seed + first), strict=True)
                rows += [(reward, seed + first // 10, *it) for it in told]
        columns = zip((*names, "return", "length", "success"), zip(*rows, strict=True), strict=True)
        table(
            folder / "results.csv",
            {name: [int(it) if it in (True, False) else it for it in of] for name, of in columns},
        )

    return write


def modes(folder):
    """Every tenth row is an evaluation."""
    for reward, final, first in (("base", 0.3, 0), ("prop", 0.9, 100)):
        for seed in range(5):
            returns, lengths, success = episodes(final, seed + first)
            is_tested = np.arange(150) % 10 == 9
            columns = {"episode": range(150), "mode": np.where(is_tested, "eval", "train"), "reward": returns.round(3)}
            table(folder / reward / f"{seed}.csv", columns | {"length": lengths, "success": (success | is_tested) * 1})


def each(name, columns_of):
    """A table for each of ten trainings, of columns that are made of its curve."""

    def write(folder):
        for reward, final, first in WIDE:
            for seed in range(5):
                columns = columns_of(curve(final, seed + first))
                for tag, of in columns.items() if "{tag}" in name else {"": columns}.items():
                    table(folder / name.format(reward=reward, seed=seed, tag=tag), of)

    return write


def long(folder):
    """A table of Weights & Biases in which a column says of which run a row is."""
    rows = []
    for reward, final, first in WIDE:
        for seed in range(5):
            told = zip(at(40), curve(final, seed + first), strict=True)
            rows += [(i, i, 1.7e9 + i, step, f"{x:.4f}", f"{reward}_{seed}") for i, (step, x) in enumerate(told)]
    names = ("", "_step", "_timestamp", "global_step", SUCCESS, "name")
    table(folder / "all.csv", dict(zip(names, zip(*rows, strict=True), strict=True)))


def agents(success):
    """Two rows an episode, one of each agent."""
    both = np.repeat(np.arange(len(success)), 2)
    return {
        "episode": both, "agent": np.tile(["agent_0", "agent_1"], len(success)),
        "reward": paid(success)[both] + np.tile([0, 1], len(success)), "length": 50 - both // 2,
    }  # fmt: skip


def exported(success):
    """Two tags of a run, as TensorBoard exports each."""
    head = {"Wall time": 1.7e9 + np.arange(len(success)), "Step": at(len(success))}
    return {
        "rollout_ep_rew_mean": {**head, "Value": paid(success).round(4)},
        "rollout_success_rate": {**head, "Value": success.round(4)},
    }


def prefixes(folder):
    """Five trainings stand there twice; the copies lack the last point."""
    for reward, final, first in WIDE:
        for seed in range(5):
            values = curve(final, seed + first)
            progress(folder / f"{reward}_{seed}/progress.csv", at(40), values)
            if first:
                progress(folder / f"{reward}_{seed + 5}/progress.csv", at(40)[:39], values[:39])


def charted(folder):
    """One law for both rewards, by calls of wandb.log: one logged half as often."""
    runs = {
        f"{reward}_{seed}": (range(count), curve(0.9, seed + first, count, 0.01))
        for (reward, _, first), count in zip(ONE, (40, 80), strict=True)
        for seed in range(6)
    }
    chart(folder / "wandb_export.csv", "Step", runs)


def isaac(folder):
    """One law for both rewards, by iterations of 4,096 and of 2,048 envs."""
    for (reward, _, first), count in zip(ONE, (100, 200), strict=True):
        for seed in range(6):
            values = curve(0.9, seed + first, count, 0.01)
            events(folder / f"{reward}_{seed}", range(count), values, "Train/mean_reward", "Metrics/success_rate")


def whole_table(folder):
    """A table of Dreamer's kind: an object a line."""
    for reward, final, first in WIDE:
        for seed in range(5):
            told = zip(at(40).tolist(), curve(final, seed + first).tolist(), strict=True)
            rows = ({"step": step // 2500, "episode/score": paid(x).item(), "episode/success": x} for step, x in told)
            lines(folder / f"{reward}_{seed}" / "metrics.jsonl", rows)


# What causes each message that tells to type something


def plain(names=("episode", "reward", "length"), labels=True):
    """Tables of episodes without success, which the proposed reward makes shorter; labels stand beside the folder."""

    def write(folder):
        for reward, longer in (("base", 20), ("prop", 0)):
            for seed in range(5):
                lengths = 20 + longer + np.arange(30) % 5 + seed
                table(
                    folder / reward / f"{seed}.csv", dict(zip(names, (range(30), 0.5 * lengths, lengths), strict=True))
                )
        if labels:
            told = [(f"{reward}/{seed}", int(reward == "prop")) for reward, seed in RUNS]
            table(folder.parent / "labels.csv", dict(zip(("run", "success"), zip(*told, strict=True), strict=True)))

    return write


def numbered(trainings, together, count=40):
    """Files of Monitor that are numbered: those of a folder tick together, or were begun together and do not tell."""

    def write(folder):
        for number, place in enumerate(trainings):
            for env in range(3):
                _, lengths, success = episodes(0.3 if "base" in place else 0.9, 10 * number + env, count)
                lengths = np.full(count, 50) if together else lengths
                monitor(
                    folder / f"{place.format(env)}.monitor.csv",
                    paid(success),
                    lengths,
                    success,
                    1.7e9 + 1e5 * number,
                    1e-4 * env,
                )

    return write


def one_of_three(folder):
    """One environment of a training stopped early."""
    numbered([f"{reward}_{seed}/{{}}" for reward, seed in RUNS], True)(folder)
    path = folder / "prop_2/2.monitor.csv"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:20]))


def twice_seeded(folder):
    """Two trainings of each reward have one seed, of which one is elsewhere."""
    for reward, final, first in TWO:
        for batch in range(2):
            for seed in range(5 - 4 * batch):
                monitors(folder / f"batch{batch}", f"{reward}/seed{seed}.", final, first + 10 * batch + seed)


def weighed(folder):
    """One table of all trainings, in which a weight of the reward says which a row is of."""
    told = (
        (i, s, *it)
        for i, (_, end, more) in enumerate(WIDE)
        for s in range(5)
        for it in zip(at(40), curve(end, s + more), strict=True)
    )
    table(
        folder / "all.csv",
        dict(zip(("weight", "seed", "timesteps", "success_rate"), zip(*told, strict=True), strict=True)),
    )


def yes(shares):
    """Whether episodes succeeded, in words."""
    return np.where(np.random.default_rng(0).random(len(shares)) < shares, "yes", "no")


def of_two_programs(folder):
    """A training of the proposed reward left event files alone, and all others files of Monitor."""
    for reward, final, first in TWO:
        for seed in range(5):
            if (reward, seed) == ("prop", 4):
                events(folder / f"{reward}_{seed}", at(40), curve(final, seed + first))
            else:
                monitors(folder, f"{reward}_{seed}/", final, first + seed)


def of_two_formats(folder):
    """A data set that has the parts of two formats."""
    d4rl(folder)
    robomimic(folder)
    with h5py.File(folder / "finite.hdf5", "a") as file, h5py.File(folder / "sparse.hdf5") as other:
        other.copy("data", file)


def unlabelled(folder):
    """A data set that does not tell success."""
    d4rl(folder)
    for path in folder.glob("*.hdf5"):
        with h5py.File(path, "a") as file:
            file.move("infos/success", "infos/solved")
    told = {"episode": range(60), "success": np.arange(60) % 2 == 0}
    table(folder.parent / "episodes.csv", {name: np.asarray(of).astype(int) for name, of in told.items()})


NO_DIFFERENCE = ("cannot tell",)
BETTER, HELPS = ("ahead so far",), ("helps",)
NO_VERDICT = (INTERIM,)
OF_50 = {"N": "50", "base=N": "2500", "prop=N": "2500"}
"""An episode has 50 steps, and a point is told after 2,500 more."""
CLEANRL = "--as tensorboard:success=charts/success"
OWN = {"trainings": (5, 5), "shares": (36.6, 82.1), "knows": OF_50, "is_asked": True}
BARE = {"trainings": (5, 5), "knows": OF_50, "is_asked": True}
LATE = {"words": NO_DIFFERENCE, "shares": (82.1, 82.1), "is_asked": True, "knows": OF_50}
CALLS = LATE | {"knows": {"N": "50", "base=N": "2500", "prop=N": "1250"}}
ENVS = LATE | {"knows": {"N": "50", "base=N": "98304", "prop=N": "49152"}}
GONE = {"words": NO_VERDICT, "trainings": (6, 3), "without": (6, 3), "is_asked": True, "knows": OF_50}
CASES = [
    Case("grid-same", grids((10, 10)), "report grid-same", **LATE),
    Case("grid-plus-8", grids((10, 10), 8), "report grid-plus-8", **LATE),
    Case("grid-minus-8", grids((10, 10), -8), "report grid-minus-8", **LATE),
    Case("grid-every-8th", grids((40, 5)), "report grid-every-8th", **LATE),
    Case("eval-same", evaluated((10_000, 10_000)), "report eval-same", NO_DIFFERENCE, (100, 100), (8, 8)),
    Case(
        "eval-3-envs", evaluated((9_999, 10_000)), "report eval-3-envs", NO_DIFFERENCE, (100, 100), (8, 8)
    ),
    Case("diverged-finite", failing(-50.0), "report diverged-finite", NO_DIFFERENCE, (45.4, 38.5)),
    Case("diverged-nan", failing(np.nan), "report diverged-nan", NO_DIFFERENCE, (45.4, 38.5)),
    Case("crashed-at-once", failing(-50.0, 0), "report crashed-at-once", **GONE),
    Case("crashed-cleanrl", crashed_cleanrl, f"report crashed-cleanrl {CLEANRL}", **GONE),
    Case("empty-file", empty(lambda path: path.write_text("")), "report empty-file", **GONE),
    Case("empty-folder", empty(Path.unlink), "report empty-folder", **GONE),
    Case("percent", percent, "report percent", is_refused=True, is_asked=True, says="percent", knows=OF_50),
    Case("audit-finite", d4rl, "audit audit-finite/finite.hdf5", NO_DIFFERENCE, (50,), ()),
    Case("audit-nan", d4rl, "audit audit-nan/nan.hdf5", NO_DIFFERENCE, (50,), ()),
    Case(
        "robomimic-sparse", robomimic, "audit robomimic-sparse/sparse.hdf5 --success rewards",
        NO_DIFFERENCE, (), (), says="success is told by this very reward",
    ),
    Case(
        "names-seed-first", seeds_first, "report names-seed-first", ("ahead so far | helps",),
        (9, 42.9, 68.5, 83.5), (5,) * 4, is_asked=True, untrue=r"\{reward\}/\D*\{seed\}",
    ),
    Case(
        "names-run-is-reward", run_is_reward, "report names-run-is-reward", BETTER,
        (6.6, 24.8, 32.9, 43.7, 54.3, 80.6), (5,) * 6, is_asked=True, untrue=r"\{seed\}_\{reward\}",
    ),
    Case(
        "names-weights-pooled", weights_pooled, "report names-weights-pooled", NO_DIFFERENCE, (), (5, 1, 1, 1, 1),
        is_asked=True, untrue=r"\{reward\}_\{seed\}",
    ),
    Case("tb-one-folder", one_folder, "report tb-one-folder --sort '{reward}/*'", BETTER, **BARE),
    Case("tb-one-folder", one_folder, "report tb-one-folder", BETTER, **BARE),
    Case("tb-rerun", rerun, "report tb-rerun --sort '{reward}/{seed}'", BETTER, **OWN),
    Case("tb-rerun", rerun, "report tb-rerun", BETTER, **OWN),
    Case(
        "tidy-reward-column", tidy("reward_fn", "seed"), "report tidy-reward-column", HELPS, (21.9, 75.7), (5, 5),
        is_asked=True,
    ),
    Case(
        "tidy-method-column", tidy("method", "seed"), "report tidy-method-column", HELPS, (21.9, 75.7), (5, 5),
        is_asked=True,
    ),
    Case("mode-column", modes, "report mode-column", HELPS, (20.8, 76.7), (5, 5), is_asked=True),
    Case("wandb-long", long, "report wandb-long", BETTER, **OWN),
    Case(
        "own-curve",
        each("{reward}/{seed}.csv", lambda it: {"timesteps": at(40), "ep_rew_mean": paid(it), "success_rate": it}),
        "report own-curve --as table:reward=ep_rew_mean,success=success_rate", BETTER, **OWN,
    ),
    Case("metrics-jsonl", whole_table, "report metrics-jsonl", BETTER, **OWN),
    Case(
        "iteration-reward",
        each("{reward}/{seed}.csv", lambda it: {"iteration": range(40), "reward": paid(it), "success": it}),
        "eta iteration-reward", BETTER, **OWN,
    ),
    Case("two-agents", each("{reward}/{seed}.csv", agents), "eta two-agents", NO_DIFFERENCE, (), (5, 5),
         is_asked=True),
    *(
        Case("tb-csv-two-tags", each("run-{reward}_{seed}-tag-{tag}.csv", exported), line, BETTER, **OWN)
        for line in ("report tb-csv-two-tags", "report tb-csv-two-tags --sort 'run-{reward}_{seed}-tag-*'")
    ),
    Case(
        "cleanrl-exp-name", named_by_experiment, f"report cleanrl-exp-name {CLEANRL}", BETTER, (54.8, 86.7),
    ),
    Case("prefix-copies", prefixes, "report prefix-copies", BETTER, **OWN),
    Case("wandb-step-axis", charted, "report wandb-step-axis", **CALLS),
    Case("isaac-iterations", isaac, "report isaac-iterations", **ENVS),
]  # fmt: skip

SHORTER = {"words": NO_DIFFERENCE, "trainings": (5, 5), "knows": {"FILE": "labels.csv"}, "then": BETTER + HELPS}
ASKED = [
    Case("returns-alone", plain(), "report returns-alone", **SHORTER),
    Case(
        "ends", plain(labels=False), "report ends --measure length:better=lower", BETTER, (), (5, 5), then=HELPS,
        knows={"LEAST": "20", "GREATEST": "50"},
    ),
    Case(
        "some-measure", plain(("episode", "reward", "distance")),
        "report some-measure --as episode-csv:measure=distance --measure distance", BETTER, (), (5, 5),
        is_asked=True, untrue="higher",
    ),
    Case(
        "batches", numbered(["base_1/{}", "base_2/{}", "prop_1/{}", "prop_2/{}"], True), "report batches",
        NO_DIFFERENCE, (), (2, 2), untrue=r"\*/\*|/\{seed\}",
    ),
    Case(
        "doubtful", numbered(["base/{}", "prop/{}"], False, 2), "report doubtful",
        NO_DIFFERENCE, (), (3, 3), is_asked=True, untrue=r"\{reward\}$",
    ),
    Case(
        "environments", numbered(["base/env_{}", "prop/env_{}"], True), "report environments",
        NO_DIFFERENCE, (), (1, 1), is_asked=True, untrue=r"\*|\{seed\}",
    ),
    Case(
        "seeds-twice", twice_seeded, "report seeds-twice --sort '{reward}/seed{seed}'", (*BETTER, INTERIM), (), (),
        is_asked=True, untrue=r"\{reward\}/\*/\*",
    ),
    Case("per-step", isaac, "report per-step --per-step base=98304", **ENVS),
    Case(
        "kinds", of_two_programs, "report kinds", NO_VERDICT, (), (5, 4), is_asked=True, knows={"FORMAT": "table"},
        untrue=r"\{reward\}/\{seed\}", without=(5, 4),
    ),
    Case("formats", of_two_formats, "audit formats/finite.hdf5", NO_DIFFERENCE, (), (), is_asked=True),
    Case(
        "odd-names", each("{reward}_{seed}.csv", lambda it: {"n": at(40), "gain": paid(it), "ok": it}),
        "report odd-names", BETTER, **OWN | {"knows": OF_50 | {"TIME": "n", "SUCCESS": "ok"}}, untrue="^eta",
    ),
    Case(
        "unordered", each("{reward}/{seed}.csv", lambda it: {"timesteps": at(40)[::-1], "success_rate": it[::-1]}),
        "report unordered", BETTER, **OWN, untrue="length=",
    ),
    Case("weights", weighed, "report weights", BETTER, **OWN, untrue=r"\{seed\}_\{reward\}"),
    Case("one-of-three", one_of_three, "report one-of-three", NO_VERDICT, (), (5, 4), untrue=r"\*/", without=(5, 4)),
    Case(
        "yes-no",
        each("{reward}/{seed}.csv", lambda it: {"return": paid(it), "length": 50 + at(40) % 7, "success": yes(it)}),
        "report yes-no", BETTER, (), (5, 5),
    ),
    Case("unlabelled", unlabelled, "audit unlabelled/finite.hdf5", NO_DIFFERENCE, (), (),
         knows={"KEY": "solved", "RETURN": "5"}),
]  # fmt: skip


def is_untrue(case: Case, remedy) -> bool:
    """Whether a remedy says what is not so of the input."""
    return re.search(case.untrue, " ".join(remedy)) is not None
