"""The executor ``slurm``: how it submits jobs, what a job does, and how its progress comes back."""
