#!/usr/bin/env python3
"""Picture of the mesh around the crack tip, as in the paper's Figs. 7-9, of one or more hampm results."""

from in_package import hand_over

hand_over(__name__, __file__)
