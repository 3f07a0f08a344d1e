"""The snapshots of a run, as its result file holds them: particles and mesh at every time, and the scene of the run."""

from in_package import hand_over

hand_over(__name__, __file__)
