#!/usr/bin/env python3
"""Table of the last values of columns of one or more hampm results, such as energy release rates at rest."""

from in_package import hand_over

hand_over(__name__, __file__)
