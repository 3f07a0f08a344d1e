"""Pictures of solids: their surface in a parallel projection, or what a plane across an axis cuts, coloured by a field of the particles."""

from in_package import hand_over

hand_over(__name__, __file__)
