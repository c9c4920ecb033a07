"""A call that computes for too long is ended where that harms nobody; what cannot be ended is told."""

import os
import random
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import numpy as np
import pytest

from harness.record import read_recording
from harness.recorder import guard, limit
from harness.recorder.computing import may_wait
from harness.recorder.guard import Guard
from harness.recorder.trial import Trial
from tests.recorder.conftest import take

pytestmark = pytest.mark.skipif(not limit.ENDS, reason="calls are only told here")
SLOW_MODULE = """
import time

def nothing():
    pass

begin = time.thread_time()
while time.thread_time() - begin < 0.4:
    nothing()
done = True
"""


def _loop():
    while True:
        pass


def _of_condition(value=1):
    while value:
        pass


def _inner():
    def inner():
        _of_condition()

    inner()


def _recursion():
    def again(count):
        return again(count - 1) if count else 0

    for _ in iter(int, 1):
        again(50)


def _caught():
    while True:
        try:
            for _ in range(1_000_000):
                pass
        except Exception:
            pass


def _swallowed():
    try:
        _loop()
    except:  # noqa: E722
        return 1.0


def _generator():
    return sum(each for each in iter(int, 1))


@pytest.fixture(params=["main thread", "another thread"])
def asked(request):
    """Calls a function under a limit of 0.1 s, and returns its answer or its error."""
    limit.look_on()

    def ask(function):
        answers = []

        def run():
            try:
                answers.append(limit.call(function, (), 0.1))
            except TimeoutError as error:
                answers.append(str(error))

        if request.param == "main thread":
            run()
        else:
            thread = threading.Thread(target=run)
            thread.start()
            thread.join()
        return answers[0]

    return ask


@pytest.mark.parametrize("function", [_loop, _of_condition, _inner, _recursion, _caught, _swallowed, _generator])
def test_what_computes_for_ever_is_ended(asked, function):
    """Whatever it catches; and the next call is a call like others."""
    assert asked(function) == "it has not returned after 0.1 s of computing"
    assert asked(lambda: sum(range(10))) == 45


class _PutsBack:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        _burn(0.4)


def _burn(seconds):
    begin = time.thread_time()
    while time.thread_time() - begin < seconds:
        pass


def _sleeps():
    time.sleep(0.4)
    return "done"


def _imports():
    import slow_module_of_a_reward as module  # type: ignore[import-not-found]

    return "done" if module.done else ""


def _puts_back():
    with _PutsBack():
        pass
    return "done"


