"""Reports of experiments whose task is an environment. They compare the recorded trainings of the cells."""
