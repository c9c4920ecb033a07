"""What a cheat would do: behaviour that a reward pays most, found before anything is trained."""
