"""What of an experiment is small enough to be kept beside the code: records and figures."""
