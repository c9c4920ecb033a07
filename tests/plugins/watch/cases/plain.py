"""Three learners in one loop each, as people write them themselves: tables, policy gradients, and evolution."""

from collections import defaultdict

import numpy as np
from numpy.random import default_rng

RATE, DISCOUNT, LEAST_CHANCE = 0.2, 0.99, 0.05


def q_table(env, steps, seed):
    """Q-learning; the chance of a random action falls over the first half of the steps."""
    rng, choices = default_rng(seed), env.action_space.n
    values = defaultdict(lambda: np.zeros(choices))
    seen, _ = env.reset(seed=seed)
    for step in range(steps):
        here = values[_key(seen)]
        by_chance = rng.random() < max(LEAST_CHANCE, 1.0 - 2.0 * step / steps)
        action = int(rng.integers(choices) if by_chance else rng.choice(np.flatnonzero(here == here.max())))
        seen, paid, terminated, truncated, _ = env.step(action)
        ahead = 0.0 if terminated else DISCOUNT * values[_key(seen)].max()
        here[action] += RATE * (paid + ahead - here[action])
        if terminated or truncated:
            seen, _ = env.reset()


def _key(seen):
    return tuple(np.asarray(seen).ravel().tolist())


def reinforce(env, steps, seed):
    """Policy gradients: a linear policy with squared features, normalised returns of ten episodes, Adam by hand."""
    rng, choices = default_rng(seed), env.action_space.n
    size = len(_features(env.reset(seed=seed)[0]))
    weights, mean, square, updates, done = np.zeros((size, choices)), 0.0, 0.0, 0, 0
    while done < steps:
        gradients, returns = [], []
        while len(returns) < 10 and done < steps:
            features, actions, pay, is_over = [], [], [], False
            seen, _ = env.reset()
            while not is_over and done < steps:
                row = _features(seen)
                chances = _chances(row @ weights)
                action = int(rng.choice(choices, p=chances))
                seen, paid, terminated, truncated, _ = env.step(action)
                features.append(row)
                actions.append(np.eye(choices)[action] - chances)
                pay.append(paid)
                is_over, done = terminated or truncated, done + 1
            gradients.append((np.array(features), np.array(actions)))
            returns.append(_returns(pay))
        together = np.concatenate(returns)
        scaled = [(it - together.mean()) / (together.std() + 1e-8) for it in returns]
        gradient = sum(rows.T @ (acts * it[:, None]) for (rows, acts), it in zip(gradients, scaled, strict=True)) / len(
            together
        )
        updates, mean, square = updates + 1, 0.9 * mean + 0.1 * gradient, 0.999 * square + 0.001 * gradient**2
        weights += 0.05 * (mean / (1 - 0.9**updates)) / (np.sqrt(square / (1 - 0.999**updates)) + 1e-8)


def _features(seen):
    row = np.asarray(seen, float).ravel()
    return np.concatenate([[1.0], row, row**2])


def _chances(logits):
    powers = np.exp(logits - logits.max())
    return powers / powers.sum()


def _returns(pay):
    found, later = np.zeros(len(pay)), 0.0
    for step in reversed(range(len(pay))):
        found[step] = later = pay[step] + DISCOUNT * later
    return found


def cross_entropy(env, steps, seed):
    """The cross-entropy method: of 20 linear policies, drawn anew in each turn, the best 5 tell where to draw next."""
    rng, low, high = default_rng(seed), env.action_space.low, env.action_space.high
    size = len(_flat(env.reset(seed=seed)[0])) + 1
    centre, spread, done = np.zeros((size, len(low))), np.ones((size, len(low))), 0
    while done < steps:
        policies = [centre + spread * rng.normal(size=centre.shape) for _ in range(20)]
        paid = []
        for policy in policies:
            seen, total, is_over = env.reset()[0], 0.0, False
            while not is_over:
                wanted = np.tanh(np.append(_flat(seen), 1.0) @ policy)
                action = (low + (wanted + 1.0) * (high - low) / 2.0).astype(low.dtype)
                seen, pay, terminated, truncated, _ = env.step(action)
                total, is_over, done = total + pay, terminated or truncated, done + 1
            paid.append(total)
            if done >= steps:
                return
        best = np.array([policies[it] for it in np.argsort(paid)[-5:]])
        centre, spread = best.mean(axis=0), best.std(axis=0) + 0.05


def _flat(seen):
    return np.concatenate([np.ravel(it) for it in (seen.values() if isinstance(seen, dict) else [seen])])


LEARNERS = {"q-table": q_table, "reinforce": reinforce, "cross-entropy": cross_entropy}
