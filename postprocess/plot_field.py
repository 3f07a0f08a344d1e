#!/usr/bin/env python3
"""Picture of the particles of snapshots coloured by a field, with the mesh and the crack: a panel for each file and time."""

from in_package import hand_over

hand_over(__name__, __file__)
