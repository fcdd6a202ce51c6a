"""Textbook filters in plain NumPy: slow, obvious and written from the literature, not from the engine they
judge.

One track at a time, one scan at a time, dense matrices, Joseph-form updates, nothing clever. Where a closed
form cancels (Singer's Q), it is evaluated in 80 decimal digits instead of being rearranged.
"""
