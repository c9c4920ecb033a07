"""What recorded trainings in any Gymnasium environment say. Imports no gymnasium, and runs no code of theirs."""
