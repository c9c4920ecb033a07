"""Built-in trackers, descriptions and screens, found by the registry: no contract kit speaks of them."""

import math
import threading
from dataclasses import replace

import pytest

from harness import load_registry
from harness.errors import UsageError
from harness.executor import TrackedCell
from harness.experiment.plan import check_experiment, expand
from harness.experiment.screening import CANNOT_TELL, NOTHING
from harness.registry.allowed import PROGRAMS
from harness.registry.choice import choose
from harness.registry.given import read_given
from tests.registered import REGISTRY

TRACKERS = {"tensorboard": "tensorboard", "wandb": "wandb:mode=offline"}
"""With settings with which nothing leaves this machine."""
LONG = "a/b\\c: 'ü' \"%s\" ../.. " * 500


def build(kind, given):
    """A registered thing; the test is skipped where the library is not installed."""
    spec = REGISTRY.get(kind, given.partition(":")[0])
    if spec.missing:
        pytest.skip(f"{', '.join(spec.missing)} is not installed: {spec.remedy}")
    return choose(REGISTRY, kind, given).build(REGISTRY, kind)


@pytest.mark.parametrize("name", REGISTRY.names("trackers"))
def test_tracker_takes_whatever_cells_tell(name, tmp_path, monkeypatch, capsys):
    """In another thread: two at once, one that goes on, odd numbers and texts; nothing printed, no link left."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("WANDB_X_SAVE_REQUIREMENTS", "false")  # else each of its runs reads about every distribution
    (tmp_path / "cells").mkdir()
    tracker, ended = build("trackers", TRACKERS.get(name, name)), list[bool]()
    assert tracker.why_not() == ""

    def follow():
        config = {"a": [64, 1.0, None, True]}
        cells = [TrackedCell(str(seed), LONG[seed:], "arp", config, tmp_path / "cells") for seed in (1, 2)]
        first, second = map(tracker.begin, cells)
        for value in (0.5, math.nan, math.inf, -1e300):
            first.log(100, {"value": value})
            second.log(100, {"value": value})
        first.end("done", "")
        second.log(200, {"other": 1.0})
        second.end("failed", LONG)
        again = tracker.begin(cells[0])
        again.log(300, {"value": 1.0})
        again.end("interrupted", "")
        ended.append(True)

    thread = threading.Thread(target=follow)
    thread.start()
    thread.join()
    assert ended
    assert capsys.readouterr().out == ""
    assert not [path for path in (tmp_path / "cells").rglob("*") if path.is_symlink()]


@pytest.mark.parametrize("name", REGISTRY.names("descriptions"))
def test_description_is_told_apart_and_damage_is_refused(name, tmp_path, monkeypatch):
    """Its example is recognised by that format alone and read the same twice; not where it is cut, nor with a slip."""
    form = build("descriptions", name)
    example = form.write_example(tmp_path)
    monkeypatch.setenv(PROGRAMS, str(example))
    specs = [REGISTRY.get("descriptions", each) for each in REGISTRY.names("descriptions")]
    forms = {spec.name: spec.load()() for spec in specs if not spec.missing}
    assert [each for each, it in forms.items() if it.recognises(example, example.read_bytes())] == [name]
    assert form.read(example, {}, {}) == form.read(example, {}, {})
    with pytest.raises(UsageError):
        form.read(example, {"no_such_argument_": "1"}, {})
    example.write_bytes(example.read_bytes()[: example.stat().st_size * 2 // 3])
    with pytest.raises(UsageError):
        form.read(example, {}, {})


def test_screen_says_the_same_in_any_order_and_beside_a_reward_that_raises(tmp_path):
    """Which has no alarm itself."""
    (tmp_path / "raises.py").write_text("def raises(step):\n    raise ValueError('no pay today')\n")
    registry = load_registry(given=read_given([str(tmp_path / "raises.py")]))
    screen = replace(build("screens", "cheats"), steps=1_000, steps_elsewhere=1_000, starts=1)
    small = {"sim": "kinematic", "algo": "random", "seeds": [0], "steps": 32, "evaluation_episodes": 1}
    cells = expand(check_experiment({**small, "baseline": "sparse", "reward": ["raises"]}), registry).cells
    said = screen.screen(cells, registry)
    told = dict(zip([cell.reward.label for cell in cells], said, strict=True))
    assert told["raises"] is None or told["raises"].word in (NOTHING, CANNOT_TELL)
    assert list(said) == list(screen.screen(cells[::-1], registry))[::-1]
    assert screen.screen([cell for cell in cells if cell.reward.label == "sparse"], registry) == [told["sparse"]]
