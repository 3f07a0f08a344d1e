"""What all pictures share: their look, the options for the file that is written, and words for files and units."""

from in_package import hand_over

hand_over(__name__, __file__)
