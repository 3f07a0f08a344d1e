"""Small result files as hampm writes them, made from formulas."""

import h5py
import numpy as np

G_REF = 12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3)
BEAM = 1.28444 * G_REF
UNITS = {"time": "s", "step": "1", "kinetic_energy": "J", "crack_opening": "m"}


def dcb(samples=1201, end=1.2e-3, factor=1.0):
    """Columns like those of a suddenly loaded DCB: G grows as the square of 1 - cos plus two higher modes."""
    t = np.linspace(0, end, samples)
    k = sum(a * (1 - np.cos(2 * np.pi * f * t)) for a, f in [(1.0, 2549.4), (0.12, 16e3), (0.04, 45e3)])
    g = factor * 1.28737 * G_REF * k * np.abs(k)
    return {
        "time": t,
        "step": np.arange(samples, dtype=np.int32),
        "kinetic_energy": 1e-6 * np.sin(2 * np.pi * 2549.4 * t) ** 2,
        "G_vcct_I": 0.99 * g,
        "G_stress_closure_I": 0.41 * g,
        "crack_opening": 1e-7 * k,
    }


ENERGIES = {"strain_energy": 0.0, "damping_loss": 0.0, "external_work": 0.0, "numerical_loss": 0.0}


def complete(**changes):
    """Columns of a run that reports may be made of; energies are constant."""
    columns = dcb(samples=101)
    return columns | {"kinetic_energy": np.ones(101)} | {name: np.full(101, value) for name, value in (ENERGIES | changes).items()}


def write_result(path, columns=None, g_ref=G_REF, beam=BEAM, distance=None):
    """Write a result file; an attribute of /history, distance_to_equilibrium among them, is left out where it is None."""
    with h5py.File(path, "w") as file:
        history = file.create_group("history")
        for name, values in (columns or dcb()).items():
            dataset = history.create_dataset(name, data=values)
            dataset.attrs["units"] = UNITS.get(name, "J/m2")
            dataset.attrs["long_name"] = name.replace("_", " ")
        for name, value in {"G_ref": g_ref, "G_beam_on_foundation": beam, "distance_to_equilibrium": distance}.items():
            if value is not None:
                history.attrs[name] = value
        file.create_group("input")["namelist"] = "&run title = 'synthetic' /\n"
    return path
