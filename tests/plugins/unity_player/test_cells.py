"""Whole experiments with players, from the command line: what a death costs, and that nothing is left."""

import hashlib
import os
import random
import subprocess
import sys
import time

import numpy as np
import psutil
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.record import CELLS, LOG, MANIFEST, Store
from harness.registry.allowed import PROGRAMS
from tests.plugins.unity_player.conftest import players_of
from tests.registered import REGISTRY

KILLS = 30


def command(program, out, *more):
    """Four short trainings."""
    asked = f"unity:file={program},places=unity-arm,patience=20"
    return [
        *(sys.executable, "-m", "harness", "run", "--task", asked, "--algo", "random", "--reward", "own,arp"),
        *("--seeds", "2", "--steps", "300", "--evaluation-episodes", "1", "--evaluation-horizon", "50"),
        *("--jobs", "2", "--out", str(out), *more),
    ]


def left(folder):
    """Digests of all that the cells left, but what tells of time and place."""
    files = [path for path in (folder / CELLS).rglob("*") if path.is_file() and path.suffix == ".parquet"]
    assert all(path.name not in (MANIFEST, LOG) for path in files)
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def begin(words):
    """A run in a session of its own."""
    quiet = subprocess.DEVNULL
    return subprocess.Popen(words, stdout=quiet, stderr=quiet, start_new_session=True)


def test_a_player_that_dies_costs_its_cell_alone(player, tmp_path):
    """The reason stands in the manifest; another call tries it again, and no other."""
    program, out = player("--horizon", "500"), tmp_path / "out"
    process = begin(command(program, out))
    until = time.monotonic() + 60.0
    # Two at once belong to cells: the first one alone was started to plan them.
    while len(killed := [pid for pid in players_of(tmp_path) if is_playing(pid)]) < 2 and time.monotonic() < until:
        time.sleep(0.02)
    psutil.Process(killed[0]).kill()
    assert process.wait() == 1
    manifests = Store(out).manifests()
    failed = [it for it in manifests if it.status == "failed"]
    assert len(manifests) == 4
    assert len(failed) == 1
    assert all("the player ended (signal 9" in it.reason for it in failed)
    assert subprocess.run(command(program, out), capture_output=True, check=False).returncode == 0
    assert {it.status for it in Store(out).manifests()} == {"done"}


def is_playing(pid):
    """Whether a process is a player, and not what guards it."""
    try:
        return "harness_plugins.kit.unity_player" in psutil.Process(pid).cmdline()
    except psutil.Error:
        return False


def test_a_program_in_an_experiment_file_is_not_started(player, tmp_path):
    """Whoever wrote the file says nothing about this machine; the user's word is asked for."""
    program = player()
    (tmp_path / "experiment.toml").write_text(
        f'task = {{ name = "unity", file = "{program}" }}\n'
        'algo = "random"\nreward = ["own", "own"]\nseeds = 1\nsteps = 20\n'
    )
    surroundings = {**os.environ, PROGRAMS: ""}
    words = [sys.executable, "-m", "harness", "run", str(tmp_path / "experiment.toml"), "--dry-run"]
    told = subprocess.run(words, capture_output=True, text=True, check=False, env=surroundings)
    assert told.returncode == 2
    assert "--allow-program" in told.stderr
    allowed = [*words, "--allow-program", str(program)]
    told = subprocess.run(allowed, capture_output=True, text=True, check=False, env=surroundings)
    assert told.returncode == 0


@pytest.mark.slow
def test_killed_runs_and_players_lose_nothing(player, tmp_path):
    """KILL to the harness or to a player: afterwards all is as in an undisturbed run, and nothing is left."""
    program, rng = player("--horizon", "500"), random.Random(3)
    began = time.monotonic()
    assert begin(command(program, tmp_path / "whole")).wait() == 0
    seconds, expected, kills, round_number = time.monotonic() - began, left(tmp_path / "whole"), 0, 0
    while kills < KILLS:
        out, finished = tmp_path / f"killed-{round_number}", False
        round_number += 1
        while not finished:
            done = {it.cell.id for it in Store(out).manifests() if it.status == "done"} if out.exists() else set()
            process = begin(command(program, out))
            if kills < KILLS:
                time.sleep(rng.uniform(0.0, seconds))
                playing = [pid for pid in players_of(tmp_path) if is_playing(pid)]
                if rng.random() < 0.5 or not playing:
                    kills += process.poll() is None
                    process.kill()
                else:
                    psutil.Process(rng.choice(playing)).kill()
                    kills += 1
            finished = process.wait() == 0
            until = time.monotonic() + 20.0
            while players_of(tmp_path) and time.monotonic() < until:
                time.sleep(0.05)
            assert players_of(tmp_path) == []
            now = {it.cell.id for it in Store(out).manifests() if it.status == "done"} if out.exists() else set()
            assert done <= now
        assert left(out) == expected


def test_rewards_are_paid_again_from_the_exported_file(player, start, tmp_path):
    """What a recording holds is all that the rewards of an arm are functions of, in a task of a step per decision."""
    from harness import RecordRewards
    from harness.registry import choose
    from harness.score.csv_steps import StepsCsv
    from harness.score.scorer import pay_log
    from harness_plugins.environments.unity import Unity
    from harness_plugins.exporters.csv_runs import write_recording_csv

    places = "end_effector=19:22,target=22:25,renewed=22:25"
    unity, registry = Unity(file="x", places=places, pays="baseline+arp+aarp+relative"), REGISTRY
    env = start("--positions", "--horizon", "100")
    recorded = RecordRewards(
        env, tmp_path / "run", trained_with="own", seed=0, rewards=unity.rewards(env), behaviour=unity.behaviour(env)
    )
    rng = default_rng(0)
    recorded.reset(seed=0)
    for _ in range(400):
        _, _, terminated, truncated, _ = recorded.step(rng.uniform(-0.4, 0.4, 5).astype(np.float32))
        if terminated or truncated:
            recorded.reset()
    recorded.close()
    write_recording_csv(tmp_path / "run", tmp_path / "run.csv")
    rows = experimenters_rows(tmp_path / "run.csv")
    for name in ("baseline", "arp", "aarp", "relative"):
        path = tmp_path / f"{name}.csv"
        path.write_text(
            "t,beginDistance,prevBest,distance,reward\n"
            + "".join(f"{t},{b!r},{p!r},{d!r},{paid[name]!r}\n" for t, b, p, d, paid in rows)
        )
        reward = choose(registry, "rewards", name).build(registry, "rewards")
        assert_allclose(pay_log(reward, StepsCsv().read(path)[0]).total, [row[4][name] for row in rows], atol=1e-6)


def experimenters_rows(path):
    """Rows in the experimenters' form: one with reward 0 at each start, and the best distance before each step."""
    import csv

    rows = []
    best, episode, targets = np.inf, None, 0.0
    for row in csv.DictReader(path.read_text().splitlines()):
        begin, distance = float(row["behaviour_begin_distance"]), float(row["behaviour_final_distance"])
        paid = {name.removeprefix("reward_"): float(row[name]) for name in row if name.startswith("reward_")}
        if row["episode"] != episode:
            rows.append((0, begin, begin, begin, dict.fromkeys(paid, 0.0)))
            episode, best, targets = row["episode"], begin, 0.0
        rows.append((int(row["step"]) + 1, begin, min(best, begin), distance, paid))
        best = min(best, distance)
        if float(row["behaviour_targets"]) > targets:
            targets, best = float(row["behaviour_targets"]), np.inf
    return rows
