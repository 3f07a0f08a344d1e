#!/usr/bin/env python3
"""Study of convergence from the table of a sweep: errors, observed orders, extrapolated values, and what accuracy costs."""

from in_package import hand_over

hand_over(__name__, __file__)
