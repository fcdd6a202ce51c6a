"""`python -m jink`."""

from .cli.main import main

main()
