"""Trials that another program makes: which are asked for, what it tells of them, and the run that concludes from them."""
