"""Writes policies as ONNX models, and trainings as CSV files.

A model takes observations and returns actions. It does what `harness.policy.Policy.act` does without a random
generator, NOTE eq. 36, and includes the scaling of observations and actions.
"""
