#!/usr/bin/env python3
"""Sketch of a model before any run: its bodies, cracks, supports and loads, as hampm understands the namelist."""

from in_package import hand_over

hand_over(__name__, __file__)
