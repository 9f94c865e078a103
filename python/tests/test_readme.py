"""The examples of the README."""

import os
import re
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1]


def test_the_examples_run(monkeypatch):
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib").use("Agg")
    pytest.importorskip("scipy")
    monkeypatch.chdir(HERE.parent)
    examples = re.findall(r"```python\n(.*?)```", (HERE / "README.md").read_text(), re.S)
    assert len(examples) == 5
    names: dict = {}
    for example in examples:
        exec(example, names)
    assert names["result"].complete and os.getcwd() == str(HERE.parent)
