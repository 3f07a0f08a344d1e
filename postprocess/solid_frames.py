"""Snapshots of solids: the cubes of their material and of their cells, the sides of these that nothing covers, and what a plane cuts."""

from in_package import hand_over

hand_over(__name__, __file__)
