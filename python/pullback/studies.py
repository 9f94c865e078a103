"""Schemes side by side on a model, and their spectra."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _pullback
from .progress import Progress

if TYPE_CHECKING:
    from . import Model


class Order(NamedTuple):
    """An observed order: the slope of log error over log step, by least squares.

    `confidence` is half of its 95 % interval, None for two points; `points` step sizes are on the line, from
    the largest to the smallest of `steps`.
    """

    order: float
    confidence: float | None
    points: int
    steps: tuple[float, float]


class Comparison:
    """Schemes side by side on one model.

    Errors are root mean squares over common times and all nodes, against a reference. They are of "position",
    "rotation", "velocity", "angular_velocity", "acceleration", "angular_acceleration" and "energy". `schemes` are
    the names; `rows` a dictionary for each run, with its scheme, step, failure or None, counts, errors, drift of energies
    and momenta, and wall time; `reference` tells of the reference, None if it failed.
    """

    def __init__(self, found: dict[str, Any]) -> None:
        self.rows: list[dict[str, Any]] = found["rows"]
        self.reference: dict[str, Any] | None = found["reference"]
        self.reference_failure: str | None = found["reference_failure"]
        self.schemes: list[str] = [scheme["scheme"] for scheme in found["orders"]]
        self._orders = {scheme["scheme"]: scheme["observed"] for scheme in found["orders"]}

    def order(self, scheme: str, quantity: str = "position") -> Order | None:
        """The observed order of a scheme; None where too few errors are above that of the reference."""
        found = _of(_of(self._orders, scheme, "scheme"), quantity, "quantity")
        return None if found is None else Order(**{**found, "steps": tuple(found["steps"])})

    def errors(self, scheme: str, quantity: str = "position") -> np.ndarray:
        """Errors of a scheme at the step sizes of `steps`, of shape (steps,); not a number where a run failed."""
        errors = (row["error"] or {} for row in self._of(scheme))
        return np.array([_number(_of(error, quantity, "quantity")) if error else math.nan for error in errors])

    def steps(self, scheme: str) -> np.ndarray:
        """Step sizes of a scheme, of shape (steps,)."""
        return np.array([row["step"] for row in self._of(scheme)])

    def assemblies(self, scheme: str) -> np.ndarray:
        """Assemblies of the model in each run of a scheme, of shape (steps,): its cost on any machine."""
        return np.array([row["assemblies"] for row in self._of(scheme)])

    def _of(self, scheme: str) -> list[dict[str, Any]]:
        _of(self._orders, scheme, "scheme")
        return [row for row in self.rows if row["scheme"] == scheme]

    def frame(self) -> Any:
        """The rows as a pandas.DataFrame, with columns such as `error.position` and `counts.steps`."""
        import pandas as pd

        return pd.json_normalize(self.rows)

    def plot(self, quantity: str = "position") -> Any:
        """Draws errors over the step size and over the cost, with matplotlib; returns the figure."""
        import matplotlib.pyplot as plt

        figure, panels = plt.subplots(1, 2, sharey=True, layout="constrained")
        costs = [(self.steps, "step size"), (self.assemblies, "assemblies of the model")]
        for panel, (cost, label) in zip(panels, costs):
            for scheme in self.schemes:
                panel.loglog(cost(scheme), self.errors(scheme, quantity), "o-", label=scheme)
            panel.set_xlabel(label)
        panels[0].set_ylabel(f"error of {quantity.replace('_', ' ')}")
        panels[0].legend()
        return figure


class Spectrum:
    """Spectrum of a scheme on an undamped vibration of frequency ω, over Ω = ω h.

    `spectrum["radius"]` and other numbers are arrays over `spectrum["Omega"]`: "radius", "damping" (ratio) and
    "elongation" (of the period), and the same in closed form as "closed_radius" and so on. `limit` is the largest Ω at which
    the scheme is stable, None if it always is; `order` its order.
    """

    def __init__(self, found: dict[str, Any]) -> None:
        self.scheme: str = found["scheme"]
        self.name: str = found["name"]
        self.order: int = found["order"]
        self.limit: float | None = found["limit"]
        self._points: list[dict[str, Any]] = found["points"]

    def __getitem__(self, number: str) -> np.ndarray:
        return np.array([_number(_of(point, number, "number")) for point in self._points])


def compare(
    model: Model,
    schemes: Sequence[str],
    steps: Sequence[float],
    *,
    reference: str | None = None,
    workers: int | None = None,
    timed: bool = False,
    out: str | os.PathLike[str] | None = None,
    progress: bool = False,
) -> Comparison:
    """Compares schemes, such as "newmark", "hht:-0.1", "lie-ga:0.8", at step sizes from large to small.

    `reference` is the scheme of the reference solution, "radau" by default. Runs are made by `workers` threads; with
    `timed` each is repeated alone to measure its time. With a directory `out`, the files of `pullback compare` are
    written there.

    Raises ModelError for a model without [analysis.dynamic], ValueError for other input with which no run can begin.
    """
    with Progress(1.0 if progress else math.nan) as show:
        found = _pullback.compare(
            model._text,
            model._name,
            list(schemes),
            [float(step) for step in steps],
            reference=reference,
            workers=workers,
            timed=timed,
            out=None if out is None else os.fspath(out),
            tell=show,
        )
    found = json.loads(found)
    names = {entry["scheme"]: word for entry, word in zip(found["orders"], schemes)}
    for entry in found["rows"] + found["orders"]:
        entry["scheme"] = names[entry["scheme"]]
    return Comparison(found)


def spectrum(schemes: Sequence[str], *, from_: float = 0.01, to: float = 1000.0) -> dict[str, Spectrum]:
    """Spectra of schemes by their names, measured from steps of the integrator between two Ω.

    Raises ValueError for a scheme that is none or has no spectrum.
    """
    found = json.loads(_pullback.spectra(list(schemes), (from_, to)))
    return dict(zip(schemes, map(Spectrum, found)))


def _of(table: dict[str, Any], key: str, what: str) -> Any:
    if key not in table:
        raise KeyError(f"there is no {what} {key!r}; there are: {', '.join(table)}")
    return table[key]


def _number(value: float | None) -> float:
    return math.nan if value is None else value
