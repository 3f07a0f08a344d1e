#!/usr/bin/env python3
"""Extrapolate results on cells of different sizes to cells of size zero."""

from in_package import hand_over

hand_over(__name__, __file__)
