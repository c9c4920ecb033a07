"""The agents of one behaviour, as places that stay while agents come and go."""

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic
from typing import Any, NamedTuple

from harness import Float32
from harness.errors import UsageError

from .actions import Plain, to_unity
from .connection import Connection
from .messages import Behaviour, Message, Told, UnityError

MOST_SEEDS = 2**31
"""Unity's seeds are whole numbers of 32 bits."""


class Outcome(NamedTuple):
    """What a decision led to, for one agent."""

    observation: Float32
    reward: float
    terminated: bool = False
    truncated: bool = False


@dataclass
class Place:
    """Where an agent acts. When its episode ends, the next agent that asks takes its place.

    Attributes:
        agent: The number that Unity gave it; None until the next one asks. Unity numbers agents anew in each episode.
        first: The first observation of an episode that did not go on yet.
        action: What it does when it asks; None does nothing.
        outcome: Of the decision that is under way.
    """

    agent: int | None = None
    first: Float32 | None = None
    action: Plain | None = None
    outcome: Outcome | None = None


class Team:
    """All agents of a behaviour in one program. They decide together, as the envs of a vector env do.

    If an agent asks again before all others have asked, it repeats its last action, and its rewards are added up. So
    does an agent that asks while another one waits for its next episode.

    Attributes:
        behaviour: What they observe and do.
        size: How many there are: as many as asked after the first reset. Agents that come later do nothing.
    """

    def __init__(self, connect: Callable[[int], Connection], name: str, patience: float, *, restarts: bool) -> None:
        """Start the program, to learn what its agents are.

        Args:
            connect: Starts it with a seed.
            name: Of the behaviour; empty for the only one.
            patience: Seconds to wait for an agent that asks nothing.
            restarts: Whether it is started again with the first seed that is known: some programs read a seed only when
                they start.

        Raises:
            UnityError: Unity sends what cannot be used, or nothing.
            UsageError: There is no such behaviour, or there are several and none was named.
        """
        self._connect, self._patience, self._restarts = connect, patience, restarts
        self._connection, self._open = connect(0), 0
        self._awaited, self._noted, self._carried_out = set[int](), set[int](), set[int]()
        self._places: list[Place] = []
        try:
            message = self._connection.reset(None)
            self.behaviour = _chosen(self._connection.behaviours, name)
            until = monotonic() + patience
            while not message.asks[self.behaviour.name]:
                self._require_before(until)
                message = self._connection.act(self.behaviour.name, {})
            self._places = [Place() for _ in message.asks[self.behaviour.name]]
            self._settle(message)
        except BaseException:
            self._connection.close()
            raise
        self.size = len(self._places)

    def open(self) -> None:
        """One more env acts here."""
        self._open += 1

    def close(self) -> None:
        """One env less; the program ends with the last one."""
        self._open -= 1
        if self._open == 0:
            self.end()

    def end(self) -> None:
        """End the program."""
        self._connection.close()

    def begin(self, place: int, seed: int | None) -> Float32:
        """The first observation of an episode.

        Unity begins all agents anew at once. So the first place that asks for that has it done, and the others then get
        what they observed. After the end of an episode nothing is begun anew: Unity went on by itself.
        """
        it = self._places[place]
        if place in self._awaited or (seed is None and it.first is not None):
            self._awaited.discard(place)
        else:
            self._reset(seed)
            self._awaited = set(range(self.size)) - {place}
        if it.first is None:
            raise UsageError("an env of Unity is reset twice while the others of its program stand still")
        observation, it.first = it.first, None
        return observation

    def note(self, place: int, action: Any) -> None:
        """What an agent does in the step that all take next."""
        self._places[place].action = to_unity(self.behaviour, action)
        self._noted.add(place)

    def step(self, place: int, action: Any) -> Outcome:
        """What an agent's action led to. The first of those whose actions were noted has all of them carried out."""
        if place in self._carried_out:
            self._carried_out.discard(place)
        else:
            if place not in self._noted:
                self.note(place, action)
            self._decide()
            self._carried_out, self._noted = self._noted - {place}, set()
        outcome = self._places[place].outcome
        if outcome is None:
            raise UsageError("an env of Unity takes a step after another one of its program began all anew")
        return outcome

    def _decide(self) -> None:
        """Let all agents act, until each one asks again or has ended, and those that ended have begun anew."""
        self._awaited.clear()
        for place in self._places:
            place.first, place.outcome = None, None
        until = monotonic() + self._patience
        while True:
            self._read(self._act())
            if all(place.outcome is not None and place.agent is not None for place in self._places):
                return
            self._require_before(until)

    def _reset(self, seed: int | None) -> None:
        if seed is not None and self._restarts:
            self._restarts = False
            self._connection.close()
            self._connection = self._connect(seed % MOST_SEEDS)
        self._settle(self._connection.reset(seed))

    def _settle(self, message: Message) -> None:
        """Wait until an agent is in every place."""
        for place in self._places:
            place.agent = place.first = place.action = place.outcome = None
        until = monotonic() + self._patience
        self._read(message)
        while any(place.agent is None for place in self._places):
            self._require_before(until)
            self._read(self._act())

    def _act(self) -> Message:
        given = {it.agent: it.action for it in self._places if it.agent is not None and it.action is not None}
        return self._connection.act(self.behaviour.name, given)

    def _read(self, message: Message) -> None:
        for told in message.ended[self.behaviour.name]:
            self._end(told)
        for told in message.asks[self.behaviour.name]:
            self._ask(told)

    def _end(self, told: Told) -> None:
        place = self._place_of(told.id)
        if place is None:
            if all(it.agent is not None for it in self._places):
                known = ", ".join(str(it.agent) for it in self._places)
                raise UnityError(
                    f"agent {told.id} of the behaviour '{self.behaviour.name}' ended, and none of this number has "
                    f"asked: there are {known}"
                )
            return  # its episode ended before its first decision
        if place.first is None:
            outcome = Outcome(told.observation, told.reward, not told.truncated, told.truncated)
            place.outcome = _with_reward_of(place.outcome, outcome)
        place.agent = place.first = place.action = None

    def _ask(self, told: Told) -> None:
        place = self._place_of(told.id) or next((it for it in self._places if it.agent is None), None)
        if place is None:
            return  # one more agent than there were at first
        if place.agent is None or place.first is not None:
            place.agent, place.first = told.id, told.observation
        else:
            place.outcome = _with_reward_of(place.outcome, Outcome(told.observation, told.reward))

    def _place_of(self, agent: int) -> Place | None:
        return next((it for it in self._places if it.agent == agent), None)

    def _require_before(self, until: float) -> None:
        if monotonic() > until:
            silent = [str(it.agent) for it in self._places if it.outcome is None and it.agent is not None]
            who = f"agent {', '.join(silent)}" if silent else "an agent"
            raise UnityError(
                f"{who} of the behaviour '{self.behaviour.name}' has asked nothing for {self._patience:g} s: in Unity "
                "each agent needs a Decision Requester, and may not be removed"
            )


def _chosen(behaviours: dict[str, Behaviour], name: str) -> Behaviour:
    """The behaviour that was named, with or without what follows Unity's question mark; else the only one."""
    found = [it for it in behaviours.values() if not name or name in (it.name, it.name.partition("?")[0])]
    if len(found) == 1:
        return found[0]
    there = ", ".join(it.partition("?")[0] for it in behaviours) or "none that asked for a decision"
    if name:
        raise UsageError(f"behavior={name}: Unity has no such behaviour. There is: {there}")
    raise UsageError(f"Unity has several behaviours, or none: give behavior=NAME. There is: {there}")


def _with_reward_of(before: Outcome | None, outcome: Outcome) -> Outcome:
    return outcome if before is None else outcome._replace(reward=before.reward + outcome.reward)
