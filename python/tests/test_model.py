"""Models: texts, dictionaries, parameters, refusals."""

import inspect
import pickle
import textwrap
from pathlib import Path

import numpy as np
import pullback as pb
import pytest

CANTILEVER = """
[sections.rod]
stiffness = { EA = 1e6, GA = [4e5, 5e5], GJ = 1.0, EI = [2.0, 3.0] }
[nodes]
root = [0, 0, 0]
tip = [2, 0, 0]
[[lines]]
name = "beam"
from = "root"
to = "tip"
elements = 4
order = 2
section = "rod"
[[supports]]
node = "root"
fix = "all"
[[loads]]
node = "tip"
force = [0, 0, 1e-3]
[[probes]]
name = "tip"
quantity = "displacement"
node = "tip"
[[probes]]
name = "energy"
quantity = "strain_energy"
"""


def builder() -> pb.ModelBuilder:
    m = pb.ModelBuilder()
    m.section("rod", stiffness={"EA": 1e6, "GA": [4e5, 5e5], "GJ": 1.0, "EI": [2.0, 3.0]})
    m.node("root", [0, 0, 0])
    m.node("tip", np.array([2.0, 0.0, 0.0]))
    m.line("beam", from_="root", to="tip", elements=4, order=2, section="rod")
    m.support(node="root", fix="all")
    m.load(node="tip", force=[0, 0, 1e-3])
    m.probe("tip", "displacement", node="tip")
    m.probe("energy", "strain_energy")
    return m


def test_the_example_of_the_builder_builds():
    lines = inspect.getdoc(pb.ModelBuilder).splitlines()
    names = {"pb": pb}
    exec(textwrap.dedent("\n".join(line for line in lines if line.startswith("    "))), names)
    assert isinstance(names["model"], pb.Model)


def test_a_name_is_given_once():
    m = builder()
    with pytest.raises(ValueError, match="nodes has 'tip' already"):
        m.node("tip", [1, 0, 0])


def test_names_and_titles_of_any_characters():
    title, name = 'a "title" \\', "tip \U0001f600"
    m = pb.ModelBuilder(title)
    m.node(name, [1, 0, 0])
    m.body(name="bob", node=name, mass=2.0, inertia=[1, 1, 1])
    m.analysis("dynamic", to=1.0, step=0.1)
    model = m.build()
    assert model.title == title
    assert name in pb.Simulation(model).poses()


def test_a_small_deflection_is_that_of_timoshenko():
    """w = P L³/3EI + P L/GA, and half the work of the force is strain energy."""
    force = 1e-3
    exact = force * (8 / (3 * 2.0) + 2 / 5e5)
    for model in (pb.Model.from_toml(CANTILEVER), builder().build()):
        result = model.run()
        assert result.complete and result.parameter == "load parameter"
        assert result["tip"].shape == (len(result.t), 3)
        assert result["tip"][-1, 2] == pytest.approx(exact, rel=1e-6)
        assert result["energy"][-1] == pytest.approx(force * exact / 2, rel=1e-6)
        assert result.position("tip")[-1] == pytest.approx([2, 0, exact], rel=1e-6, abs=1e-12)
        assert result.positions.shape == (len(result.t), len(result.nodes), 3)
        assert result.rotation("root") == pytest.approx(0)


def test_other_parameters():
    model = pb.Model.from_toml(CANTILEVER)
    double = model.with_({"loads.0.force.2": 2e-3, "sections.rod.stiffness.EI": np.array([4.0, 3.0])})
    exact = 2e-3 * (8 / (3 * 4.0) + 2 / 5e5)
    assert double.run()["tip.z"][-1] == pytest.approx(exact, rel=1e-6)
    assert "EI = [4.0, 3.0]" in double.to_toml()


def test_a_model_is_a_value():
    model = pb.Model.from_toml(CANTILEVER)
    copy = pickle.loads(pickle.dumps(model))
    assert copy == model and hash(copy) == hash(model)
    assert copy != model.with_({"loads.0.force.2": 1})
    assert np.array_equal(copy.run()["tip"], model.run()["tip"])


