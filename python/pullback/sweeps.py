"""Sweeps: one model with many values of its parameters."""

from __future__ import annotations

import contextlib
import functools
import itertools
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _pullback
from .progress import Progress

if TYPE_CHECKING:
    from . import Model


# Model and its name, axes, reductions.
_Arguments = tuple[tuple[str, str], list[tuple[str, list[str]]], list[str]]

# Parts of a sweep on Dask: a lost worker's part is made again.
PARTS = 256


class SweepTable:
    """The rows of a sweep, in the order of its runs.

    `columns` are their names: `run`, the paths of the parameters, `outcome` ("complete", or why a run failed),
    `t`, `seconds`, what is kept of the probes, and `warnings`; `table[name]` is a column as an array.
    """

    def __init__(self, columns: list[str], rows: list[tuple[Any, ...]]) -> None:
        self.columns, self.rows = columns, rows

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.columns:
            raise KeyError(f"there is no column {name!r}; there are: {', '.join(self.columns)}")
        k = self.columns.index(name)
        column = [row[k] for row in self.rows]
        try:
            return np.array(column)
        except ValueError:
            # Values of several lengths.
            return np.fromiter(column, dtype=object)

    def frame(self) -> Any:
        """The table as a pandas.DataFrame, which writes CSV and, where pyarrow is installed, Parquet."""
        import pandas as pd

        return pd.DataFrame(self.rows, columns=self.columns)


def sweep(
    model: Model,
    over: Mapping[str, Iterable[Any]],
    *,
    keep: Sequence[str] = ("last",),
    workers: int | None = None,
    client: Any = None,
    out: str | os.PathLike[str] | None = None,
    progress: bool = False,
) -> SweepTable:
    """Runs a model with all combinations of values of its parameters, the last one varying fastest.

    `over` has the values by the path of each parameter. `keep` says what is kept of each probe: "last", "max", "min",
    "at(T)". Runs are made by `workers` threads, by default one for each processor, or by the workers of a
    Dask `client`. A run that fails or is refused is a row with its message, but for the first, which says which
    columns there are.

    With a directory `out`, rows are saved as `pullback sweep` does, in sweep.csv, and a sweep that was stopped goes
    on there. After Ctrl-C, KeyboardInterrupt is raised, with the rows so far in its `result`; so are other errors.

    Raises ModelError for a path that is not a parameter, and where the first run is refused, and ValueError for a directory that
    holds another sweep.
    """
    from . import _value

    over = {path: list(values) for path, values in over.items()}
    axes = [(path, [_value(value) for value in values]) for path, values in over.items()]
    arguments = ((model._text, model._name), axes, list(keep))
    runs = _pullback.Sweep(*arguments)
    saved = None if out is None else runs.open(os.fspath(out))
    rows = [] if saved is None else saved.rows()
    columns = ["run", *over, "outcome", "t", "seconds", *runs.columns, "warnings"]
    values = list(itertools.product(*over.values()))

    def table() -> SweepTable:
        ordered = sorted(rows, key=lambda row: row[0])
        return SweepTable(columns, [(run, *values[run], *told, *kept, last) for run, _, *told, kept, last in ordered])

    try:
        with Progress(len(runs) if progress else math.nan, done=len(rows)) as show:

            def each(new: list[Any]) -> None:
                rows.extend(new)
                if saved is not None:
                    saved.add(new)
                if show is not None:
                    show(len(rows))

            done = {row[0] for row in rows}
            missing = [run for run in range(len(runs)) if run not in done]
            if client is None:
                runs.run(missing, workers or os.cpu_count() or 1, each)
            else:
                _on_dask(client, arguments, missing, each)
        if saved is not None:
            saved.finish()
    except BaseException as error:
        error.result = table()  # type: ignore[attr-defined]
        if saved is not None:
            # The first error is told.
            with contextlib.suppress(OSError):
                saved.finish()
        raise
    return table()


def _on_dask(client: Any, arguments: _Arguments, runs: list[int], each: Any) -> None:
    """Makes runs on the workers of a Dask client, in parts."""
    from distributed import as_completed

    count = min(len(runs), PARTS)
    parts = [runs[k::count] for k in range(count)]
    futures = client.map(functools.partial(_part, arguments=arguments), parts, pure=False)
    try:
        for future in as_completed(futures):
            each(future.result())
    finally:
        client.cancel(futures)


def _part(runs: list[int], arguments: _Arguments) -> list[Any]:
    """Some runs of a sweep, on a worker of Dask."""
    rows: list[Any] = []
    _pullback.Sweep(*arguments).run(runs, 1, rows.extend)
    return rows
