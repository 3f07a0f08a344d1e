#!/usr/bin/env python3
"""Static energy release rate by virtual extension of the crack, to check the estimators of a run against."""

from in_package import hand_over

hand_over(__name__, __file__)