def test_a_model_of_another_version_is_refused_by_name(monkeypatch):
    model = pb.Model.from_toml(CANTILEVER)
    model._text += "[novelties]\n"
    monkeypatch.setattr(pb, "__version__", "99.0.0")
    later = pickle.dumps(model)
    monkeypatch.undo()
    with pytest.raises(pb.ModelError, match=f"by pullback 99.0.0, read by {pb.__version__}: (?s:.*)novelties"):
        pickle.loads(later)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (CANTILEVER.replace('to = "tip"', 'to = "tap"'), "did you mean `tip`?"),
        (CANTILEVER.replace("elements = 4", "elements = 0"), "elements = 0 is out of range"),
        ("nodes = 3", "model:1:9"),
        ("", "the model file is empty"),
    ],
)
def test_a_refusal_has_the_line_and_the_cure(text, said):
    with pytest.raises(pb.ModelError, match=".*") as refused:
        pb.Model.from_toml(text)
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("loads.1.force", "loads has no 1"),
        ("nodes.tap", "did you mean `tip`?"),
        ("lines.beam.element", "did you mean `elements`?"),
        ("a..b", "is not the path of a parameter"),
    ],
)
def test_unknown_parameters_are_refused(path, said):
    with pytest.raises(pb.ModelError) as refused:
        pb.Model.from_toml(CANTILEVER).with_({path: 1})
    assert said in str(refused.value)


def test_bad_values():
    model = pb.Model.from_toml(CANTILEVER)
    with pytest.raises(pb.ModelError):
        model.with_({"loads.0.force": [0, 0]})
    with pytest.raises(pb.ModelError):
        model.with_({"loads.0.force.2": float("nan")})
    with pytest.raises(TypeError):
        model.with_({"loads.0.force": object()})
    bad = builder()
    bad.load(node="tip", force=[0, 0, float("inf")])
    with pytest.raises(pb.ModelError):
        bad.build()
    with pytest.raises(KeyError, match="tip"):
        model.run()["tap"]
    with pytest.raises(KeyError, match="root"):
        model.run().position("tap")


def test_an_analysis_without_end_keeps_what_has_converged():
    path = "[analysis.arc_length]\nmax_steps = 3\nstop = [{ load = 1e9 }]\n"
    model = pb.Model.from_toml(CANTILEVER + path)
    with pytest.raises(pb.AnalysisError, match="max_steps = 3") as failed:
        model.run()
    result = failed.value.result
    assert result.ending == "step_limit" and len(result.t) == 4
    assert result["tip.z"][-1] > 0
    assert model.run(check=False).message == str(failed.value)


def test_check_and_schema():
    rows = pb.Model.from_toml(CANTILEVER).check()
    assert {"component", "property"} <= set(rows[0])
    assert "lines" in pb.schema()["properties"]


def test_files(tmp_path):
    pb.Model.from_toml(CANTILEVER).write(tmp_path / "out")
    assert (tmp_path / "out" / "history.csv").read_text().startswith("row,step,event,t")
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match="it is a file"):
        pb.Model.from_toml(CANTILEVER).write(tmp_path / "file")


def test_probes_are_found_by_their_names():
    norm = '[[probes]]\nname = "tip.norm"\nquantity = "displacement"\nnode = "tip"\ncomponent = "norm"\n'
    result = pb.Model.from_toml(CANTILEVER + norm).run()
    assert np.linalg.norm(result["tip"], axis=1) == pytest.approx(result["tip.norm"])
    assert "tip" in result and "tip.x" in result
    assert "t" in result and "tip.w" not in result


def test_tables_and_figures():
    pytest.importorskip("pandas")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    result = pb.Model.from_toml(CANTILEVER).run()
    assert list(result.frame()["tip.z"]) == list(result["tip.z"])
    assert len(result.plot("tip", "energy").axes) == 2
    assert len(result.plot().axes) == 4
    animation = result.animate()
    animation._draw_frame(0)
    animation.to_jshtml()


def test_arrays_are_those_of_the_call():
    m, position = pb.ModelBuilder(), np.array([0.0, 1.0, 2.0])
    m.node("far", position)
    position[:] = 9
    assert "far = [0.0, 1.0, 2.0]" in m.to_toml()
    result = builder().build().run()
    for values in (result.t, result.positions, result["strain_energy"]):
        with pytest.raises(ValueError, match="read-only"):
            values *= 2


def test_models_of_two_places_differ():
    """Files that a text names are found from where its own is."""
    here, there = (pb.Model.from_toml(CANTILEVER, name) for name in ("a/model.toml", "b/model.toml"))
    assert here != there and len({here, there}) == 2


SUPPORT = '[[supports]]\nnode = "tip"\nfix = "all"\n[[loads]]'


def test_equations_of_motion_are_told_of():
    held = CANTILEVER.replace("elements = 4\norder = 2", "elements = 1").replace("[[loads]]", SUPPORT)
    with pytest.raises(pb.AnalysisError, match="nothing in the model is free") as error:
        pb.Model.from_toml(held).linearize()
    assert error.value.result is None
    swing = pb.Model.from_file(Path(__file__).parents[2] / "examples/models/pendulum.toml")
    with pytest.warns(UserWarning, match="the state moves"):
        swing.linearize(at=1.0)