@pytest.mark.parametrize("function", [_sleeps, _imports, _puts_back])
def test_what_must_not_be_ended_is_told(function, tmp_path, monkeypatch, capsys):
    """Once, with its name and line; it returns what it returns."""
    (tmp_path / "slow_module_of_a_reward.py").write_text(SLOW_MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    limit.look_on()
    assert limit.call(function, (), 0.1) == "done"
    told = capsys.readouterr().err
    assert f"harness: {function.__name__} (test_limit.py, line " in told
    assert told.count(f"harness: {function.__name__} ") == 1
    assert "only a loop of Python is ended" in told


def test_where_ending_was_not_tried_a_call_is_told(monkeypatch, capsys):
    """On another version of Python; no time of its thread is given."""
    monkeypatch.setattr(limit, "ENDS", False)
    limit.look_on()

    def slow():
        _burn(0.4)
        return "done"

    assert limit.call(slow, (), 0.1) == "done"
    told = capsys.readouterr().err
    assert "slow (test_limit.py, line " in told
    assert "computing" not in told


def test_a_child_looks_on_too():
    """A process that was forked in a call, whose threads are gone."""

    def forks():
        child = os.fork()
        if child == 0:
            try:
                limit.call(_loop, (), 0.1)
            except TimeoutError:
                os._exit(7)
            os._exit(1)
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

    limit.look_on()
    assert limit.call(forks, (), 60.0) == 7


def test_a_limit_around_another_ends_the_outer_call():
    """And the inner one ends the inner call."""
    limit.look_on()
    with pytest.raises(TimeoutError, match=r"0\.1 s"):
        limit.call(lambda: [limit.call(sum, (range(1_000),), 60.0) for _ in iter(int, 1)], (), 0.1)
    with pytest.raises(TimeoutError, match=r"0\.1 s"):
        limit.call(lambda: limit.call(_loop, (), 0.1), (), 60.0)


@pytest.mark.parametrize("function", [_loop, _caught, _swallowed])
def test_a_training_goes_on(function, record, tmp_path, monkeypatch):
    """The reward is given up by name; what pays is recorded."""
    monkeypatch.setattr(guard, "LONGEST_TRIAL", 0.1)
    env = record(rewards={"stuck": lambda *_: function()})
    with pytest.warns(UserWarning, match="'stuck'.*TimeoutError: it has not returned after 0.1 s of computing"):
        take(env, np.zeros((5, 1), np.float32), None)
    rows = read_recording(tmp_path / "run")
    assert np.isnan(rows["reward/stuck"]).all()
    assert rows["reward/own"].tolist() == [1, 2, 3, 1, 2]


def stuck_at_300(observation, action, next_observation, info):
    """Only computes, and does not end in its 300th step."""
    return sum([1.0 for _ in range(10**12 if next_observation[0] == 300.0 else 1)])


def test_a_late_call_is_ended(counting, record, tmp_path):
    """Its own step is told, and what was said before stays; a block that took long by itself goes on."""
    assert may_wait(stuck_at_300)
    env = record(counting(10**6), rewards={"stuck": stuck_at_300})
    env.reset(seed=0)
    for _ in range(260):
        env.step(np.zeros(1, np.float32))
    env._recorder.guard.longest = 0.1
    with pytest.warns(UserWarning, match=r"'stuck' failed in env 0, episode 0, step 299: TimeoutError: .* 0\.1 s"):  # noqa: PT031
        for _ in range(300):
            env.step(np.zeros(1, np.float32))
    env.close()
    paid = read_recording(tmp_path / "run")["reward/stuck"]
    assert np.isfinite(paid[:299]).all()
    assert np.isnan(paid[299:]).all()


def slow(observation, action, next_observation, info):
    """Takes some milliseconds, and ends."""
    return sum([1.0 for _ in range(20_000)])


def test_calls_that_together_take_longer_than_one_may_are_not_ended():
    """What was not finished is asked again."""
    asking = Guard()
    asking.longest = 0.1
    assert asking.ask([slow] * 300, [(0, 0, 0, 0)] * 300, is_watched=False) == [20_000.0] * 300


def test_the_trial_is_given_longer():
    """What compiles does so in it."""
    asking = Guard()
    assert asking.longest == limit.LONGEST_TRIAL
    assert not [*Trial(None, asking).look([])]
    assert asking.longest == limit.LONGEST


@pytest.mark.slow
def test_what_a_reward_imports_the_learner_imports_too():
    """A limit that ends in the middle of it leaves torch whole."""
    pytest.importorskip("torch")
    script = """
from harness.recorder import limit
limit.look_on()
def soft():
    import torch
    return float(torch.zeros(1)[0])
try:
    limit.call(soft, (), 0.3)
except TimeoutError:
    pass
import torch
print(torch.ones(2).sum().item())
"""
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (found.returncode, found.stdout) == (0, "2.0\n"), found.stderr


WITHIN = "if frame.f_lasti == at and run in _running:"
TAKES_BACK = "            _raise(*run.undo)\n"
CLOSED = {
    "as it is": ({}, False, False),
    "no second look": ({WITHIN: "if run in _running:"}, True, False),
    "no second look, nothing taken back": ({WITHIN: "if True:", TAKES_BACK: "            pass\n"}, True, True),
}


@pytest.mark.parametrize("case", CLOSED)
def test_nothing_is_raised_elsewhere_or_later(case, monkeypatch):
    """Thousands of calls that end about at the limit, while the thread that looks on is kept up between look and raise.

    Each goes from a loop that may be ended to one that may not, and back.
    """
    mutations, is_inside, is_late = CLOSED[case]
    source = Path(limit.__file__).read_text()
    mutations = {**mutations, WITHIN: f"time.sleep(0)\n        {mutations.get(WITHIN, WITHIN)}"}
    for old, new in mutations.items():
        assert old in source
        source = source.replace(old, new)
    copy = types.ModuleType("copy_of_limit")
    monkeypatch.setitem(sys.modules, copy.__name__, copy)
    exec(compile(source, "copy_of_limit.py", "exec"), vars(copy))
    luck, is_over = random.Random(0), False

    def look_again(_):
        time.sleep(0)
        if is_over:
            threading.Event().wait()

    copy.sleep, copy.print_visible = look_again, lambda *_, **__: None
    inside = late = ended = 0

    class Closed:
        def __enter__(self):
            return self

        def __exit__(self, *_):
            nonlocal inside
            try:
                for _ in range(20):
                    pass
            except copy.NoAnswer:
                inside += 1
                raise

    def steps(until):
        while time.perf_counter() < until:
            with Closed():
                pass
            for _ in range(20):
                pass

    copy.look_on()
    often, end = sys.getswitchinterval(), time.monotonic() + 20.0
    sys.setswitchinterval(1e-6)
    is_shown = False
    while not is_shown:
        try:
            while not is_shown:
                try:
                    copy.call(steps, (time.perf_counter() + luck.uniform(0.0, 0.01),), 0.002)
                except TimeoutError:
                    ended += 1
                is_shown = time.monotonic() >= end or (ended > 9 and inside >= is_inside and late >= is_late)
        except copy.NoAnswer:
            late += 1
    is_over = True
    sys.setswitchinterval(often)
    assert ended
    assert (inside > 0, late > 0) == (is_inside, is_late)
