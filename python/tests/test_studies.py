"""Schemes side by side, and their spectra."""

import math

import numpy as np
import pullback as pb
import pytest

PENDULUM = """
[nodes]
ground = [0, 0, 0]
[[supports]]
node = "ground"
fix = "all"
[[joints]]
name = "pivot"
type = "revolute"
parent = "ground"
axis = [0, 1, 0]
value = 2.0
[[joints]]
name = "bob"
type = "offset"
parent = "pivot"
position = [0, 0, -1]
[[bodies]]
name = "mass"
node = "bob"
mass = 1.0
[[loads]]
gravity = [0, 0, -9.81]
[analysis.dynamic]
to = 1.0
step = 0.01
"""


def test_orders_are_those_of_theory(tmp_path):
    model = pb.Model.from_toml(PENDULUM)
    steps = [0.02, 0.01, 0.005, 0.0025]
    comparison = pb.compare(model, ["newmark", "bathe", "radau"], steps, out=tmp_path / "compare")
    assert comparison.schemes == ["newmark", "bathe", "radau"]
    for scheme, order in [("newmark", 2), ("bathe", 2), ("radau", 3)]:
        assert comparison.order(scheme, "velocity").order == pytest.approx(order, abs=0.2)
        errors = comparison.errors(scheme)
        assert errors.shape == (4,) and np.all(np.diff(errors) < 0)
        assert comparison.steps(scheme) == pytest.approx(steps)
        assert np.all(np.diff(comparison.assemblies(scheme)) > 0)
    assert (tmp_path / "compare" / "compare.html").exists()
    assert len(pytest.importorskip("pandas").DataFrame(comparison.frame())) == 12
    pytest.importorskip("matplotlib").use("Agg")
    assert len(comparison.plot("rotation").axes) == 2


def test_schemes_have_the_names_that_are_given():
    words = ["ga:0.80", "newmark:0.25:0.5"]
    comparison = pb.compare(pb.Model.from_toml(PENDULUM), words, [0.02, 0.01])
    assert comparison.schemes == words == list(pb.spectrum(words))
    assert all(np.all(comparison.errors(word) > 0) for word in words)


def test_what_cannot_be_compared_is_refused():
    model = pb.Model.from_toml(PENDULUM)
    with pytest.raises(ValueError, match="newmak"):
        pb.compare(model, ["newmak"], [0.02, 0.01])
    with pytest.raises(ValueError, match="decrease"):
        pb.compare(model, ["newmark"], [0.01, 0.02])
    with pytest.raises(ValueError, match="not usable"):
        pb.compare(model, ["newmark"], [math.nan, 0.02])
    comparison = pb.compare(model, ["newmark"], [0.02, 0.01])
    with pytest.raises(KeyError, match="there is no scheme 'bathe'; there are: newmark"):
        comparison.errors("bathe")
    with pytest.raises(KeyError, match="there is no quantity 'place'"):
        comparison.order("newmark", "place")


def test_spectra_are_those_of_theory():
    """The trapezoidal rule turns by 2 atan(Ω/2) in a step; radii at infinity are Chung & Hulbert's ρ∞."""
    spectra = pb.spectrum(["newmark", "ga:0.8"], from_=0.01, to=1e6)
    newmark = spectra["newmark"]
    Omega = newmark["Omega"]
    small = Omega < 3
    exact = Omega[small] / (2 * np.arctan(Omega[small] / 2)) - 1
    assert newmark["elongation"][small] == pytest.approx(exact, rel=1e-6, abs=1e-9)
    assert newmark["radius"] == pytest.approx(1.0, abs=1e-12)
    assert newmark.order == 2 and newmark.limit is None
    assert spectra["ga:0.8"]["radius"][-1] == pytest.approx(0.8, rel=1e-4)
    with pytest.raises(ValueError, match="not a range"):
        pb.spectrum(["newmark"], from_=1.0, to=0.1)
    with pytest.raises(KeyError, match="there is no number"):
        newmark["size"]
