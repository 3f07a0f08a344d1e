"""Sweeps: what one declares, its cases, each in its folder, and the table of them. `hampm.Sweep` and the scripts of `batch/` are over this."""
