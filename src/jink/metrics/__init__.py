"""What good means: figures of merit as functions of arrays, each with its standard error, formula and source.

Errors are (runs, scans, n), estimate minus truth, NaN where there is none.
"""

from .air_picture import Siap, siap
from .bounds import bound_rmse, information, posterior_bound, tichavsky_bound, turn_displacement
from .clear_mot import ClearMot, clear_mot
from .comparison import Comparison, compare_means, compare_rmse, efficiency, paired
from .consistency import Consistency, consistency, log_density, log_score, nees, prediction_score
from .errors import (
    lost,
    mean_euclidean,
    measured_velocity,
    normalised_error,
    quantile,
    rmse,
    rmse_over_time,
    trimmed_rmse,
)
from .figure import Figure
from .manoeuvres import Detection, Response, detection, events, manoeuvring, response
from .sets import Gospa, gospa, ospa, ospa2
from .skies import SkyFigures, sky_figures
from .timing import microseconds_per_update

__all__ = [
    "ClearMot",
    "Comparison",
    "Consistency",
    "Detection",
    "Figure",
    "Gospa",
    "Response",
    "Siap",
    "SkyFigures",
    "bound_rmse",
    "clear_mot",
    "compare_means",
    "compare_rmse",
    "consistency",
    "detection",
    "efficiency",
    "events",
    "gospa",
    "information",
    "log_density",
    "log_score",
    "lost",
    "manoeuvring",
    "mean_euclidean",
    "measured_velocity",
    "microseconds_per_update",
    "nees",
    "normalised_error",
    "ospa",
    "ospa2",
    "paired",
    "posterior_bound",
    "prediction_score",
    "quantile",
    "response",
    "rmse",
    "rmse_over_time",
    "siap",
    "sky_figures",
    "tichavsky_bound",
    "trimmed_rmse",
    "turn_displacement",
]
