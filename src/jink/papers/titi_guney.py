"""Titi & Güney: a Kalman filter whose output an adaptive neuro-fuzzy system corrects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..catalogue.purpose import Named, Purpose
from ..checks import Array
from ..compare.result import Race
from ..filters.aided import Aided
from ..frozen import frozen
from ..metrics.draws import Draws
from ..models.sensor import Position
from ..scenarios import SCENARIOS, Observation, Scenario, Schedule
from ..scenarios.truth import Kinematics, Truth
from .aids_elsewhere import OVER_KF, SD, by_radar, in_clutter, on_the_imm
from .drawing import Chart, Drawing, Line
from .learned import Models, alone, learned
from .paper import NEES, POSITION, Experiment, Maker, Paper, over

SOURCE = "Titi & Güney, Adaptive Neuro-Fuzzy Aided Kalman Filter for Target Tracking"
AXES = {"x": 1, "y": 0, "z": 2}  # north, east, up, by their places in the truth
RATES = {
    "20 Hz": Schedule(start=0.0, interval=0.05, count=3300),
    "1 Hz": Schedule(start=0.0, interval=1.0, count=166),
}


@frozen
class Along:
    """One axis of a truth."""

    truth: Truth
    axis: int

    @property
    def runs(self) -> int:
        """As the truth's."""
        return self.truth.runs

    def at(self, time: Array) -> Kinematics:
        """Kinematics (B, n, 1)."""
        return Kinematics(*(a[..., self.axis : self.axis + 1] for a in self.truth.at(time)))

    def breaks(self) -> Array:
        """As the truth's."""
        return self.truth.breaks()


def target(number: int, rate: str, axis: str = "x") -> Scenario:
    """One coordinate of a benchmark aircraft, x north, y east, z up; the paper shows x alone."""
    base = SCENARIOS[f"benchmark-{number}"]

    def truth(draws: Draws) -> Truth:
        return Along(base.truth(draws), AXES[axis])

    return replace(
        base,
        name=f"{base.name}-{axis}-{rate.replace(' ', '').lower()}",
        summary=f"{axis} of target {number}, {rate}, sd {SD:g} m",
        truth=truth,
        axes=1,
        observation=Observation(sensor=Position(sd=SD, axes=1)),
        schedule=RATES[rate],
    )


def aided(models: Models, speed: str) -> dict[str, Maker]:
    """A Kalman filter by itself, and with the paper's two aids and a straight line in their place."""
    name, own = f"titi-guney-{speed}", "other runs"
    words = "constant-acceleration Kalman filter" + (", noise × 1e-4" if speed.startswith("sluggish") else ", tuned")
    inputs = "from z − x(t|t) and x(t|t−1) − x(t|t)"
    return {
        "kf": alone(models, f"{name}-anfis", words, fitted=own),
        "kf + line": learned(models, f"{name}-linear", f"{words}; a correction linear in {inputs[5:]}", fitted=own),
        "as published": learned(
            models, f"{name}-literal", f"{words}; ANFIS {inputs}, ten epochs of backpropagation", fitted=own
        ),
        "anfsakf": learned(models, f"{name}-anfis", f"{words}; ANFIS {inputs}, hybrid training", fitted=own),
        "anfsakf, kf’s P": with_own_covariance(
            learned(models, f"{name}-anfis", f"{words}; the same ANFIS, P as the filter has it", fitted=own)
        ),
        "nnakf": learned(models, f"{name}-network", f"{words}; network {inputs}", fitted=own),
    }


def with_own_covariance(maker: Maker) -> Maker:
    """The same aid, which leaves P alone."""

    def make(purpose: Purpose) -> Named:
        made = maker(purpose)
        filter = Aided(made.filter.filter_, replace(made.filter.corrector, sd_factors=()))
        return Named(filter=filter, words=made.words, fitted=made.fitted)

    return make


def fed_by_history(models: Models) -> dict[str, Maker]:
    """The filter tuned on targets 1, 3 and 5, and aids that see its last innovations, trained on those as well."""
    return {
        "kf": alone(models, "nn-kf", "Kalman filter tuned on targets 1, 3, 5"),
        "anfsakf": learned(models, "anfis-kf", "the same; ANFIS on sums of the last 8 innovations"),
        "nnakf": learned(models, "nn-kf", "the same; network on the last 8 innovations"),
    }


OVER_LINE = over("kf + line", POSITION, "÷ line")


