"""What a hand does in each environment: good behaviour, and the cheats. Each begins an episode anew."""

import math

import numpy as np


def _always(action):
    return lambda: lambda seen: action


def _first(begin, loop=(0,)):
    """Choices in this order, then a loop of others."""

    def make():
        taken = iter((*begin, *loop * 500))
        return lambda seen: next(taken)

    return make


def _swing_up(seen):
    """Energy in, then proportional and derivative feedback."""
    cosine, sine, speed = (float(it) for it in seen)
    angle, energy = math.atan2(sine, cosine), speed**2 / 6.0 + 5.0 * (cosine - 1.0)
    feedback = -10.0 * angle - 2.5 * speed
    caught = abs(angle) < 0.6 and abs(feedback) < 4.0
    pushed = feedback if caught else math.copysign(2.0, speed if energy < 0.0 else -speed)
    return np.clip([pushed], -2.0, 2.0).astype(np.float32)


def _spin(seen):
    return np.array([math.copysign(2.0, float(seen[2]))], np.float32)


def _stand_then_spin():
    steps = 0

    def act(seen):
        nonlocal steps
        steps += 1
        return _swing_up(seen) if steps <= 150 else _spin(seen)

    return act


def _balance(seen):
    place, speed, angle, turning = (float(it) for it in seen)
    return int(0.1 * place + 0.3 * speed + 3.0 * angle + 0.8 * turning > 0.0)


def _rock(seen):
    """As high as it gets without coming to the flag."""
    energy = 0.5 * float(seen[1]) ** 2 + 0.0025 / 3.0 * math.sin(3.0 * float(seen[0]))
    return 2 * ((seen[1] >= 0.0) == (energy < 0.0007))


def _reach(seen):
    """The fingertip is pulled to the target; joints are damped."""
    (c1, c2, s1, s2), turning, error = (float(it) for it in seen[:4]), seen[6:8], seen[8:10]
    c12, s12 = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
    jacobian = np.array([[-0.1 * s1 - 0.11 * s12, -0.11 * s12], [0.1 * c1 + 0.11 * c12, 0.11 * c12]])
    return np.clip(-50.0 * jacobian.T @ error - 0.05 * turning, -1.0, 1.0).astype(np.float32)


def _stand(seen):
    """Linear feedback, from the Riccati equation of the poles that stand."""
    state = np.concatenate([seen[:1], np.arcsin(seen[1:3]), seen[5:8]])
    return np.clip([-state @ np.array([0.21, 1.81, 5.57, 0.31, 0.9, 0.85])], -1.0, 1.0).astype(np.float32)


def _steer(seen, radius):
    """To a distance from the dock, as fast as it can still brake."""
    place, speed = np.asarray(seen["position"], float), np.asarray(seen["velocity"], float)
    distance = float(np.hypot(*place)) + 1e-9
    left = distance - radius
    wanted = -place / distance * math.copysign(0.8 * math.sqrt(0.04 * abs(left)), left)
    return np.clip((wanted - speed) / 0.02, -1.0, 1.0).astype(np.float32)


def _in_and_out():
    goes_in = True

    def act(seen):
        nonlocal goes_in
        goes_in = float(np.hypot(*seen["position"])) > (0.29 if goes_in else 0.31)
        return _steer(seen, 0.2 if goes_in else 0.4)

    return act


def _away(seen):
    place = np.asarray(seen["position"])
    return (place / np.abs(place).max()).astype(np.float32)


def _taxi(cheats):
    """By the shortest way to the passenger, and then to where they want to be; or down at once and up again."""

    def act(seen):
        state = int(seen)
        place, passenger, goal = (state // 100, state // 20 % 5), state // 4 % 5, state % 4
        rides = passenger == 4
        if cheats and rides:
            return 5
        stand = _STANDS[goal if rides else passenger]
        return 4 + rides if place == stand else _TAXI_WAYS[stand][place]

    return lambda: act


def _taxi_ways(goal):
    """Breadth first from the goal, around Taxi's walls."""
    walls = {(0, 1), (1, 1), (3, 0), (4, 0), (3, 2), (4, 2)}
    """Places whose east side is closed."""
    found, places = {goal: 0}, [goal]
    for row, column in places:
        for action, (down, right) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
            other = (row - down, column - right)  # from there this action leads here
            closed = (right == 1 and other in walls) or (right == -1 and (row, column) in walls)
            if other not in found and 0 <= other[0] < 5 and 0 <= other[1] < 5 and not closed:
                found[other] = action
                places.append(other)
    return found


_STANDS = [(0, 0), (0, 4), (4, 0), (4, 3)]
_TAXI_WAYS = {goal: _taxi_ways(goal) for goal in _STANDS}


def _sign(place):
    """The torque along one number of the observation."""
    return lambda: lambda seen: 2 * (seen[place] > 0.0)


_LIMP = _always(np.zeros(1, np.float32))
POLICIES = {
    "swing up": lambda: _swing_up,
    "spin": lambda: _spin,
    "stand, then spin": _stand_then_spin,
    "hang": _LIMP,
    "balance": lambda: _balance,
    "fall": _always(0),
    "drive": lambda: lambda seen: 2 * (seen[1] >= 0.0),
    "rock": lambda: _rock,
    "stay": _always(1),
    "full power": lambda: lambda seen: np.array([1.0 if seen[1] >= 0.0 else -1.0], np.float32),
    "no power": _LIMP,
    "reach": lambda: _reach,
    "turn": _always(np.array([1.0, 0.0], np.float32)),
    "limp": _always(np.zeros(2, np.float32)),
    "stand": lambda: _stand,
    "give up": _LIMP,
    "along the cliff": _first([0, *[1] * 11, 2]),
    "to and fro": _first([0, *[1] * 11], (3, 1)),
    "wait": _first([0], (0,)),
    "over the lake": _first([1, 1, 2, 1, 2, 2]),
    "two fields": _first([], (2, 0)),
    "taxi": _taxi(False),
    "up and down": _taxi(True),
    "swing over": _sign(5),
    "swing below": _sign(4),
    "no torque": _always(1),
    "dock": lambda: lambda seen: _steer(seen, 0.07),
    "hover": lambda: lambda seen: _steer(seen, 0.2),
    "in and out": _in_and_out,
    "away": lambda: _away,
    "drift": _always(np.zeros(2, np.float32)),
    "to the goal": _first([0, 0, 0, 0, 2, 2, 2, 2]),
    "by the coin": _first([2, 2, 0, 0, 0, 0, 2, 2]),
    "coin loop": _first([2, 2], (0, 0, 1, 1)),
    "key, coin loop": _first([0, 0, 1, 1, 2, 2], (0, 0, 1, 1)),
}
