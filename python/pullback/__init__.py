"""Flexible multibody dynamics on manifolds: model files, runs and results as NumPy arrays.

A model is the text of a model file; its words are those of docs/model_file.md. Units are consistent ones of your
choice, vectors are in global components, angles in radians.

    import pullback as pb

    model = pb.Model.from_file("frame.toml")
    result = model.run()
    result["tip"]                         # a probe, a row for each step
    model.with_({"loads.0.force.2": -500}).run()
"""

from __future__ import annotations

import copy
import json
import math
import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import _pullback
from ._pullback import AnalysisError, ModelError, SavedMotion, Simulation, __version__
from .progress import Progress
from .results import Modes, Result
from .studies import Comparison, Order, Spectrum, compare, spectrum
from .sweeps import SweepTable, sweep

__all__ = [
    "AnalysisError",
    "Comparison",
    "Linearized",
    "Model",
    "ModelBuilder",
    "ModelError",
    "Modes",
    "Order",
    "Result",
    "SavedMotion",
    "Simulation",
    "Spectrum",
    "SweepTable",
    "__version__",
    "compare",
    "schema",
    "spectrum",
    "sweep",
]


def _value(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value if abs(value) < 2**63 else float(value))
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise TypeError(f"a model file has no value such as {value!r}")


class Model:
    """A model and its analysis: the text of a model file.

    A model does not change; it can be pickled, compared by text and name, and sent to other processes.
    """

    __slots__ = ("_name", "_text", "end", "inputs", "title")

    def __init__(self, text: str, name: str = "model") -> None:
        """A model from the text of a model file; messages call it `name`.

        Raises ModelError with the line and the cure if the text is refused.
        """
        self._text = text
        self._name = os.fspath(name)
        self.title: str | None
        self.end: float
        self.inputs: list[str]
        self.title, self.end, self.inputs = _pullback.inspect(self._text, self._name)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Model:
        """A model from a model file."""
        with open(path, encoding="utf-8") as file:
            return cls(file.read(), os.fspath(path))

    @classmethod
    def from_toml(cls, text: str, name: str = "model") -> Model:
        """A model from the text of a model file."""
        return cls(text, name)

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any], name: str = "model") -> Model:
        """A model from the tables of a model file, as dictionaries and lists."""
        return cls(_toml(tables), name)

    def to_toml(self) -> str:
        """The text of the model file."""
        return self._text

    def with_(self, parameters: Mapping[str, Any]) -> Model:
        """The model with other values of parameters, by their paths, such as {"loads.0.force.2": -500}.

        Raises ModelError for a path that is not a parameter.
        """
        values = [(path, _value(value)) for path, value in parameters.items()]
        return Model(_pullback.with_parameters(self._text, values), self._name)

    def run(self, *, progress: bool = False, check: bool = True) -> Result:
        """Runs the analysis in memory; other Python threads go on meanwhile. `progress` shows a line for a motion.

        Warnings are Python warnings. If the analysis fails, AnalysisError is raised, with what has converged in
        its `result`; with check=False the result is returned, and says so. After Ctrl-C, KeyboardInterrupt is raised,
        also with a `result`.
        """
        with Progress(self.end if progress else math.nan) as show:
            found = _pullback.run(self._text, self._name, show)
        result = Result(found)
        for warning in result.warnings:
            warnings.warn(warning, stacklevel=2)
        error: BaseException | None = found["raised"]
        if error is None and check and not result.complete:
            error = AnalysisError(result.message)
        if error is not None:
            error.result = result  # type: ignore[attr-defined]
            raise error
        return result

    def write(self, directory: str | os.PathLike[str]) -> None:
        """Runs the analysis with all files of `pullback run`: history, results, figures, ParaView files.

        Raises OSError where they cannot be written.
        """
        complete, message = _pullback.write(self._text, self._name, os.fspath(directory))
        if not complete:
            raise AnalysisError(message or "the analysis did not reach its end")

    def linearize(self, at: float | None = None) -> Linearized:
        """The linear equations of motion about the state at the end of the analysis, or at a load parameter or time.

        Raises AnalysisError for a model with [analysis.campbell], whose equations depend on the speed.
        """
        found = _pullback.linearize(self._text, self._name, at)
        for warning in found["warnings"]:
            warnings.warn(warning, stacklevel=2)
        return Linearized(found)

    def modes(
        self, count: int = 10, *, at: float | None = None, near: float = 0.0, undamped: bool = False
    ) -> Modes:
        """Modes about the state at the end of the analysis, or at a load parameter or time: those nearest to the
        frequency `near`, in cycles per unit of time; none is missed."""
        found = _pullback.find_modes(self._text, self._name, at, count, near, undamped)
        for warning in found["warnings"]:
            warnings.warn(warning, stacklevel=2)
        return Modes(found)

    def check(self, seed: int = 0) -> list[dict[str, Any]]:
        """Verifies the model, as `pullback check`: a row for each property of each component.

        Raises AnalysisError if a property does not hold; the rows are in its `result`.
        """
        rows, well = _pullback.verify(self._text, self._name, seed)
        rows = json.loads(rows)
        if not well:
            error = AnalysisError("the model does not pass its check")
            error.result = rows  # type: ignore[attr-defined]
            raise error
        return rows

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and (self._text, self._name) == (other._text, other._name)

    def __hash__(self) -> int:
        return hash((self._text, self._name))

    def __repr__(self) -> str:
        return f"<pullback.Model {self.title or self._name!r}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._text, self._name, __version__)


