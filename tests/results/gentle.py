"""A run with a reward that has terms, one of which never pays."""

import harness

GENTLE = "gentle.py"
SOURCE = '''
def gentle(step):
    """Reach the target, and move little."""
    return {
        "reach": -step.distance,
        "effort": -0.01 * (step.action**2).sum(-1),
        "dock": 0.0 * step.distance,
    }
'''


def run_gentle(folder, *, reward, steps=300, seeds=3, **given):
    """Train at random in the kinematic simulator, the file of the reward beside the experiment's folder."""
    (folder / GENTLE).write_text(SOURCE)
    harness.run(
        **{"sim": "kinematic", "algo": "random", "evaluation_episodes": 3, "jobs": 1, **given},
        reward=list(reward),
        seeds=seeds,
        steps=steps,
        out=folder / "run",
        plugins=[folder / GENTLE],
    )
    return folder / "run"
