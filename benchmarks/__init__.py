"""Speed and memory of jink against its peers and its own targets: `python -m benchmarks.run`."""
