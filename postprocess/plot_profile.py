#!/usr/bin/env python3
"""Picture of a field along a line through snapshots of one or more hampm results, such as a wave along a bar."""

from in_package import hand_over

hand_over(__name__, __file__)
