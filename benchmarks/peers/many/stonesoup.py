"""Stone Soup: global nearest neighbour and joint probabilistic association (belief propagation), over KD-trees."""

from __future__ import annotations

import datetime
from collections.abc import Callable
from typing import Any

import numpy as np
from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
from stonesoup.dataassociator.probability import JPDAwithLBP
from stonesoup.dataassociator.tree import DetectionKDTreeMixIn
from stonesoup.deleter.time import UpdateTimeStepsDeleter
from stonesoup.functions import gm_reduce_single
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.hypothesiser.probability import PDAHypothesiser
from stonesoup.initiator.simple import MultiMeasurementInitiator
from stonesoup.measures import Mahalanobis
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.types.array import StateVectors
from stonesoup.types.detection import Detection
from stonesoup.types.state import GaussianState
from stonesoup.types.track import Track
from stonesoup.types.update import GaussianStateUpdate
from stonesoup.updater.kalman import KalmanUpdater

from jink.metrics.skies import Picture

from . import Live, Task, picture

NAME = "Stone Soup"
DISTRIBUTION = "stonesoup"
START = datetime.datetime(2024, 1, 1)
GATE = 4.0  # sigmas
MISSES = 3


class NearestByTree(DetectionKDTreeMixIn, GNNWith2DAssignment):
    """Looks only at the plots near a track, as its documentation composes it."""


class JointByTree(DetectionKDTreeMixIn, JPDAwithLBP):
    """Looks only at the plots near a track, as its documentation composes it."""


def entrants(task: Task) -> dict[str, Callable[[], Live]]:
    """MultiMeasurementInitiator of three points, deletion after three scans without an update.

    Targets that are known before the first scan are tracks from the start, as in its tutorials 5 to 8, and no others.
    """
    return {f"{NAME}, GNN": lambda: _live(task, joint=False), f"{NAME}, JPDA": lambda: _live(task, joint=True)}


def _live(task: Task, joint: bool) -> Live:
    motion = CombinedLinearGaussianTransitionModel([ConstantVelocity(task.acceleration_psd)] * 2)
    sensor = LinearGaussian(4, (0, 2), task.R)
    predictor, updater = KalmanPredictor(motion), KalmanUpdater(sensor)
    # a track that begins at a plot has the start's covariance, and moves no farther than it says in a scan
    farthest = GATE * float(np.sqrt(task.start[1, 1] * task.sky.interval**2 + 2 * task.R[0, 0]))
    common = {"predictor": predictor, "updater": updater, "max_distance": farthest}
    near = DistanceHypothesiser(predictor, updater, Mahalanobis(), missed_distance=GATE)
    nearest = NearestByTree(hypothesiser=near, **common)
    associator: Any = nearest
    if joint:
        soft = PDAHypothesiser(
            predictor,
            updater,
            clutter_spatial_density=task.clutter_density,
            prob_detect=task.sky.detection,
            prob_gate=1.0 - float(np.exp(-(GATE**2) / 2)),
        )
        associator = JointByTree(hypothesiser=soft, **common)
    deleter = UpdateTimeStepsDeleter(MISSES)
    prior = GaussianState(np.zeros((4, 1)), task.start)
    initiator = MultiMeasurementInitiator(prior, deleter, nearest, updater, sensor, min_points=3)
    tracks = {
        Track([GaussianState(x[:, None], np.diag(v), START)])
        for x, v in zip(*(task.sky.known or ((), ())), strict=True)
    }
    number: dict[str, int] = {}

    def scan(time: float, plots: np.ndarray) -> Picture:
        nonlocal tracks
        now = START + datetime.timedelta(seconds=time)
        seen = {Detection(z[:, None], timestamp=now, measurement_model=sensor) for z in plots}
        taken = set()
        for track, found in associator.associate(tracks, seen, now).items():
            taken |= _soft(track, found, updater) if joint else _hard(track, found, updater)
        if not task.sky.known:
            tracks = tracks - deleter.delete_tracks(tracks)
            tracks |= initiator.initiate(seen - taken, now)
        held = list(tracks)
        ids = [number.setdefault(t.id, len(number)) for t in held]
        return picture(ids, [np.asarray(t.state_vector, float).ravel()[[0, 2]] for t in held])

    return scan


def _hard(track: Any, found: Any, updater: Any) -> set[Any]:
    """A single hypothesis, as in its tutorial 6; returns the plots that are no longer free."""
    if not found:
        track.append(found.prediction)
        return set()
    track.append(updater.update(found))
    return {found.measurement}


def _soft(track: Any, found: Any, updater: Any) -> set[Any]:
    """The mixture over hypotheses, as in its tutorial 8; plots within the gate are no longer free."""
    states = [each.prediction if not each else updater.update(each) for each in found]
    weights = np.asarray([each.probability for each in found], float)
    means = StateVectors([state.state_vector for state in states])
    covariances = np.stack([state.covar for state in states], axis=2)
    mean, covariance = gm_reduce_single(means, covariances, weights)
    there = {each.measurement for each in found if each}
    if there:
        track.append(GaussianStateUpdate(mean, covariance, found, states[0].timestamp))
    else:
        track.append(states[0])
    return there
