#!/usr/bin/env python3
"""Animation of a hampm result: particles, mesh and cracks in all snapshots, as a GIF, or as an MP4 where there is ffmpeg; or of one of its modes."""

from in_package import hand_over

hand_over(__name__, __file__)
