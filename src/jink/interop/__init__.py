"""To and from other packages: one file for each, imported when it is asked for, so that none is needed.

stone_soup: tracks, detections and ground truth, and a jink filter as a predictor and updater; filter_py: a FilterPy
filter read as a jink filter; geopandas: points and trajectories of geopandas and movingpandas; traffic: flights;
matlab: .mat files; czml: globes.
"""
