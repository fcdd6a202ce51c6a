"""One file per format of text that jink reads."""
