"""A valid scene, one key a line, from which the tests make others by replacing text."""

GOOD = """\
&run
  title = 'beam'
  plane = 'stress'
  thickness = 0.01
  end_time = 1.5e-3
/
&grid
  lower = 0.0, 0.0
  cell = 1.25e-3
  cells = 80, 9
/
&material
  name = 'aluminium'
  law = 'linear_elastic'
  young = 70e9
  poisson = 0.3
  density = 2700
/
&body
  material = 'aluminium'
  shape = 'rectangle'
  lower = 0.0, 0.0
  upper = 0.1, 0.01
  points_per_cell = 2
  velocity = 0.0, 0.0
/
&constraint
  lower = 0.05, 0.0
  upper = 0.1, 0.0
  fix = 'y'
/
&load
  kind = 'traction'
  lower = 0.0, 0.0
  upper = 0.0, 0.01
  force = 0.0, 1.0
  history = 'step'
/
&damping
  rate = 1e4
/
&method
  scheme = 'musl'
  courant = 0.1
  wave_speed = 'shear'
  frame = 'updated'
/
&crack
  kind = 'symmetry'
  tip = 0.05, 0.0
  direction = 1.0, 0.0
/
&energy_release
  estimators = 'vcct', 'stress_closure'
  reference = 'dcb'
/
&output
  file = 'beam.h5'
  history_interval = 1e-6
  snapshot_interval = 1e-4
/
"""

REFINE = """\
&refine
  indicator = 'gradient'
  field = 'energy_density'
  r_crit = 0.03
  r_coarsen = 0.0
  tolerance = 0.02
  rings = 4
  max_level = 4
  energy_floor = 1e-3
  region_lower = 0.04, 0.0
  region_upper = 0.06, 0.01
  interval = 10
  max_particles = 1000000
/
"""


def changed(*replacements, scene=GOOD):
    """A scene after replacements `(old, new)`, each of which must apply at exactly one place."""
    text = scene
    for old, new in replacements:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the scene"
        text = text.replace(old, new)
    return text


def line_of(text, fragment):
    """Number of the first line that holds a fragment."""
    return text[: text.index(fragment)].count("\n") + 1


# The good scene as a whole beam, with the crack inside it.
LINE = changed(
    ("upper = 0.1, 0.01\n  points", "upper = 0.1, 0.02\n  points"),
    ("cells = 80, 9", "cells = 80, 17"),
    ("&constraint\n  lower = 0.05, 0.0\n  upper = 0.1, 0.0\n  fix = 'y'\n/\n", ""),
    ("kind = 'symmetry'\n  tip = 0.05, 0.0\n", "kind = 'line'\n  tip = 0.05, 0.01\n  length = 0.0\n  contact = 'none'\n"),
    ("'stress_closure'\n  reference = 'dcb'", "'domain_integral'\n  radii = 4e-3, 6e-3, 8e-3"),
)
