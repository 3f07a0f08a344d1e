#!/usr/bin/env python3
"""Picture of the dynamic energy release rate G(t)/G_ref, or of other columns over time or over each other, of one or more hampm results."""

from in_package import hand_over

hand_over(__name__, __file__)
