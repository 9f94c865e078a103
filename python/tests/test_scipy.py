"""Motions and modes against SciPy."""

import subprocess
import sys

import numpy as np
import pullback as pb
import pytest

scipy = pytest.importorskip("scipy")
from scipy.integrate import solve_ivp  # noqa: E402
from scipy.io import mmread  # noqa: E402
from scipy.sparse.linalg import eigsh  # noqa: E402

G = 9.81


def pendulum(links: int, angles: list[float], **analysis) -> pb.Model:
    """Point masses of 1 kg on rigid bars of 1 m, which turn about the axis y; angles to the bar before."""
    m = pb.ModelBuilder()
    m.node("ground", [0, 0, 0])
    m.support(node="ground", fix="all")
    parent = "ground"
    for k, angle in enumerate(angles):
        m.joint("revolute", name=f"pivot{k}", parent=parent, axis=[0, 1, 0], value=angle)
        m.joint("offset", name=f"bob{k}", parent=f"pivot{k}", position=[0, 0, -(k + 1)])
        m.body(name=f"mass{k}", node=f"bob{k}", mass=1.0)
        m.probe(f"angle{k}", "joint_coordinate", joint=f"pivot{k}")
        m.probe(f"rate{k}", "joint_rate", joint=f"pivot{k}")
        parent = f"bob{k}"
    m.load(gravity=[0, 0, -G])
    m.analysis("dynamic", **analysis)
    return m.build()


def test_a_pendulum():
    model = pendulum(1, [2.0], to=3, step=0.001, scheme="tsitouras")
    result = model.run()
    exact = solve_ivp(
        lambda _, y: [y[1], -G * np.sin(y[0])], [0, 3], [2.0, 0], t_eval=result.t[1:], rtol=1e-12, atol=1e-12
    )
    assert result["angle0"][1:] == pytest.approx(exact.y[0], abs=1e-8)


def test_a_double_pendulum():
    """Lagrange's equations of two equal masses on equal bars, absolute angles."""

    def rates(_, y):
        a, b, u, v = y
        c, s = np.cos(a - b), np.sin(a - b)
        mass = np.array([[2, c], [c, 1]])
        force = [-(v**2) * s - 2 * G * np.sin(a), u**2 * s - G * np.sin(b)]
        return [u, v, *np.linalg.solve(mass, force)]

    result = pendulum(2, [1.0, 0.5], to=2, step=0.001, scheme="tsitouras").run()
    exact = solve_ivp(rates, [0, 2], [1.0, 1.5, 0, 0], t_eval=result.t[1:], rtol=1e-12, atol=1e-12)
    assert result["angle0"][1:] == pytest.approx(exact.y[0], abs=1e-8)
    assert (result["angle0"] + result["angle1"])[1:] == pytest.approx(exact.y[1], abs=1e-8)


BEAM = """
[sections.rod]
stiffness = { EA = 1e4, GA = [4e3, 4e3], GJ = 2.0, EI = [2.0, 3.0] }
mass = { A_rho = 1.0, J = [2e-3, 1e-3, 1e-3] }
[nodes]
root = [0, 0, 0]
tip = [2, 0, 0]
[[lines]]
name = "beam"
from = "root"
to = "tip"
elements = 20
order = 2
section = "rod"
[[supports]]
node = "root"
fix = "all"
[[loads]]
node = "tip"
force = [0.3, 0, 0.2]
"""


def test_modes_of_matrices():
    """K φ = ω² M φ by ARPACK, about a bent beam."""
    model = pb.Model.from_toml(BEAM)
    lin = model.linearize()
    assert abs(lin.K - lin.K.T).max() < 1e-9 * abs(lin.K).max()
    squares = eigsh(lin.K, 8, lin.M, sigma=0, return_eigenvectors=False)
    modes = model.modes(8)
    assert modes.frequencies == pytest.approx(np.sqrt(np.sort(squares)) / (2 * np.pi), rel=1e-9)
    for k, frequency in enumerate(modes.frequencies):
        shape, square = modes.shapes[:, k], (2 * np.pi * frequency) ** 2
        assert np.linalg.norm(lin.K @ shape - square * (lin.M @ shape)) < 1e-7 * np.linalg.norm(
            lin.K @ shape
        )


def test_the_program_writes_matrices_that_scipy_reads(tmp_path):
    (tmp_path / "beam.toml").write_text(BEAM)
    subprocess.run([sys.executable, "-m", "pullback", "linearize", "beam.toml"], cwd=tmp_path, check=True)
    K, M = (mmread(tmp_path / f"beam.linear/{name}.mtx").tocsc() for name in "KM")
    lin = pb.Model.from_toml(BEAM).linearize()
    assert abs(K - lin.K).max() == 0 and abs(M - lin.M).max() == 0
    names = (tmp_path / "beam.linear/coordinates.txt").read_text().splitlines()
    assert names == lin.coordinates
