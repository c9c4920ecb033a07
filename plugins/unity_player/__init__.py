"""A program built with Unity's ML-Agents as Gymnasium envs: its process, its messages, its agents."""
