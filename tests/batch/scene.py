"""A scene of a moment, and sweeps of it."""

FLIGHT = """\
&run end_time = 1e-3 /
&grid cell = 1.0 cells = 8, 4 /
&material name = 'soft' law = 'neo_hookean' young = 1e5 density = 1000 poisson = 0.3 /
&body material = 'soft' lower = 1.25, 1.0 upper = 2.25, 2.0 velocity = 30, 0 /
&load kind = 'body' lower = 1.0, 1.0 upper = 3.0, 2.0 force = 0, 0 /
&output history_interval = 1e-4 /
"""
MASS = 1000.0  # of the body [kg]
SLOW = "{run.end_time: 2.0, body.velocity: [0.5, 0], output.history_interval: 0.1}"
HEAD = "namelist: flight.nml\noutput: out\n"


def write_sweep(folder, text):
    """A sweep file, and the scene beside it; its path."""
    (folder / "flight.nml").write_text(FLIGHT)
    path = folder / "sweep.yaml"
    path.write_text(text)
    return path
