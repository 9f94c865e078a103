"""Motions step by step, with inputs, copies and interrupts."""

import os
import signal
import threading
import time

import numpy as np
import pullback as pb
import pytest


def arm(to: float = 4.0) -> pb.Model:
    """A bar of 1 m on a motor whose torque is an input, horizontal at the start."""
    m = pb.ModelBuilder("An arm")
    m.node("ground", [0, 0, 0])
    m.support(node="ground", fix="all")
    m.input("torque")
    m.joint("revolute", name="motor", parent="ground", axis=[0, 1, 0], actuator={"input": "torque"})
    m.body(name="bar", node="motor", mass=1.0, center=[0.5, 0, 0], inertia=[0, 1 / 12, 1 / 12])
    m.load(gravity=[0, 0, -9.81])
    m.analysis("dynamic", to=to, step=0.002)
    m.probe("angle", "joint_coordinate", joint="motor")
    m.probe("rate", "joint_rate", joint="motor")
    m.probe("energy", "total_energy")
    return m.build()


def test_a_controller_holds_the_arm():
    """A PD controller with gravity compensation: I q̈ = −k (q − goal) − d q̇, critically damped."""
    goal, inertia = -0.8, 1 / 3
    k = 25 * inertia
    d = 2 * np.sqrt(k * inertia)
    sim = pb.Simulation(arm())
    for _ in sim:
        angle, rate = sim.get("angle"), sim.get("rate")
        weight = 9.81 * 0.5 * np.cos(angle)
        sim.set_input("torque", -weight - k * (angle - goal) - d * rate)
    assert sim.t == pytest.approx(4)
    assert sim.get("angle") == pytest.approx(goal, abs=1e-3)


def test_steps_are_those_of_a_run():
    model = arm(0.5)
    result = model.run()
    sim = pb.Simulation(model)
    angles, energies = [sim.get("angle")], [sim.get("energy")]
    for step in sim:
        angles.append(step.get("angle"))
        energies.append(step.get("energy"))
    assert np.array_equal(angles, result["angle"])
    assert np.array_equal(energies, result["energy"])
    assert not sim.step()
    assert np.array_equal(sim.poses()["motor"][0], [0, 0, 0])


def test_copies_repeat_to_the_last_bit():
    sim = pb.Simulation(arm())
    for _ in range(50):
        sim.step()
    saved = sim.save()
    first = [(sim.step(), sim.q[0], sim.v[0], sim.a[0])[1:] for _ in range(50)]
    sim.step(0.001)
    sim.restore(saved)
    again = [(sim.step(), sim.q[0], sim.v[0], sim.a[0])[1:] for _ in range(50)]
    assert first == again


def test_another_step_size():
    sim = pb.Simulation(arm())
    sim.step(0.01)
    sim.step()
    assert sim.t == pytest.approx(0.02)
    sim.step(0.001)
    assert sim.t == pytest.approx(0.021)
    with pytest.raises(pb.AnalysisError):
        sim.step(-1.0)


def test_wrong_names_and_values():
    sim = pb.Simulation(arm())
    with pytest.raises(KeyError, match="angle"):
        sim.get("angel")
    with pytest.raises(KeyError, match="torque"):
        sim.set_input("force", 1.0)
    with pytest.raises(ValueError, match="NaN"):
        sim.set_input("torque", float("nan"))
    static = pb.ModelBuilder()
    static.node("a", [0, 0, 0])
    static.support(node="a", fix="all")
    static.body(name="b", node="a", mass=1.0)
    static.load(gravity=[0, 0, -1])
    with pytest.raises(pb.ModelError, match="analysis.dynamic"):
        pb.Simulation(static.build())


def test_an_interrupt_keeps_what_has_converged():
    model = arm(1e5)
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt) as interrupted:
        model.run()
    assert time.monotonic() - start < 1.5
    result = interrupted.value.result
    assert result.ending == "interrupted" and len(result.t) > 10


def test_other_threads_run_meanwhile():
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    arm(40).run()
    done.set()
    thread.join()
    assert counted > 20


def test_a_simulation_warns_as_a_run():
    m = pb.ModelBuilder("A joint without mass")
    m.node("ground", [0, 0, 0])
    m.support(node="ground", fix="all")
    m.joint("revolute", name="loose", parent="ground", axis=[0, 1, 0], spring={"k": 1.0, "c": 0.1})
    m.analysis("dynamic", to=1, step=0.1)
    with pytest.warns(UserWarning, match="no mass acts on loose angle"):
        pb.Simulation(m.build())


def test_a_copy_belongs_to_its_model():
    saved = pb.Simulation(arm(1.0)).save()
    pb.Simulation(arm(1.0)).restore(saved)
    with pytest.raises(ValueError, match="another model"):
        pb.Simulation(arm(2.0)).restore(saved)
