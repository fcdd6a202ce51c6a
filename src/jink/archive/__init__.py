"""Archives that are larger than memory: files to a folder of tracks, in processes or on a cluster, and resumable."""
