"""The folder mode of compare.py: the results of two folders, case by case, with tolerances for cases and columns from a YAML file."""

from in_package import hand_over

hand_over(__name__, __file__)
