"""Sweeps: one model with many values of its parameters."""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _pullback

if TYPE_CHECKING:
    from . import Model


# Model and its name, axes, reductions.
_Sweep = tuple[tuple[str, str], list[tuple[str, list[str]]], list[str]]

# Parts of a sweep on Dask: a lost worker's part is made again.
PARTS = 256


class SweepTable:
    """The rows of a sweep, in the order of its runs.

    `columns` are their names: `run`, the paths of the parameters, `outcome` ("complete", or why a run failed),
    `t`, `seconds`, and what is kept of the probes; `table[name]` is a column as an array.
    """

    def __init__(self, columns: list[str], rows: list[tuple[Any, ...]]) -> None:
        self.columns, self.rows = columns, rows

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.columns:
            raise KeyError(f"there is no column {name!r}; there are: {', '.join(self.columns)}")
        k = self.columns.index(name)
        return np.array([row[k] for row in self.rows])

    def frame(self) -> Any:
        """The table as a pandas.DataFrame, which writes CSV and, where pyarrow is installed, Parquet."""
        import pandas as pd

        return pd.DataFrame(self.rows, columns=self.columns)


def sweep(
    model: Model,
    over: Mapping[str, Sequence[Any]],
    *,
    keep: Sequence[str] = ("last",),
    workers: int | None = None,
    client: Any = None,
) -> SweepTable:
    """Runs a model with all combinations of values of its parameters, the last one varying fastest.

    `over` has the values by the path of each parameter. `keep` says what is kept of each probe: "last", "max", "min",
    "at(T)". Runs are made by `workers` threads, by default one for each processor, or by the workers of a
    Dask `client`. A run that fails or is refused is a row with its message.

    Raises ModelError for a path that is no parameter, before the first run.
    """
    from . import _value

    axes = [(path, [_value(value) for value in values]) for path, values in over.items()]
    count = int(np.prod([len(values) for _, values in axes], dtype=int))
    arguments = ((model._text, model._name), axes, list(keep))
    if client is None:
        threads = workers or os.cpu_count() or 1
        names, rows = _pullback.sweep(*arguments, runs=None, workers=threads)
    else:
        names, _ = _pullback.sweep(*arguments, runs=[], workers=1)
        parts = [part.tolist() for part in np.array_split(np.arange(count), min(count, PARTS))]
        futures = client.map(_part, parts, arguments=arguments, pure=False)
        rows = [row for part in client.gather(futures) for row in part]
    columns = ["run", *over, "outcome", "t", "seconds", *names]
    values = list(itertools.product(*over.values()))
    table = [
        (run, *values[run], outcome, t, seconds, *kept) for run, _, outcome, t, seconds, kept in rows
    ]
    return SweepTable(columns, table)


def _part(runs: list[int], arguments: _Sweep) -> list[Any]:
    """Some runs of a sweep, on a worker of Dask."""
    return _pullback.sweep(*arguments, runs=runs, workers=1)[1]
