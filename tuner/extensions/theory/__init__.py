"""Theory: theorems on gains, as a command and as requirements of a study."""
