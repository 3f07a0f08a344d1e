"""Keys of models, and columns and attributes of results, of versions 1 and 2 by the names that they have now."""

ESTIMATORS = {"nodal_force": "vcct", "crack_closure": "domain_integral", "series_fit": "domain_integral"}
COLUMNS = {
    **{f"G_{old}_{mode}{error}": f"G_{new.removesuffix('_integral')}_{mode}{error}" for old, new in ESTIMATORS.items()
       for mode in ("I", "II") for error in ("", "_error")},
    "J_spread": "J_domain_dependence",
}
ATTRIBUTES = {"distance_from_rest": "distance_to_equilibrium"}
KEYS = {
    ("material", "dilatation"): "volumetric",
    ("material", "kinematic"): "kinematic_hardening",
    ("body", "part"): "contact_group",
    ("constraint", "push_only"): "unilateral",
    ("method", "functions"): "shape_functions",
    ("method", "blend"): "lumped_fraction",
    ("method", "full_region"): "consistent_region",
    ("method", "full_lower"): "consistent_lower",
    ("method", "full_upper"): "consistent_upper",
}
REMOVED = {("method", "time_steps"): "version 3 has one step for all cells"}


def column(name: str) -> str:
    """The name that a column or an attribute has now."""
    base, tip, number = name.partition("_tip")
    return ATTRIBUTES.get(name, COLUMNS.get(base, base) + tip + number)


def new_key(group: str, key: str) -> str:
    """The name that a key has now."""
    return KEYS.get((group, key), key)
