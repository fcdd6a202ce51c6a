"""What a learned filter has learned, as drawings: surfaces of rules, aids and networks."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..filters.aided import Aided
from ..models.anfis import membership
from ..models.corrector import Corrector
from ..models.fuzzy import FuzzyRules
from ..models.network import Network
from ..models.noise_network import LEAST_NIS, ModeNetwork, NoiseNetwork
from ..papers.drawing import Chart, Drawing, Line, Surface

POINTS = 41
NIS = np.geomspace(0.01, 100.0, POINTS)  # what a sensor shows from a straight line to a hard manoeuvre


def pictures(filter: Any) -> list[Drawing]:
    """Drawings of everything learned in a filter; none where nothing is."""
    inner = filter.filter_ if isinstance(filter, Aided) else filter
    out: list[Drawing] = _aid(filter.corrector) if isinstance(filter, Aided) else []
    for k, motion in enumerate(inner.motions, start=1):
        rules, across = getattr(motion, "rules", None), getattr(motion, "across", None)
        network = getattr(motion, "network", None)
        for where, of in (("" if across is None else " along the track", rules), (" across the track", across)):
            if isinstance(of, FuzzyRules):
                out.append(surface(of, f"Mode {k}: noise sd{where} that the rules call for", signed=of is rules))
        if isinstance(network, NoiseNetwork):
            out += _noise(network)
    network = getattr(inner, "network", None)
    if isinstance(network, ModeNetwork):
        out.append(_scores(network, list(inner.modes)))
    return out


def surface(rules: FuzzyRules, title: str, signed: bool = True) -> Surface:
    """Noise sd over the residual and its change, as far as the rules reach; a residual without a sign from zero on."""
    c, s = np.asarray(rules.centres), np.asarray(rules.spreads)
    reach = float(np.median(np.abs(c) + s)) * 1.5
    length, unit = rules.readable
    change = np.linspace(-reach, reach, POINTS)
    residual = change if signed else np.linspace(0.0, reach, POINTS)
    sd = np.sqrt(rules.variance(residual[None, :], change[:, None]))
    return Surface(
        title=title,
        x=f"residual {unit}",
        y=f"its change {unit}",
        grid_x=residual / length,
        grid_y=change / length,
        values=sd,
        unit="m/s²",
        sentences=rules.describe(),
    )


def _noise(network: NoiseNetwork) -> list[Drawing]:
    """The sd of the noise over the NIS along both axes, after a quiet and after a loud scan."""
    out: list[Drawing] = []
    for word, q in (("quiet", network.least), ("loud", network.most)):
        x, y = np.meshgrid(NIS, NIS)
        if network.inputs == "log-nis":
            other = [np.log(x.ravel() + LEAST_NIS), np.log(y.ravel() + LEAST_NIS)]
            u = np.column_stack([np.full(x.size, np.log(q)), *other])
        else:
            S = 2 * (network.sensor_sd or 1.0) ** 2
            u = np.column_stack(
                [np.full(x.size, q), *(np.exp(-0.5 * n.ravel()) / np.sqrt(2 * np.pi * S) for n in (x, y))]
            )
        out.append(
            Surface(
                title=f"Noise sd that the network chooses after a {word} scan ({np.sqrt(q):.3g} m/s²)",
                x="log₁₀ NIS along x",
                y="log₁₀ NIS along y",
                grid_x=np.log10(NIS),
                grid_y=np.log10(NIS),
                values=np.sqrt(network(u)).reshape(x.shape),
                unit="m/s²",
            )
        )
    return out


def _scores(network: ModeNetwork, modes: list[str]) -> Chart:
    """The weight of each mode when one mode explains the measurement with a NIS of one and all others with NIS x."""
    M = network.network.outputs
    lines = []
    for j in range(M):
        nis = np.tile(NIS[:, None], (1, M))
        nis[:, j] = 1.0
        weights = network(np.full((len(NIS), M), 1 / M), nis, 1)
        lines.append(Line(modes[j], np.log10(NIS), weights[:, j]))
    return Chart(
        title="Weight of a mode whose NIS is 1 while that of all others is x",
        x="log₁₀ x",
        y="weight",
        lines=lines,
    )


def _aid(corrector: Corrector) -> list[Drawing]:
    """The correction over the inputs, and an ANFIS' membership functions."""
    words = "position correction"
    low, high = np.asarray(corrector.low), np.asarray(corrector.high)
    if corrector.inputs == "titi-guney":
        u = [np.linspace(low[i], high[i], POINTS) for i in range(2)]
        grid = np.stack(np.meshgrid(*u), axis=-1).reshape(-1, 2)
        values = corrector(grid)[:, 0].reshape(POINTS, POINTS)
        out: list[Drawing] = [
            Surface(
                title=f"{words.capitalize()} over what the filter has seen",
                x="z − x̂(t|t) m",
                y="x̂(t|t−1) − x̂(t|t) m",
                grid_x=u[0],
                grid_y=u[1],
                values=values,
                unit="m",
            )
        ]
    else:
        x = np.linspace(-4, 4, 2 * POINTS)
        lines = []
        for k in range(min(corrector.count, 4)):
            u = np.zeros((len(x), corrector.count))
            u[:, k] = x
            lines.append(Line(("newest", "1 before", "2 before", "3 before")[k], x, corrector(u)[:, 0]))
        title = f"{words.capitalize()} for one innovation, the others zero"
        out = [Chart(title=title, x="innovation / its sd", y="correction / its unit", lines=lines)]
    if not isinstance(corrector.model, Network):
        x = np.linspace(-4, 4, 2 * POINTS)
        functions = np.asarray(corrector.model.memberships[0], dtype=float)
        grades = membership(corrector.model.shape, functions, x)
        out.append(
            Chart(
                title="Membership functions of the first input",
                x="scaled input",
                y="grade",
                lines=[Line(f"{k + 1}", x, grades[:, k]) for k in range(grades.shape[1])],
            )
        )
    return out
