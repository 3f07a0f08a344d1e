#!/usr/bin/env python3
"""Energy release rate and stress intensity factors along the front of a crack in a solid."""

from in_package import hand_over

hand_over(__name__, __file__)
