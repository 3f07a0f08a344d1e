"""What the tests of the program ask of two result files."""

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
