"""How far the paths of cracks are from each other."""

from in_package import hand_over

hand_over(__name__, __file__)