def experiments(models: Models) -> list[Experiment]:
    """Target 1 with a sluggish and a tuned filter, once a second and as often as the paper's matrix suggests; targets
    nobody trained on.
    """
    once = [
        Experiment(
            name=f"{speed}, {rate}",
            words=f"x of target 1 (cargo aircraft), sd {SD:g} m, {said}",
            scenario=target(1, rate),
            filters=aided(models, speed if rate == "1 Hz" else f"{speed}-20hz"),
            metrics=(POSITION, OVER_KF, OVER_LINE, NEES),
            share=1.0 if rate == "1 Hz" else 0.05,
        )
        for rate in ("1 Hz", "20 Hz")
        for speed, said in (
            ("sluggish", "a Kalman filter with 1e-4 of the tuned noise"),
            ("tuned", "the tuned one"),
        )
    ]
    fleet = [
        Experiment(
            name=f"target {number}",
            group="Filter and aids from targets 1, 3 and 5, aids fed by the last innovations; x of targets 2, 4, "
            "6, 1 Hz",
            scenario=target(number, "1 Hz"),
            filters=fed_by_history(models),
            metrics=(POSITION, OVER_KF, NEES),
        )
        for number in (2, 4, 6)
    ]
    other = [
        Experiment(
            name=f"{speed}, {rate}, {axis}",
            group="The same aids, trained on x, along the other axes of target 1",
            scenario=target(1, rate, axis),
            filters={
                name: maker
                for name, maker in aided(models, speed if rate == "1 Hz" else f"{speed}-20hz").items()
                if name in ("kf", "as published", "anfsakf")
            },
            metrics=(POSITION, OVER_KF),
            baselines=("raw",),
            share=0.25 if rate == "1 Hz" else 0.05,
        )
        for rate in ("1 Hz", "20 Hz")
        for speed in ("sluggish", "tuned")
        for axis in ("y", "z")
    ]
    return [*once, *other, *by_radar(models, RATES), *fleet, *on_the_imm(models, target), *in_clutter(models, target)]


def draw(races: Mapping[str, Race]) -> list[Drawing]:
    """Figures 2 to 5 on one run: with the filter made sluggish, and with the tuned one."""
    path = SCENARIOS["benchmark-1"].simulate(1).truth.position[0] / 1000
    out: list[Drawing] = [
        Chart(
            title="Figure 2: trajectory of target 1",
            x="east km",
            y="north km",
            lines=[Line("", path[:, 0], path[:, 1])],
            square=True,
        )
    ]
    for speed, words in (("sluggish", "sluggish filter, 1e-4 of the tuned noise"), ("tuned", "tuned filter")):
        if f"{speed}, 1 Hz" in races:
            out += _aided_run(races[f"{speed}, 1 Hz"], words)
    return out


def _aided_run(race: Race, words: str) -> list[Drawing]:
    """Figures 3 to 5 of one run; each of figure 5's filters has a panel of its own, as in the paper."""
    run = target(1, "1 Hz").simulate([0], seed=race.seed)
    time, truth = run.time[0], run.truth.position[0, :, 0]
    errors = {}
    for name in ("kf", "nnakf", "anfsakf"):
        estimate = race.entrants[name].filter.filter(**run.batch(), outputs=("x",))
        errors[name] = estimate.x[:, 0] - truth
    correction = errors["anfsakf"] - errors["kf"]
    true = Line("true", time, truth / 1000, faint=True)
    estimates = [Line(name, time, (errors[name] + truth) / 1000) for name in ("kf", "anfsakf")]
    panels = [
        Chart(
            title=f"Figure 5{letter}: error in x of {name}, {words}",
            x="s",
            y="m",
            lines=[Line(name, time, errors[name]), Line("kf", time, errors["kf"], faint=True)],
        )
        for letter, name in zip("bc", ("nnakf", "anfsakf"), strict=True)
    ]
    return [
        Chart(
            title=f"Figure 3: error of the Kalman filter, and what ANFIS answers, {words}",
            x="s",
            y="m",
            lines=[Line("true − kf", time, -errors["kf"]), Line("ANFIS", time, correction)],
        ),
        Chart(title=f"Figure 4: x of target 1, {words}", x="s", y="km", lines=[true, *estimates]),
        *panels,
    ]


TITI_GUNEY = Paper(
    name="titi-guney",
    source=SOURCE,
    runs=2000,
    quick_runs=200,
    experiments=experiments,
    draw=draw,
    readings=(
        "The aircraft are those of Blair et al. 1998, rebuilt from its table. As in the paper, only x of target 1 "
        "(cargo aircraft) is used; x is taken to be north.",
        "A training matrix of 3300 rows fits 165 s at 20 Hz, or 20 runs at 1 Hz. Both rates are shown, with aids "
        "trained on 4 and on 20 runs.",
        "The paper does not state its noises. Here the position sd is 50 m, and the Kalman filter's noise is tuned "
        "on other runs. “sluggish” has 1e-4 of that noise.",
        "“as published” is ANFIS after ten epochs of backpropagation, which leave it under-trained. “anfsakf” has "
        "300 epochs of the hybrid method. The runs that are scored are not those that the aids saw.",
        "The paper prints figures and no table, so there are no published numbers to compare with.",
        "The paper says nothing of P. Here an aid scales it by factors from its validation runs; “anfsakf, kf’s P” is "
        "the same aid without them.",
        "The aids on a radar's filter are those that were trained on positions along x.",
        "A tracker of plots without identity takes no aid, since an aid looks at one innovation and a tracker weighs "
        "several plots. So “clutter” means missed and false plots of one known target.",
        "The paper interchanges predicted and estimated range in one sentence. The inputs here are z − x(t|t) and "
        "x(t|t−1) − x(t|t).",
    ),
    remarks=(
        "An aid rescues a badly tuned filter and does next to nothing for a well tuned one, because both of its "
        "inputs are multiples of the innovation.",
        "A straight line in place of ANFIS or network gives most of the gain. An IMM without any training beats all "
        "of them.",
        "The aid that rescues a sluggish filter along x spoils it along z, where this aircraft does not manoeuvre.",
    ),
)
