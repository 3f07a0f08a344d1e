#!/usr/bin/env python3
"""Work-precision diagrams of a table of runs: how small the error gets for what cost, and which settings are worth it."""

from in_package import hand_over

hand_over(__name__, __file__)
