"""A world on a line, whose pay is known, and certificates of it."""

import io
from dataclasses import dataclass, replace

import numpy as np
from gymnasium.spaces import Box
from PIL import Image

from harness.registry import Choice
from harness_plugins.audit.search.behaviour import Behaviour, Searched
from harness_plugins.audit.search.certificate import Certificate
from harness_plugins.audit.search.film import Film
from harness_plugins.audit.search.finding import Disturbed, Finding
from harness_plugins.audit.search.place import Place
from harness_plugins.audit.search.world import Shown

HORIZON = 20
RUNS_ON = {"versions": {"python": "3.12", "numpy": "2.1"}, "machine": {"cpu": "one"}, "sources": {"reward": "a" * 64}}


@dataclass
class Line:
    """A point on a line, moved by each action; it is at the goal beyond 1 and is paid for being near 0.9.

    Attributes:
        scale: What its pay is multiplied by.
        leaks: Whether an episode begins where the one before ended.
    """

    scale: float = 1.0
    leaks: bool = False
    at: float = 0.0
    taken: int = 0

    name, reward, gamma, horizon, success, is_repeated = "line", "near", 0.9, HORIZON, "success", True
    space = Box(-1, 1, (1,), np.float32)
    observes = Box(-9, 9, (1,), np.float64)

    def show(self, start, actions):
        """Move by a tenth of each action."""
        begun = self.at if self.leaks else 0.01 * start
        at = begun + np.cumsum(0.1 * actions[:, 0].astype(float))
        steps = int(np.argmax(at > 1.0)) + 1 if (at > 1.0).any() else len(at)
        self.at, at = float(at[steps - 1]), at[:steps]
        near, cost = -self.scale * np.abs(0.9 - at), -0.01 * np.abs(actions[:steps, 0].astype(float))
        ended = "terminated" if at[-1] > 1.0 else "truncated"
        return Shown(
            start, actions[:steps], near + cost, {"near": near, "cost": cost}, at > 1.0, {"at": at}, ended
        )  # fmt: skip

    def play(self, starts, actions):
        """Not asked."""
        raise NotImplementedError

    act = play

    def close(self):
        """Nothing."""


def actions_to(goal):
    """Twenty actions that go somewhere and stay."""
    found = np.zeros((HORIZON, 1), np.float32)
    found[: int(10 * goal)] = 1.0
    found[int(10 * goal)] = 10 * goal % 1
    return found


def finding_of(world, start=3):
    """What a search of the line would say."""
    shown = {"failure": world.show(start, actions_to(0.9)), "success": world.show(start, actions_to(1.03))}
    shown["fastest"] = shown["success"]
    of = {role: _behaviour(it) for role, it in shown.items()}
    searched = Searched((of,), (of,), (-9.0,), (-9.0,), (9,), (0.0,), 400, ("sequences",))
    lines = ("Failing pays -2.6, succeeding -3.0, doing it fast -3.0.", "On 1 of 1 starts.")
    noise = tuple(
        Disturbed(role, level, -3.0 - 10 * level, 1.0 * (role != "failure"), 16)
        for role in shown
        for level in (0.0, 0.01, 0.05)
    )
    return Finding(
        "line", "near", 0.9, "success", "PAYS FOR FAILING", "ROBUST", lines, (start,), (start,), searched, noise,
        {"other": {"failure": -2.7}}, shown, of,
    )  # fmt: skip


def _behaviour(it):
    steps, success = len(it.paid), bool(it.success[-1])
    return Behaviour(it.start, it.actions, float(it.paid.sum()), 0.0, success, steps, steps, 0.1, {}, "script")


def place_of(reward="near"):
    """Where the line is."""
    return Place(Choice("line", (), "line"), Choice(reward, (("k", 1.5),), reward), success="success", horizon=HORIZON)


def certificate_of(**changed):
    """One of a behaviour on the line."""
    shown = Line().show(3, actions_to(0.9))
    answer = {"word": "PAYS FOR FAILING", "strength": "FRAGILE", "lines": ["One.", "Two."], "alarmed": 1, "starts": 2}
    found = {"made_by": "search", "seed": 0, "budget": 4000, "steps": 3990, "how": ["sequences"]}
    noise = [{"noise": at, "paid": -1.0, "success": 0.0, "episodes": 4} for at in (0.0, 0.05)]
    made = Certificate("failure", answer, place_of(), RUNS_ON, found, shown, noise, {"b": 1.0})
    return replace(made, **changed)


def drawn_of(steps, joints=6):
    """What an arm is drawn from."""
    time = 0.1 * np.arange(steps + 1.0)[:, np.newaxis]
    qpos, target = np.tile(np.sin(time), joints), np.tile([0.5, 0.0, 0.5], (steps + 1, 1))
    return {"time": time, "qpos": qpos, "target": target, "distance": 1.0 - 0.1 * time}


def film_of(steps):
    """Red pictures, at least one."""
    file = io.BytesIO()
    Image.new("RGB", (8 * len(steps), 6), "red").save(file, "WEBP")
    return Film("", steps, (8, 6), file.getvalue())


def whole_certificate():
    """One that holds all that a certificate may hold."""
    made = certificate_of()
    rating = {"starts": [1, 2, 3], "paid": [0.5, 1.0, -1.0], "success": [1, 0, 1]}
    policy = {"kind": "linear policy", "weights": [[0.0, 1.0]], "mean": [0.0], "scale": [1.0]}
    shown = replace(made.shown, drawn=drawn_of(len(made.shown.paid)))
    return replace(made, shown=shown, film=film_of((0, 10, 20)), policy=policy, rating=rating)
