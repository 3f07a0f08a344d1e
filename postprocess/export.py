#!/usr/bin/env python3
"""Write the history of a hampm result as text, time and the columns asked for, in full precision."""

from in_package import hand_over

hand_over(__name__, __file__)
