"""What the two papers of Lee, Joo & Park have in common: target, filters, error measure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from ..catalogue.purpose import Named, Purpose
from ..compare.result import Race
from ..filters.adaptive_imm import AugmentedAcceleration, TwoStageAcceleration, aimm
from ..filters.fuzzy_imm import fuzzy_imm
from ..filters.imm import IMM
from ..filters.kalman import Kalman
from ..models.fuzzy import PUBLISHED, FuzzyRules
from ..models.motion import ConstantVelocity
from ..scenarios import SCENARIOS
from .constants import INPUTS, best_constants, over_constants, with_rule_counts
from .drawing import Chart, Drawing, Line, Surface
from .learned import Models, learned
from .paper import Experiment, named, of_race
from .training.lee import SWEPT

POSITION = of_race("normalised_position", "ζp")
VELOCITY = of_race("normalised_velocity", "ζv")
NOISE, BIAS, BIAS_PRIOR = (
    1.0,
    10.0,
    float(np.sqrt(1e3)),
)  # m/s²: process noise, bias noise, √Pa0 (Pa0 = 1e-3 km²/s⁴)
NAMES = ("aimm3", "aimm5", "fuzzy-imm")
# whose noise may lie within the same bounds
RIVALS = {
    "ga": "ga constants",
    "ga, λ = 1": "ga constants",
    **{f"ga, λ = {weight:g}": "ga constants" for weight in SWEPT},
    "best fuzzy": "best constants",
}


def adaptive(name: str, levels: list[float], estimator: type[AugmentedAcceleration]) -> Callable[[Purpose], Named]:
    """An adaptive IMM with these levels (m/s²) around the acceleration that such an estimator finds."""

    def make(purpose: Purpose) -> Named:
        beside = estimator(acceleration_sd=NOISE, bias_sd=BIAS, bias_prior_sd=BIAS_PRIOR)
        filter = aimm(levels, purpose.seen, 0.97, acceleration_sd=NOISE, estimator=beside)
        what = "two-stage" if isinstance(beside, TwoStageAcceleration) else "augmented"
        return named(f"adaptive IMM, levels {', '.join(f'{v:g}' for v in levels)} m/s², {what}", filter)

    return make


def alone(name: str, estimator: type[AugmentedAcceleration]) -> Callable[[Purpose], Named]:
    """The acceleration estimator's own output."""

    def make(purpose: Purpose) -> Named:
        motion = estimator(acceleration_sd=NOISE, bias_sd=BIAS, bias_prior_sd=BIAS_PRIOR)
        return named(f"{motion.name} by itself", Kalman(motion, purpose.seen))

    return make


def published_rules(purpose: Purpose) -> Named:
    """The fuzzy IMM with the rule tables of lee-2003."""
    return named("fuzzy IMM, rules of tables 2.1 to 2.3", fuzzy_imm(purpose.seen, "lee-2003", 0.97))


def constants(purpose: Purpose) -> Named:
    """The same IMM with three constant noises: the lower ends of equation 15, 0.5 (a_M + √q)."""
    sds = [0.5 * (u + NOISE) for u in (1.0, 10.0, 100.0)]
    filter = IMM(
        [ConstantVelocity(acceleration_sd=sd) for sd in sds],
        purpose.seen,
        transition=0.97,
        mode_probability=[0.6, 0.2, 0.2],
    )
    return named(f"IMM of constant noises, sd {', '.join(f'{s:g}' for s in sds)} m/s²", filter)


def fitted_adaptive(models: Models) -> dict[str, Callable[[Purpose], Named]]:
    """AIMM3 with Qa fitted, and with intervals in units of its estimator's standard deviation."""

    def row(name: str, words: str) -> Callable[[Purpose], Named]:
        def make(purpose: Purpose) -> Named:
            found = learned(models, name, words, fitted="other runs")(purpose)
            filter = found.filter
            level, bias = filter.motions[-1].acceleration, filter.estimator.bias_sd
            said = f"{words}; levels ±{float(np.ravel(level)[0]):g}, √Qa {float(np.ravel(bias)[0]):.2g} m/s²"
            return replace(found, words=said)

        return make

    return {
        "aimm3, Qa": row("lee-2003-aimm3", "AIMM3 as published, Qa fitted"),
        "aimm3 in sd": row("lee-2003-aimm3-in-sd", "AIMM3 with levels ±c √P_aa, c and Qa fitted"),
        "augmented in sd": row("lee-2003-aimm3-augmented-in-sd", "the same around the augmented filter's estimate"),
    }


