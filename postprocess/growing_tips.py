"""How cracks grow, as the history of a run has it: where each tip is, how fast, under which G and with which toughness."""

from in_package import hand_over

hand_over(__name__, __file__)
