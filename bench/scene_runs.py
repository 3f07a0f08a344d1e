"""Runs of scenes that measuring scripts and tests share."""

import subprocess

import h5py


def run_scene(program, folder, text, options=(), name="case"):
    """Run a scene: its history, and the fields of the particles in its last snapshot."""
    (folder / f"{name}.nml").write_text(text)
    words = [word for option in options for word in ("--set", option)]
    result = subprocess.run([program, f"{name}.nml", "--force", "--quiet", *words], cwd=folder, capture_output=True, text=True)
    if result.returncode:
        raise RuntimeError(result.stderr)
    with h5py.File(folder / f"{name}.h5") as file:
        history = {column: values[:] for column, values in file["history"].items()}
        particles = file["VTKHDF/particles"]
        n = particles["NumberOfPoints"][-1]
        fields = {column: values[-n:].squeeze() for column, values in particles["PointData"].items()}
        fields["place"] = particles["Points"][-n:, :2]
    return history, fields
