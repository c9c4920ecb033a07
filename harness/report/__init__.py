"""What people see of an experiment: a table in the terminal and a page in the browser."""
