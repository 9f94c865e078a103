"""What a run leaves: history, poses, modes."""

from __future__ import annotations

from typing import Any

import numpy as np


class Modes:
    """Modes about a state, by growing magnitude of their eigenvalues.

    `frequencies` in cycles per unit of time, `damping_ratios`, `eigenvalues` (complex), all of shape (modes,);
    `effective_mass` of shape (modes, 3); `shapes`, complex, of shape (coordinates, modes), and names `coordinates`.
    `counted` is the number of eigenvalues in the region searched, by Sylvester's law of inertia, None with damping.
    """

    def __init__(self, found: dict[str, Any]) -> None:
        self.frequencies: np.ndarray = found["frequencies"]
        self.damping_ratios: np.ndarray = found["damping_ratios"]
        self.eigenvalues = found["re"] + 1j * found["im"]
        self.effective_mass = np.stack([found[f"mass_{axis}"] for axis in "xyz"], axis=-1)
        self.coordinates: list[str] = found["coordinates"]
        shape = (len(self.frequencies), len(self.coordinates))
        real, imaginary = (np.array(found[f"shapes_{part}"]).reshape(shape) for part in ("re", "im"))
        self.shapes = (real + 1j * imaginary).T
        self.counted: int | None = found["counted"]

    def __len__(self) -> int:
        return len(self.frequencies)


class Result:
    """What a run leaves.

    `history` holds the numbers of history.csv, but for the number of the row, as arrays of shape (rows,) that cannot be
    changed, `events` the located event of each row or None. `nodes` are the names of all frames, `positions` and `rotations` (rotation vectors in the chart in use) of shape
    (rows, nodes, 3). `modes` are those of [analysis.modes]; `eigenvalues` the tables of [analysis.buckling]
    (loads, shapes) and [analysis.campbell] (speeds, frequencies, damping_ratios).
    """

    def __init__(self, found: dict[str, Any]) -> None:
        for column in found["history"].values():
            column.setflags(write=False)
        self.history: dict[str, np.ndarray] = found["history"]
        self.events: list[str | None] = found["events"]
        self.nodes: list[str] = found["nodes"]
        self.parameter: str = found["parameter"]
        self.warnings: list[str] = found["warnings"]
        self.notes: list[str] = found["notes"]
        self.steps: int = found["steps"]
        self.iterations: int = found["iterations"]
        self.ending: str = found["ending"]
        self.message: str = found["message"]
        found["poses"].setflags(write=False)
        poses = found["poses"].reshape(len(self.events), len(self.nodes), 2, 3)
        self.positions, self.rotations = poses[:, :, 0], poses[:, :, 1]
        self.eigenvalues: dict[str, Any] | None = found.get("eigenvalues")
        modal = self.eigenvalues or {}
        self.modes: Modes | None = Modes(modal) if "shapes_re" in modal else None

    @property
    def complete(self) -> bool:
        """Whether the analysis came to its end."""
        return self.ending == "complete"

    @property
    def t(self) -> np.ndarray:
        """Load parameter or time of each row."""
        return self.history["t"]

    def __getitem__(self, name: str) -> np.ndarray:
        """A probe or another column, of shape (rows,), or (rows, 3) for a probe of a vector."""
        if name in self.history:
            return self.history[name]
        axes = self._axes(name)
        if not axes:
            known = ", ".join(self.history)
            raise KeyError(f"there is no probe or column {name!r}; there are: {known}")
        return np.stack([self.history[f"{name}.{axis}"] for axis in axes], axis=-1)

    def __contains__(self, name: str) -> bool:
        return name in self.history or bool(self._axes(name))

    def _axes(self, name: str) -> str:
        """The axes of the probe of a vector: global ones, or those of a section."""
        found = (axes for axes in ("xyz", "123") if all(f"{name}.{axis}" in self.history for axis in axes))
        return next(found, "")

    def position(self, node: str) -> np.ndarray:
        """The positions of a node, of shape (rows, 3)."""
        return self.positions[:, self._number(node)]

    def rotation(self, node: str) -> np.ndarray:
        """The rotation vectors of a node in the chart in use, of shape (rows, 3)."""
        return self.rotations[:, self._number(node)]

    def _number(self, node: str) -> int:
        try:
            return self.nodes.index(node)
        except ValueError:
            raise KeyError(f"there is no node {node!r}; there are: {', '.join(self.nodes)}") from None

    def frame(self) -> Any:
        """The history as a pandas.DataFrame."""
        import pandas as pd

        return pd.DataFrame(self.history)

    def plot(self, *names: str) -> Any:
        """Draws probes over the load parameter or time, a panel for each, with matplotlib; returns the figure."""
        import matplotlib.pyplot as plt

        columns = list(self.history)
        after = columns[columns.index("strain_energy") + 1 :]
        probes = after[1 if after[0] == "unstable" else 2 :]
        names = names or tuple(probes) or ("strain_energy",)
        figure, panels = plt.subplots(len(names), sharex=True, squeeze=False, layout="constrained")
        for panel, name in zip(panels[:, 0], names):
            values = self[name]
            lines = panel.plot(self.t, values)
            panel.set_ylabel(name)
            if values.ndim == 2:
                panel.legend(lines, self._axes(name))
        panels[-1, 0].set_xlabel(self.parameter)
        return figure

    def animate(self, interval: int = 40) -> Any:
        """The nodes over the rows as a matplotlib animation, `interval` milliseconds each."""
        import matplotlib.pyplot as plt
        from matplotlib.animation import FuncAnimation

        figure = plt.figure()
        axes = figure.add_subplot(projection="3d")
        low, high = self.positions.min(axis=(0, 1)), self.positions.max(axis=(0, 1))
        centre, half = (low + high) / 2, max((high - low).max() / 2, 1e-12)
        for k, limits in enumerate((axes.set_xlim, axes.set_ylim, axes.set_zlim)):
            limits(centre[k] - half, centre[k] + half)
        (points,) = axes.plot(*self.positions[0].T, "o", markersize=3)

        def show(row: int) -> tuple[Any]:
            points.set_data_3d(*self.positions[row].T)
            axes.set_title(f"{self.parameter} {self.t[row]:.6g}")
            return (points,)

        return FuncAnimation(figure, show, frames=len(self.events), interval=interval)

    def __repr__(self) -> str:
        reached = f"{self.parameter} {self.t[-1]:.6g}" if len(self.events) else "no row"
        return f"<pullback.Result {self.ending}, {len(self.events)} rows up to {reached}>"
