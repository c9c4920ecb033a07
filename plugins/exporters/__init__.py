"""Policies as models that other programs run: what goes in are observations, what comes out are actions.

A model is what `harness.policy.Policy.act` does without a generator, NOTE eq. 36, scaling of observations and actions
included.
"""
