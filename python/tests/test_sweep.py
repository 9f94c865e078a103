"""Sweeps in threads, and on the workers of Dask."""

import os
import resource
import signal
import threading

import numpy as np
import pullback as pb
import pytest
from test_model import CANTILEVER

STIFFNESS = "sections.rod.stiffness.EI.0"
FORCE = "loads.0.force.2"


def exact(force, stiffness):
    return force * (8 / (3 * stiffness) + 2 / 5e5)


def test_all_combinations():
    model = pb.Model.from_toml(CANTILEVER)
    over = {STIFFNESS: np.linspace(1, 3, 5), FORCE: [1e-4, 2e-4]}
    table = pb.sweep(model, over, keep=["last", "max"], workers=2)
    assert len(table) == 10 and set(table["outcome"]) == {"complete"}
    assert table["tip.z.last"] == pytest.approx(exact(table[FORCE], table[STIFFNESS]), rel=1e-6)
    one = pb.sweep(model, over, keep=["last", "max"], workers=1)
    for name in set(table.columns) - {"seconds"}:
        assert np.array_equal(one[name], table[name])
    pandas = pytest.importorskip("pandas")
    assert isinstance(table.frame(), pandas.DataFrame)


def test_failures_are_rows():
    model = pb.Model.from_toml(CANTILEVER)
    table = pb.sweep(model, {"lines.beam.elements": iter([1, 0, 2])})
    assert list(table["outcome"] == "complete") == [True, False, True]
    assert "out of range" in table["outcome"][1] and np.isnan(table["tip.z.last"][1])
    with pytest.raises(pb.ModelError, match="did you mean `elements`"):
        pb.sweep(model, {"lines.beam.element": [1]})
    with pytest.raises(ValueError, match="last, max, min"):
        pb.sweep(model, {"lines.beam.elements": [1]}, keep=["mean"])
    with pytest.raises(KeyError, match="outcome"):
        table["result"]


def test_a_stopped_sweep_goes_on(tmp_path):
    """Ctrl-C keeps the rows, in memory and in sweep.csv, and the same call makes the missing runs alone."""
    model = pb.Model.from_toml(CANTILEVER)
    over = {FORCE: [1e-4], STIFFNESS: list(np.linspace(1, 3, 6000))}
    interrupt = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    interrupt.start()
    with pytest.raises(KeyboardInterrupt) as raised:
        pb.sweep(model, over, out=tmp_path / "sweep", workers=2)
    interrupt.join()
    before = raised.value.result
    assert 0 < len(before) < 6000
    table = pb.sweep(model, over, out=tmp_path / "sweep", workers=2)
    assert list(table["run"]) == list(range(6000))
    assert table["tip.z.last"] == pytest.approx(exact(1e-4, table[STIFFNESS]), rel=1e-6)
    runs = before["run"]
    assert np.array_equal(table["seconds"][runs], before["seconds"]), "their runs are not made again"
    lines = (tmp_path / "sweep" / "sweep.csv").read_text().splitlines()
    assert len(lines) == 6001
    with pytest.raises(ValueError, match="holds another sweep"):
        pb.sweep(model, {STIFFNESS: [1.0]}, out=tmp_path / "sweep")


def test_a_full_disk_keeps_the_rows(tmp_path):
    """A limit of the size of files stands for it."""
    model = pb.Model.from_toml(CANTILEVER)
    over = {STIFFNESS: list(np.linspace(1, 3, 1000))}
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, before[1]))
    try:
        with pytest.raises(OSError) as raised:
            pb.sweep(model, over, out=tmp_path / "sweep")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert len(raised.value.result) > 0
    assert len(pb.sweep(model, over, out=tmp_path / "sweep")) == 1000


def test_a_lost_worker_is_replaced(tmp_path):
    distributed = pytest.importorskip("distributed")
    model = pb.Model.from_toml(CANTILEVER)
    over = {STIFFNESS: list(np.linspace(1, 3, 5000))}
    here = pb.sweep(model, over)
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = list(client.run(os.getpid).values())
        killer = threading.Timer(0.2, os.kill, (pids[0], signal.SIGKILL))
        killer.start()
        there = pb.sweep(model, over, client=client, out=tmp_path / "sweep")
        killer.join()
        assert pids[0] not in client.run(os.getpid).values()
    assert np.array_equal(here["tip.z.last"], there["tip.z.last"])
