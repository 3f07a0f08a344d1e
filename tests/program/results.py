"""What the tests of the program ask of result files."""

import h5py
import numpy as np


def datasets(path):
    """All values under /history and /VTKHDF, by name: what two runs of one scene must agree in."""
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


def run(hampm, folder, text, *options, code=0, name="out"):
    """Run a scene: the columns of its history and, of its last snapshot, positions `x`, `displacement`, `velocity` and `stress` of the particles; what is
    said instead where another code than 0 is due."""
    (folder / f"{name}.nml").write_text(text)
    result = hampm(f"{name}.nml", "--force", "--quiet", *options)
    assert result.returncode == code, result.stderr
    if code:
        return result.stderr
    with h5py.File(folder / f"{name}.h5") as file:
        row = {column: values[:] for column, values in file["history"].items()}
        if "VTKHDF/particles" in file:
            data = file["VTKHDF/particles"]
            n = data["NumberOfPoints"][-1]
            row["x"] = data["Points"][-n:, :2]
            row |= {field: data["PointData"][field][-n:, :2] for field in ("displacement", "velocity")}
            row["stress"] = np.array([data["PointData"]["stress_" + which][-n:].ravel() for which in ("xx", "yy", "xy")])
    return row
