"""`python -m jink` is the command line, as `jink` is."""

from .cli.main import main

main()
