"""The world of one episode: a simulator, a task and a reward as a Gymnasium environment."""

from harness.env.vector_env import ReachVectorEnv

__all__ = ["ReachVectorEnv"]
