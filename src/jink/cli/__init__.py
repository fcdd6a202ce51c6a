"""The command line: `main` puts the commands together, each of which is one file."""
