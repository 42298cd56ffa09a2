"""Before the first flight: firmware in the loop, and steps from present to tuned gains."""
