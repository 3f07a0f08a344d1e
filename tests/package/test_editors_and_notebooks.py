"""The page of Python on editors and notebooks: its notebook runs in a kernel, and its model in YAML is the one of the namelist."""

import re
import shutil

import pytest

import hampm as package
from paths import INPUT, PACKAGE, PROGRAM, ROOT

BLOCKS = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/how-to/python.md").read_text(), re.MULTILINE | re.DOTALL)


def test_a_model_in_yaml_is_a_scene(tmp_path, monkeypatch, plate):
    yaml = pytest.importorskip("yaml")
    groups = {}
    for group in plate._written():
        groups.setdefault(group._name, []).append(dict(group.items()))
    (tmp_path / "plate.model.yaml").write_text(yaml.safe_dump({name: of if len(of) > 1 else of[0] for name, of in groups.items()}, sort_keys=False))
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(next(block for block in BLOCKS if "yaml.safe_load" in block), names)
    assert names["model"] == plate and names["model"].mistakes() == []


def test_messages_name_the_cell_of_a_notebook(plate):
    names = {"plate": plate, "In": ["", "import hampm", "plate.run.title = 'a'"]}
    exec(compile("plate.run.title = 'a'\nplate.grid.cell = -1.0", "/tmp/ipykernel_71/2349.py", "exec"), names)
    with pytest.raises(package.ModelError, match=re.escape("In [2]:2: &grid cell")):
        plate.check()


@pytest.mark.verify
def test_the_notebook_runs(tmp_path, monkeypatch):
    """Twenty cases, of which K rises with the length of the crack; a figure of a column of a paper; tables by a pool; the shape factor of a strip with an
    edge crack, at a/W = 0.4 by Tada, Paris & Irwin (2000), p. 2.11, within 0.5 %, and as much for the cells."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    (tmp_path / "input").mkdir()
    shutil.copy(INPUT / "edge_crack.nml", tmp_path / "input")
    monkeypatch.setenv("HAMPM", str(PROGRAM))
    monkeypatch.setenv("PYTHONPATH", str(PACKAGE))
    shown = "assert len(by_length) == len(largest) == 20 and (by_length.K_I.unstack('a').diff(axis=1).iloc[:, 1:] > 0).all(axis=None), by_length"
    shown += "\nassert len(tables) == 20 and all('K_I' in str(table) for table in tables), tables\nassert abs(shape(0.4) / 2.1064 - 1) < 0.01, shape(0.4)"
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in (next(block for block in BLOCKS if "results/twenty" in block), "by_length.K_I.unstack('a')", "cases", shown, "figure")])
    nbclient.NotebookClient(notebook, timeout=500, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert (tmp_path / "J.pdf").read_bytes().startswith(b"%PDF")
    tables = [output.data.get("text/html", "") for cell in notebook.cells[1:3] for output in cell.outputs]
    assert len(tables) == 2 and all("<table" in table for table in tables) and "image/png" in notebook.cells[4].outputs[0].data
