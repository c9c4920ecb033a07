"""A folder of twelve reward files, five of which spoil things: the other seven say what they say without the five."""

import numpy as np
import pytest

from harness.record import Store, read_recording
from harness.record.recording.recorded_training import recordings_in
from harness.recorder import guard

HEAD = "def {name}(observation, action, next_observation, info):\n"
GOOD = {
    "above": "    return float(next_observation[0] > 0.5)\n",
    "calm": "    return float(next_observation[0] - 0.1 * abs(next_observation[2]))\n",
    "cheap": "    return -float(action[0]) ** 2\n",
    "height": "    return float(next_observation[0])\n",
    "quick": "    return abs(float(next_observation[2]))\n",
    "turns": "    return float(next_observation[1] - observation[1])\n",
    "work": "    return float(action[0] * next_observation[2])\n",
}
SPOILS = {
    "a_halves": "    action /= 2\n    next_observation *= 0\n    info.clear()\n    return float(action[0])\n",
    "b_counts": "    COUNT.append(1)\n    return float(len(COUNT))\n\n\nCOUNT = []\n",
    "c_draws": """    import random
    import numpy as np

    np.random.seed(3)
    return np.random.rand() + random.random()
""",
    "d_raises": "    return 1 / 0\n",
    "e_waits": "    while True:\n        pass\n",
}


def _recorded(folder, bodies, say):
    """What a run with these files says of its steps, by recording and column, and in words."""
    rewards = folder / "rewards"
    rewards.mkdir(parents=True)
    for name, body in bodies.items():
        (rewards / f"{name}.py").write_text(HEAD.format(name=name) + body)
    asked = ["--plugin", rewards / "*.py", "--reward", "own,calm", "--algo", "random", "--seeds", "1"]
    size = ["--steps", "60", "--evaluation-episodes", "1", "--executor", "here"]
    pendulum = ["--task", "gymnasium:id=Pendulum-v1,made_with=max_episode_steps=20"]
    status, *said = say("run", *pendulum, *asked, *size, "--out", folder / "out")
    assert status == 0
    store = Store.open(folder / "out")
    found = {}
    for cell in store.read_plan().cells:
        for path in sorted(recordings_in(store.cell_folder(cell))):
            recording = read_recording(path)
            rows = recording.rows(f"reward/{name}" for name in recording.rewards)
            found |= {f"{cell.reward.name} {path.name} {name}": rows[f"reward/{name}"] for name in recording.rewards}
            found[f"{cell.reward.name} {path.name} told"] = [it.column for it in recording.facts.failures] + [
                *recording.facts.notes
            ]
    return found, "".join(said)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_five_files_that_spoil_change_no_number_of_the_others(toys, tmp_path, say, monkeypatch):
    """Bit for bit, in the training and in every evaluation; all five are named, by one command."""
    monkeypatch.setattr(guard, "LONGEST_TRIAL", 0.1)
    alone, _ = _recorded(tmp_path / "alone", GOOD, say)
    beside, said = _recorded(tmp_path / "beside", {**GOOD, **SPOILS}, say)
    compared = [name for name in alone if not name.endswith("told")]
    assert len(compared) >= 8 * 4
    for name in compared:
        assert np.array_equal(alone[name], beside[name]), name
        assert np.isfinite(beside[name]).all()
    for name in SPOILS:
        assert name in said
    recorded = {name for name in SPOILS if f"own training {name}" in beside}
    assert recorded == {"c_draws"}  # the others are left out before the first cell
    assert any("c_draws" in line for line in beside["own training told"])
