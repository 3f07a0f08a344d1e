"""Particles coloured by a field, on the mesh: what still and moving pictures of snapshots share."""

from in_package import hand_over

hand_over(__name__, __file__)
