"""What the cells of an experiment say whose task is an environment: their recorded trainings, compared."""
