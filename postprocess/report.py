#!/usr/bin/env python3
"""Report of one or more hampm runs as one HTML file that needs no other: results, pictures and the scene as it was used."""

from in_package import hand_over

hand_over(__name__, __file__)
