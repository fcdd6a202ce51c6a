"""A fit on plots without identity as tables."""

from __future__ import annotations

from ..fit.sky import SkyFit
from .fit_table import broken, interval, number
from .terminal import print_line, print_table, standard_output


def show(fit: SkyFit) -> None:
    """Print it on standard output."""
    console = standard_output()
    print_line(console, f"{fit.name} for {fit.kind}, fitted on {fit.training}, {fit.evaluations} evaluations", "bold")
    rows = [
        [broken(row["parameter"]), number(row["before"]), number(row["after"]), interval(row["low"], row["high"])]
        for row in fit.parameters
    ]
    print_table(console, ["parameter", "before", "after", "95% interval"], rows)
    console.print()
    gains = [b - a for a, b in zip(fit.before, fit.after, strict=True)]
    print_line(
        console,
        f"log-likelihood per scan {fit.before[0]:.4g} → {fit.after[0]:.4g} ({gains[0]:+.3g}), "
        f"of the scans held out {fit.before[1]:.4g} → {fit.after[1]:.4g} ({gains[1]:+.3g})",
    )
    if fit.partial:
        print_line(console, "warning: cut short; the best so far, without intervals", "yellow")
    if not fit.gain:
        print_line(console, "warning: the scans held out are no likelier than with what the tracks say", "yellow")
