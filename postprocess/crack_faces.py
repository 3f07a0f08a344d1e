"""Cracks in pictures of particles: what of the material around a particle is on its side of them, and faces that move with it."""

from in_package import hand_over

hand_over(__name__, __file__)
