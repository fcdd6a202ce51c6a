"""Wang, Qin, Yang & Yang 2010: the "current" statistical model with fuzzy acceleration limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from ..catalogue.purpose import Named, Purpose
from ..compare.result import Race
from ..filters.current_statistical import FuzzyLimits, LimitWidening, csaf, facs
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..models.motion import ConstantAcceleration, Singer
from ..scenarios import SCENARIOS, Scenario
from .drawing import Chart, Drawing, Line
from .learned import Models, learned
from .paper import (
    ACCELERATION,
    POSITION,
    VELOCITY,
    Experiment,
    Metric,
    Paper,
    named,
    over,
    over_within,
    peak,
    peak_over,
    time_over,
)

SOURCE = (
    "Wang, Qin, Yang & Yang, A Fuzzy Adaptive Algorithm Based on “Current” Statistical Model for Maneuvering Target "
    "Tracking, Defence Technology 2010 no. 3"
)
PRIOR = 30.0  # m/s²: sd of the acceleration at the start
ALPHA, SD = 20.0, 50.0  # 1/α in s and m: of the first two experiments
GRID = [(tau, sd) for tau in (20.0, 60.0) for sd in (10.0, 50.0, 100.0)]
LIMIT = 90.0  # m/s²: CSAF's


def filters(tau: float = ALPHA) -> dict[str, Callable[[Purpose], Named]]:
    """The paper's two, and three that it leaves out."""
    return {
        "csaf": lambda purpose: named(
            f"“current” statistical model, a_max {LIMIT:g} m/s², 1/α {tau:g} s",
            csaf(purpose.sensor, acceleration_max=LIMIT, time_constant=tau, acceleration_prior_sd=PRIOR),
        ),
        "facs": lambda purpose: named(
            f"the same with fuzzy limits, a_th 100 m/s², k 0.97, 1/α {tau:g} s",
            facs(purpose.sensor, limits=FuzzyLimits(), time_constant=tau, acceleration_prior_sd=PRIOR),
        ),
    }


def others() -> dict[str, Callable[[Purpose], Named]]:
    """What a reader would have tried first."""
    return {
        "singer": lambda purpose: named(
            "Singer, acceleration_sd 10 m/s², time_constant 20 s",
            Kalman(Singer(acceleration_sd=10.0, time_constant=20.0), purpose.sensor),
        ),
        "imm-ca": lambda purpose: named(
            "IMM of three constant accelerations, jerk_psd 0.001, 1, 100 m²/s⁵, stay 0.98",
            IMM(
                [ConstantAcceleration(jerk_psd=q, acceleration_prior_sd=PRIOR) for q in (1e-3, 1.0, 100.0)],
                purpose.sensor,
                transition=0.98,
            ),
        ),
    }


def improved(models: Models) -> dict[str, Callable[[Purpose], Named]]:
    """FACS's predecessor, and what its numbers and limits can be made of: each on all three targets alike."""
    triangular = FuzzyLimits(membership="triangular")
    return {
        "triangular": lambda purpose: named(
            "FACS with straight lines instead of the exponential, its predecessor (a reading)",
            facs(purpose.sensor, limits=triangular, time_constant=ALPHA, acceleration_prior_sd=PRIOR),
        ),
        "facs wide": lambda purpose: named(
            "FACS with the paper's numbers, limits widened up to 2 a_th where NIS is high, from 1 to 14",
            facs(
                purpose.sensor,
                widening=LimitWidening(nis=14.0, times=2.0),
                time_constant=ALPHA,
                acceleration_prior_sd=PRIOR,
            ),
        ),
        "csaf fit": of_model(models, "wang-2010-csaf", "CSAF, a_max and α fitted"),
        "singer fit": of_model(models, "wang-2010-singer", "Singer, σ and α fitted"),
        "facs fit": of_model(models, "wang-2010-facs", "FACS, k, a_th and α fitted"),
        "wide fit": of_model(models, "wang-2010-facs-widened", "FACS widened where NIS is high, all fitted but α"),
        "along fit": of_model(models, "wang-2010-facs-along", "limits along and across the track, widened, all fitted"),
        "ratios fit": of_model(
            models, "wang-2010-facs-ratios", "the same, fitted to its largest ratio to CSAF and both Singer filters"
        ),
    }


def of_model(models: Models, name: str, words: str) -> Callable[[Purpose], Named]:
    """The motion model of a fitted filter, on the sensor of the experiment."""

    def make(purpose: Purpose) -> Named:
        model = learned(models, name, words, fitted="other runs of the three targets")(purpose)
        return replace(model, filter=Kalman(model.filter.motions[0], purpose.sensor))

    return make


