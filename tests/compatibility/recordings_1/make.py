"""Made with format 1 of recordings: two rewards, two seeds, an evaluation of each."""

import gymnasium

import harness

rewards = {"own": "own", "slow": lambda before, action, after, info: 1.0 - abs(float(after[1]))}
behaviour = {
    "upright": lambda before, action, after, info: abs(float(after[2])) < 0.1,
    "angle": lambda before, action, after, info: abs(float(after[2])),
}
for reward in rewards:
    for seed in range(2):
        names = {
            "trained_with": reward,
            "seed": seed,
            "rewards": rewards,
            "behaviour": behaviour,
            "lower_is_better": ["angle"],
        }
        env = harness.RecordRewards(gymnasium.make("CartPole-v1"), f"recordings/{reward}-{seed}", pay=True, **names)
        env.reset(seed=seed)
        env.action_space.seed(seed)
        for _ in range(60):
            if any(env.step(env.action_space.sample())[2:4]):
                env.reset()
        env.close()
        harness.evaluate_policy(
            lambda seen: int(seen[2] > 0), "CartPole-v1", f"recordings/{reward}-{seed}/evaluation", episodes=3, **names
        )
