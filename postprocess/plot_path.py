#!/usr/bin/env python3
"""Picture of the paths of growing cracks over mesh and stress."""

from in_package import hand_over

hand_over(__name__, __file__)