def seen(name: str, sd: float) -> Scenario:
    """The paper's target seen with this noise."""
    return SCENARIOS[f"wang-2010-{name}"].seen_by(sd)


RATIOS: tuple[Metric, ...] = (
    over("csaf", POSITION, "pos ÷ CSAF"),
    over("csaf", VELOCITY, "vel ÷ CSAF"),
    over("csaf", ACCELERATION, "acc ÷ CSAF"),
)


def experiments(models: Models) -> list[Experiment]:
    """The paper's two, the step that it leaves out, and the first over a grid of what it does not state."""
    both = {**filters(), **others(), **improved(models)}
    first = Experiment(
        name="exp 1",
        words="one axis, 30, 20, 10, 5 m/s² for 50 s each",
        scenario=seen("velocity", SD),
        filters=both,
        metrics=(
            POSITION,
            VELOCITY,
            ACCELERATION,
            *RATIOS,
            time_over("csaf", "time ÷ CSAF", seen("velocity", SD)),
        ),
        published={("facs", "time_over_csaf"): 1.07},
        first=3,
    )
    second = Experiment(
        name="exp 2",
        words="straight, then a circle of 10 km radius",
        scenario=seen("circle", SD),
        filters=both,
        metrics=(POSITION, VELOCITY, ACCELERATION, *RATIOS),
        first=3,
    )
    step = Experiment(
        name="step",
        words="not in the paper: 0, from scan 50 60 m/s², from scan 100 0",
        scenario=seen("step", SD),
        filters=both,
        metrics=(
            POSITION,
            peak("peak_after_onset", "peak after onset m", 50, 100),
            peak("peak_after_end", "peak after end m", 100, 151),
            peak_over("csaf", 50, 151),
        ),
        first=3,
    )
    return [
        first,
        by_acceleration(first, 0),
        by_acceleration(first, 20),
        second,
        step,
        *grid(first, 3),
        *grid(first, 9),
    ]


def by_acceleration(first: Experiment, skipped: int) -> Experiment:
    """FACS over CSAF where the target pulls 30, 20, 10 and 5 m/s², without the first scans of each: the paper claims
    most for weak manoeuvres.
    """
    begin = {30: 1, 20: 51, 10: 101, 5: 151}
    return replace(
        first,
        name="exp 1 by acceleration" + (", settled" if skipped else ""),
        words=f"FACS over CSAF in {'the last ' if skipped else ''}{50 - skipped} scans of each acceleration",
        filters=filters(),
        metrics=tuple(
            over_within("csaf", quantity, f"{quantity[:3]} at {pulled} m/s²", scan + skipped, scan + 50)
            for quantity in ("position", "velocity")
            for pulled, scan in begin.items()
        ),
        published={},
        baselines=(),
    )


def grid(first: Experiment, skipped: int) -> list[Experiment]:
    """FACS over CSAF for all combinations of what is not stated, without the first scans."""
    scans = f"scans {skipped + 1}–200"
    return [
        replace(
            first,
            name=f"1/α {tau:g} s, sd {sd:g} m, {scans}",
            group=f"FACS over CSAF in exp 1 for what the paper does not state, {scans}",
            scenario=seen("velocity", sd),
            filters=filters(tau),
            metrics=RATIOS,
            published={},
            baselines=(),
            first=skipped,
        )
        for tau, sd in GRID
    ]


def curves(race: Race, quantity: str, names: tuple[str, ...]) -> list[Line]:
    """RMSE over scans of some filters, the paper's in strong colours."""
    scans = np.arange(race.skipped_scans, race.skipped_scans + 10**4) + 1
    lines = []
    for name in names:
        if f"{quantity}_square" in race.tallies[name].curves:
            value = race.tallies[name].over_time(quantity)[0]
            lines.append(Line(name, scans[: len(value)], value, faint=name not in ("csaf", "facs")))
    return lines


