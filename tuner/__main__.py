"""`python -m tuner`: the command line without the console script."""

from tuner.cli.main import main

main()
