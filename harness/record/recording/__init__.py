"""One training in any Gymnasium environment, every step of it scored by several rewards: the folder and its reader.

`harness.RecordRewards` leaves the folder. Whatever steps envs of the training is a recorder, with a number; mostly
there is one, number 0. Each has its own files, so that several processes can record one training:

=======================  ======================================================================================
recording-0.json         what is known of the training beside its steps: `facts.TrainingFacts`
steps-0-00000.parquet    one row per environment step, in the order of time; all parts but the last are full
recording-0.lock         held while the recorder is open
=======================  ======================================================================================

The columns of a part:

=====================  ========================================================================================
time                   how often this recorder's env had been stepped before; rows of one batch share it
env                    number of the env in this recorder's batch
episode                counted from 0 in each env
step                   counted from 0 in each episode
reward_<name>          what the reward of this name pays for the step; NaN where it was given up, see `Failure`
behaviour_<name>       a measure of what the robot did in the step; NaN where the env did not tell it in this step
terminated, truncated  whether the step ended the episode, as the env says
=====================  ========================================================================================
"""
