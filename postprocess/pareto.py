"""Which settings are worth their cost: the Pareto front of measured rows, and the cheapest row of a given accuracy."""

from in_package import hand_over

hand_over(__name__, __file__)