def _unpickled(text: str, name: str, version: str) -> Model:
    try:
        return Model(text, name)
    except ModelError as refusal:
        if version == __version__:
            raise
        raise ModelError(f"a model pickled by pullback {version}, read by {__version__}: {refusal}") from None


def _toml(tables: Mapping[str, Any]) -> str:
    """The text of a model file: a table for each part."""

    def lines(keys: Mapping[str, Any]) -> list[str]:
        return [f"{_key(key)} = {_value(value)}" for key, value in keys.items()]

    head, parts = [], []
    for name, value in tables.items():
        if isinstance(value, Mapping) and all(isinstance(v, Mapping) for v in value.values()):
            for key, inner in value.items():
                parts += ["", f"[{name}.{_key(key)}]", *lines(inner)]
        elif isinstance(value, Mapping):
            parts += ["", f"[{name}]", *lines(value)]
        elif isinstance(value, list) and all(isinstance(v, Mapping) for v in value):
            for entry in value:
                parts += ["", f"[[{name}]]", *lines(entry)]
        else:
            head += lines({name: value})
    return "\n".join(head + parts) + "\n"


def _key(key: str) -> str:
    return key if key.isascii() and key.replace("_", "").replace("-", "").isalnum() else _value(key)


class ModelBuilder:
    """Builds a model with the words of the model file.

    Each method adds one entry with its keys; `from` is written `from_`.

        m = pb.ModelBuilder("A pendulum")
        m.node("ground", [0, 0, 0])
        m.support(node="ground", fix="all")
        m.joint("revolute", name="pivot", parent="ground", axis=[0, 1, 0])
        m.body(name="bob", node="pivot", mass=1.0, center=[0, 0, -1])
        m.load(gravity=[0, 0, -9.81])
        m.analysis("dynamic", to=10, step=0.01)
        m.probe("angle", "joint_coordinate", joint="pivot")
        model = m.build()
    """

    def __init__(self, title: str | None = None) -> None:
        self._tables: dict[str, Any] = {} if title is None else {"title": title}

    def _named(self, table: str, name: str, value: Any) -> None:
        named = self._tables.setdefault(table, {})
        if name in named:
            raise ValueError(f"{table} has {name!r} already")
        named[name] = copy.deepcopy(value)

    def _add(self, table: str, keys: dict[str, Any]) -> None:
        entry = {key.removesuffix("_"): copy.deepcopy(value) for key, value in keys.items()}
        self._tables.setdefault(table, []).append(entry)

    def section(self, name: str, **keys: Any) -> None:
        """A cross-section of beams."""
        self._named("sections", name, keys)

    def node(self, name: str, position: Sequence[float]) -> None:
        """A node at a reference position."""
        self._named("nodes", name, position)

    def input(self, name: str, value: float = 0.0) -> None:
        """A value that loads, actuators and prescribed coordinates read by its name."""
        self._named("inputs", name, value)

    def imperfection(self, **keys: Any) -> None:
        """A mode shape of another analysis that is added to the positions of nodes."""
        self._add("imperfections", keys)

    def line(self, name: str, **keys: Any) -> None:
        """A line of beam elements."""
        self._add("lines", {"name": name, **keys})

    def body(self, **keys: Any) -> None:
        """A rigid body or point mass."""
        self._add("bodies", keys)

    def joint(self, type: str, **keys: Any) -> None:
        """A joint."""
        self._add("joints", {"type": type, **keys})

    def gear(self, **keys: Any) -> None:
        """A gear between two joints."""
        self._add("gears", keys)

    def spring(self, **keys: Any) -> None:
        """A spring or damper."""
        self._add("springs", keys)

    def support(self, **keys: Any) -> None:
        """Coordinates of a node that are held or prescribed."""
        self._add("supports", keys)

    def load(self, **keys: Any) -> None:
        """A load."""
        self._add("loads", keys)

    def initial(self, **keys: Any) -> None:
        """An initial condition."""
        self._add("initial", keys)

    def probe(self, name: str, quantity: str, **keys: Any) -> None:
        """A quantity that is recorded."""
        self._add("probes", {"name": name, "quantity": quantity, **keys})

    def analysis(self, kind: str, **keys: Any) -> None:
        """The analysis, in place of one given before."""
        self._tables["analysis"] = {kind: copy.deepcopy(keys)}

    def to_toml(self) -> str:
        """The text of the model file so far."""
        return _toml(self._tables)

    def build(self, name: str = "model") -> Model:
        """The model; ModelError if it is refused."""
        return Model(self.to_toml(), name)


class Linearized:
    """The linear equations of motion M q̈ + C q̇ + K q = (∂r/∂u) u about a state.

    K, C and M are matrices of scipy.sparse (CSC), `r_u` an array of shape (n, inputs).
    """

    def __init__(self, found: dict[str, Any]) -> None:
        from scipy.sparse import coo_array

        self.coordinates: list[str] = found["coordinates"]
        self.inputs: list[str] = found["inputs"]
        n = len(self.coordinates)
        self.K, self.C, self.M = (
            coo_array((values, (rows, columns)), shape=(n, n)).tocsc()
            for rows, columns, values in (found[name] for name in "KCM")
        )
        self.r_u = np.array(found["r_u"]).reshape(len(self.inputs), n).T


def schema() -> dict[str, Any]:
    """The JSON Schema of the model file."""
    return json.loads(_pullback.schema())
