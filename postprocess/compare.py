#!/usr/bin/env python3
"""Compare the histories of two hampm results, column by column."""

from in_package import hand_over

hand_over(__name__, __file__)
