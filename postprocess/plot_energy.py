#!/usr/bin/env python3
"""Picture of where the energy of one or more hampm runs goes over time, and of how the balance closes: a column for each file."""

from in_package import hand_over

hand_over(__name__, __file__)
