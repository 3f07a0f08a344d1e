"""Running a model and asking its result: what the tests of the program share."""

import re

import h5py
import numpy as np

SETTING = re.compile(r"\w+(\(\d+\))?\.\w+=", re.ASCII)


class Row(dict):
    """The columns of the history of a run, by name. Other keys, which are no columns: the attributes of /history and, of the last snapshot, positions `x`,
    `displacement`, `velocity` and `stress` of the particles. `said` is what the run has written to standard error, `path` its result."""

    def __init__(self, path, said=""):
        self.path, self.said = path, said
        with h5py.File(path) as file:
            super().__init__({name: column[:] for name, column in file["history"].items()})
            self.others = dict(file["history"].attrs)
            if "VTKHDF/particles" in file:
                data = file["VTKHDF/particles"]
                n = data["NumberOfPoints"][-1]
                self.others["x"] = data["Points"][-n:, :2]
                self.others |= {field: data["PointData"][field][-n:, :2] for field in ("displacement", "velocity") if field in data["PointData"]}
                stress = [f"stress_{which}" for which in ("xx", "yy", "xy")]
                if all(name in data["PointData"] for name in stress):
                    self.others["stress"] = np.array([data["PointData"][name][-n:].ravel() for name in stress])

    def __missing__(self, name):
        return self.others[name]

    def last(self):
        """The last value of each column."""
        return {name: column[-1] for name, column in self.items()}


def run(hampm, model, *arguments, code=0, words=(), name="out"):
    """Run a model, a text or the path of a namelist, in the folder of the test. Arguments such as `grid.cell=0.1` are those of --set, others words of the command line, as
    are `words`. Returns its row; what it said instead where another exit code than 0 is due."""
    path = model
    if not str(model).endswith(".nml"):
        path = hampm.folder / f"{name}.nml"
        path.write_text(model)
    options = [word for item in arguments for word in (("--set", item) if isinstance(item, str) and SETTING.match(item) else (item,))]
    result = hampm(path, "--force", "--quiet", "--set", f"output.file={name}.h5", *options, *words)
    assert result.returncode == code, result.stderr
    return result.stderr if code else Row(hampm.folder / f"{name}.h5", result.stderr)


def run_told(*arguments, code=0, **more):
    """Run a model: its row and what it said."""
    found = run(*arguments, code=code, **more)
    return found if code else (found, found.said)


def datasets(path):
    """All values under /history and /VTKHDF, by name: what two runs of one model must agree in."""
    found = {}
    with h5py.File(path) as file:
        for group in ("history", "VTKHDF"):
            if group in file:
                file[group].visititems(lambda name, item, group=group: found.update(
                    {f"{group}/{name}": item[()]} if isinstance(item, h5py.Dataset) else {}))
    return found


def differing(a, b):
    """Names of the datasets of two files that differ in type, shape or any byte."""
    one, two = datasets(a), datasets(b)
    assert one.keys() == two.keys()
    return [name for name, values in one.items() if not same_bytes(values, two[name])]


def same_bytes(a, b):
    a, b = np.asarray(a), np.asarray(b)
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