def draw(races: Mapping[str, Race]) -> list[Drawing]:
    """Figures 2 to 7, with the measurements and the tuned constant-acceleration filter beside the paper's."""
    names = ("csaf", "facs", "kalman-ca", "raw")
    out: list[Drawing] = [membership()]
    units = {"position": "m", "velocity": "m/s", "acceleration": "m/s²"}
    for figure, (quantity, unit) in enumerate(units.items(), start=3):
        shown = names if quantity == "position" else names[:-1]
        out.append(
            Chart(
                title=f"Figure {figure}: {quantity} RMSE, exp 1",
                x="scan",
                y=unit,
                lines=curves(races["exp 1"], quantity, shown),
            )
        )
    truth = seen("circle", SD).simulate(1).truth.position[0] / 1000
    out.append(
        Chart(
            title="Figure 6: the track of exp 2",
            x="x km",
            y="y km",
            lines=[Line("", truth[:, 0], truth[:, 1])],
            square=True,
        )
    )
    out.append(
        Chart(
            title="Figure 7: position RMSE, exp 2",
            x="scan",
            y="m",
            lines=curves(races["exp 2"], "position", names),
        )
    )
    out.append(
        Chart(
            title="Not in the paper: position RMSE at a step of 60 m/s²",
            x="scan",
            y="m",
            lines=curves(races["step"], "position", names),
            shaded=[(50, 100)],
        )
    )
    return out


def membership() -> Chart:
    """Figure 2: the limit a_max(a) and the acceleration it must stay above."""
    limits = FuzzyLimits()
    a = np.linspace(-110, 110, 221)
    largest = np.array([limits(float(v)) for v in a])
    return Chart(
        title="Figure 2: the fuzzy limit a_max = a_th M(a), reconstructed",
        x="acceleration m/s²",
        y="m/s²",
        lines=[Line("a_max(a)", a, largest), Line("|a|", a, np.abs(a), faint=True)],
    )


WANG_2010 = Paper(
    name="wang-2010",
    source=SOURCE,
    runs=1000,
    quick_runs=100,
    experiments=experiments,
    draw=draw,
    readings=(
        "The paper does not state measurement noise and α. Here they are sd 50 m and 1/α = 20 s. The two last tables "
        "show six combinations of sd 10, 50, 100 m with 1/α = 20, 60 s.",
        "The paper's text at hand has lost its equations. The membership is reconstructed from its words: M(a) = "
        "min(1, exp(−k (1 − |a|/a_th))), a_max = a_th M(a), mirrored below zero, k ≤ 1.0536 for a_th = 100, "
        "a_up = 90 m/s².",
        "The fitted filters are the likeliest on 100 other runs of each of the three targets, every other one "
        "mirrored. α of “wide fit” stays at 1/20 s. “ratios fit” has the least ratio, where it is largest, to the best "
        "of CSAF and both Singer filters on such runs. The ratios are those of position, velocity and acceleration in "
        "both experiments, and that of the peak at the step to 1.4 times CSAF's.",
        "The figure of the triangular membership is lost: here it is straight lines between the exponential's ends.",
        "The paper does not state the start. Here tracks start from two points, with acceleration 0 of sd 30 m/s². "
        "RMSE pools runs and scans from the fourth on. The start's error is the same in both filters and rules the "
        "acceleration's RMSE in the first scans. So the ratios are shown from the tenth scan on as well.",
        "a is the acceleration predicted for the scan, which is the last estimate. A margin a_max − |a| below 1% of "
        "a_max counts as 1%, or the filter would freeze.",
        "The paper shows its RMSE in drawings only. Its one published number is the run time, 1.07 times that of "
        "CSAF. Ours depends on the machine and its load.",
    ),
    remarks=(
        "FACS is better than CSAF in both of the paper's experiments. It is worse at a strong onset, which the paper "
        "does not test: see the step.",
        "From the fourth scan on the ratio of acceleration exceeds 0.65 where 1/α is 60 s and the noise 50 or "
        "100 m. There the start, the same in both filters, weighs most. From the tenth scan on the ratio never "
        "exceeds 0.65.",
        "The paper says that the gain is largest for weak manoeuvres. Once settled it is the other way round: the "
        "stronger the acceleration, the more FACS gains over CSAF in velocity.",
        "Limits along and across the track that widen where NIS is high, all numbers fitted (“along fit”), "
        "beat CSAF and both Singer filters in position and velocity in both experiments. The peak at the step is 1.4 "
        "times that of CSAF. They have one set of numbers for all three targets.",
        "In acceleration “along fit” is worse than Singer with σ 10 m/s² in exp 2. Fitted to the ratios themselves "
        "(“ratios fit”), the same limits beat CSAF and both Singer filters in position, velocity and acceleration in "
        "both experiments. The peak at the step stays below 1.5 times that of CSAF.",
        "Fitting k, a_th and α alone does not help: “facs fit” becomes “csaf fit”, whose large limits do not "
        "move. What helps is the widening. With the paper's own numbers it lowers the peak below CSAF's and costs "
        "most of FACS's gain in velocity.",
        "The triangular membership, as read here, is worse than the exponential in both experiments and better at the "
        "end of the step.",
        "A tuned constant-acceleration Kalman filter and an IMM of three beat all of them in position.",
    ),
)