def experiment(
    published: Mapping[tuple[str, str], float],
    models: Models,
    more: Mapping[str, Callable[[Purpose], Named]] | None = None,
) -> Experiment:
    """The one experiment of both papers, with more filters."""
    return Experiment(
        name="three manoeuvres",
        words="x +10 m/s² in scans 40–60, y +60 in 80–90, x −30 in 120–140",
        scenario=SCENARIOS["lee-2003"],
        filters={
            "aimm3": adaptive("aimm3", [-40.0, 0.0, 40.0], TwoStageAcceleration),
            "aimm5": adaptive("aimm5", [-40.0, -20.0, 0.0, 20.0, 40.0], TwoStageAcceleration),
            "fuzzy-imm": published_rules,
            "ga": with_rule_counts(
                learned(models, "lee-2003-ga", "fuzzy IMM, rules by our own run of the paper's GA, λ = 0.95")
            ),
            "ga, λ = 1": with_rule_counts(learned(models, "lee-2003-ga-error", "the same with λ = 1: the error alone")),
            **{
                f"ga, λ = {weight:g}": with_rule_counts(
                    learned(models, f"lee-2003-ga-{weight:g}", f"the same with λ = {weight:g}")
                )
                for weight in SWEPT
            },
            "constants": constants,
            "ga constants": best_constants(seed=0),
            "best fuzzy": with_rule_counts(
                learned(
                    models,
                    "lee-2003-best",
                    "fuzzy IMM, rules and transition matrix found together by CMA-ES",
                    fitted="other runs",
                )
            ),
            "best constants": learned(
                models,
                "lee-2003-best-constants",
                "the same with one rule per mode, a constant, and a transition matrix of its own",
                fitted="other runs",
            ),
            "aimm3-augmented": adaptive("aimm3-augmented", [-40.0, 0.0, 40.0], AugmentedAcceleration),
            "two-stage": alone("two-stage", TwoStageAcceleration),
            "augmented": alone("augmented", AugmentedAcceleration),
            **(more or {}),
        },
        metrics=(POSITION, VELOCITY, over_constants(RIVALS, "pos ÷ its constants")),
        published=published,
        baselines=("raw", "kalman-cv", "kalman-ca", "imm", "imm-cv-ca", "clairvoyant"),
    )


def published(
    aimm3: tuple[float, float], aimm5: tuple[float, float], fuzzy: tuple[float, float]
) -> dict[tuple[str, str], float]:
    """ζp and ζv of a table by filter and metric."""
    rows = zip(NAMES, (aimm3, aimm5, fuzzy), strict=True)
    return {
        (name, metric.name): value
        for name, pair in rows
        for metric, value in zip((POSITION, VELOCITY), pair, strict=True)
    }


def errors(races: Mapping[str, Race]) -> list[Drawing]:
    """Figures 3 and 4: the target and the normalised errors."""
    race = next(iter(races.values()))
    scenario = SCENARIOS["lee-2003"]
    truth = scenario.simulate(1).truth
    command = scenario.simulate(1).input
    assert command is not None
    scans = np.arange(1, 181)
    out: list[Drawing] = [
        Chart(
            title="Figure 3: the target's accelerations",
            x="scan",
            y="m/s²",
            lines=[Line(a, np.repeat(scans, 2)[1:], np.repeat(command[0, :, k], 2)[:-1]) for k, a in enumerate("xy")],
        ),
        Chart(
            title="Figure 3: its track (one run)",
            x="x km",
            y="y km",
            lines=[Line("", truth.position[0, :, 0] / 1000, truth.position[0, :, 1] / 1000)],
            square=True,
        ),
    ]
    shaded = [(40, 60), (80, 90), (120, 140)]
    for quantity in ("position", "velocity"):
        lines = []
        for name in (*NAMES, "kalman-cv"):
            value = race.tallies[name].normalised_over_time(quantity)
            lines.append(Line(name, scans[race.skipped_scans :], value, faint=name not in NAMES))
        out.append(Chart(title=f"Figure 4: normalised {quantity} error", x="scan", y="", lines=lines, shaded=shaded))
    return out


def draw(races: Mapping[str, Race]) -> list[Drawing]:
    """Figures 3 and 4, and the noise that the rules of tables 2.1 to 2.3 and our own call for."""
    out = errors(races)
    for k, (rules, u) in enumerate(zip(PUBLISHED["lee-2003"], INPUTS, strict=True), start=1):
        out.append(_surface(rules, f"Table 2.{k}: noise sd that the rules for {u:g} m/s² call for"))
    entrants = next(iter(races.values())).entrants
    for name in ("ga, λ = 1", "best fuzzy"):
        motions = entrants[name].filter.motions if name in entrants else ()
        for k, motion in enumerate(motions, start=1):
            out.append(_surface(motion.rules, f"Not in the paper: noise sd of mode {k}, {name}"))
    return out


def _surface(rules: FuzzyRules, title: str) -> Surface:
    grid, sd = rules.surface(3000.0)
    return Surface(
        title=title,
        x="residual km",
        y="its change km",
        grid_x=grid / 1000,
        grid_y=grid / 1000,
        values=sd,
        unit="m/s²",
        sentences=rules.describe(),
    )


READINGS = (
    "The paper does not state the number of scans, the windows' ends and Pa0. Here they are 180 scans, inclusive ends "
    "and Pa0 = 1e-3 km²/s⁴.",
    "Every filter runs along each axis by itself, with mode probabilities of its own. ε is in km/s². The rules' "
    "outputs are variances, their residuals are in km. Tracks start from two points.",
    "The normalised error is the RMS error divided by that of the measurements. It is taken in every scan over all "
    "axes and averaged over scans 3 to 180. The measured velocity is the difference of two positions.",
    "The two-stage estimator's 0.01 and 0.001 km/s² are standard deviations per scan. Its printed S(k) = H "
    "U(k−1) is read as H U(k).",
    "V(0) is not stated: [0; T/2], which is what the two first positions leave of an unknown acceleration.",
    "“ga constants” and “best constants” are found within the same bounds and on the same targets as the rules of “ga” "
    "and “best fuzzy”; “constants” are the lower ends of equation 15. “ga”'s rules come from one seed, 0.",
    "Δr is 0 at the first update; firing strengths are taken in logarithms, where the printed quotient is 0/0 "
    "far from every rule.",
)
