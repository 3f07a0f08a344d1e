"""Fields of the particles that colour a picture: those that snapshots hold, and those that follow from them."""

from in_package import hand_over

hand_over(__name__, __file__)
