"""Fields of the particles that colour a picture: those that snapshots hold, and those that follow from them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import ResultError
from ..snapshots import Block
from ..stored_model import StoredModel
from .frames import Frames, Leaves

STORED_UNITS = {"energy_density": "J/m³", "stress_xx": "Pa", "stress_yy": "Pa", "stress_xy": "Pa", "stress_zz": "Pa", "stress_xz": "Pa",
                "stress_yz": "Pa"}

SYMBOLS = {"stress": r"\sigma", "velocity": "v", "displacement": "u"}


class ParticleField:
    """A field of the particles of one result, by name.

    unit      as text, '1' where there is none
    words     name for a picture
    is_odd    whether the image in a plane of symmetry has the other sign
    """

    def __init__(self, result: Frames, name: str) -> None:
        self.result, self.name = result, name
        self.unit = DERIVED[name][0] if name in DERIVED else STORED_UNITS.get(name, "1")
        self.is_odd = name == "stress_xy"

    def is_odd_across(self, axis: int) -> bool:
        """The same for a plane across an axis, by its number, of a solid."""
        return self.name.startswith("stress_") and self.name[-2:].count("xyz"[axis]) == 1

    @property
    def words(self) -> str:
        return words_of(self.name)

    def values(self, particles: Block, leaves: Leaves) -> Array:
        """The field at the particles of a snapshot; `leaves` are its cells."""
        if self.name in DERIVED:
            return DERIVED[self.name][1](self.result, particles, leaves)
        stored = [name for name, values in particles.point_fields.items() if values.ndim == 1]
        if self.name not in stored:
            raise ResultError(f"{self.result.path}: the particles have no field '{self.name}'; "
                              f"they have {', '.join([*stored, *DERIVED])}")
        return particles.point_fields[self.name]


def words_of(field: str) -> str:
    """A field as pictures name it, with its symbol where it has one."""
    name, _, axes = field.rpartition("_")
    if name in SYMBOLS and set(axes) <= set("xyz"):
        return f"{name} ${SYMBOLS[name]}_{{{axes}}}$"
    return "von Mises stress" if field == "von_mises" else field.replace("_", " ")


def speed(_: Any, particles: Block, __: Any) -> Array:
    return np.linalg.norm(particles.point_fields["velocity"], axis=1)


def displacement(_: Any, particles: Block, __: Any) -> Array:
    return np.linalg.norm(particles.point_fields["displacement"], axis=1)


def level(result: Frames, particles: Block, leaves: Leaves) -> Array:
    """How often the cell of each particle has been divided."""
    cell = result.cells_of(particles, leaves)
    return np.where(cell >= 0, leaves.level[cell], 0)


def mean_stress(result: Frames, particles: Block, _: Any) -> Array:
    """A third of the trace of the stress."""
    xx, yy, zz, *_ = stresses(result, particles)
    return (xx + yy + zz) / 3


def von_mises(result: Frames, particles: Block, _: Any) -> Array:
    """The equivalent stress of von Mises."""
    xx, yy, zz, *shear = stresses(result, particles)
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * sum(of**2 for of in shear))


DERIVED = {"speed": ("m/s", speed), "displacement": ("m", displacement), "level": ("1", level),
           "mean_stress": ("Pa", mean_stress), "von_mises": ("Pa", von_mises)}


def stresses(result: Frames, particles: Block) -> tuple[Array, ...]:
    """Components xx, yy, zz, xy and of a solid xz, yz of the stress [Pa]. Around an axis zz is stored, in plane strain it is that of linear elasticity."""
    xx, yy, xy = (particles.point_fields[f"stress_{name}"] for name in ("xx", "yy", "xy"))
    if "stress_xz" in particles.point_fields:
        return xx, yy, *(particles.point_fields[f"stress_{name}"] for name in ("zz", "xy", "xz", "yz"))
    if "stress_zz" in particles.point_fields:
        return xx, yy, particles.point_fields["stress_zz"], xy
    if result.scene.text("run", "plane") == "stress":
        return xx, yy, np.zeros_like(xx), xy
    return xx, yy, poisson_ratios(result.scene)[particles.point_fields["body"].astype(int) - 1] * (xx + yy), xy


def poisson_ratios(scene: StoredModel) -> Array:
    """Poisson's ratio of each body; an error where one is not linear elastic."""
    number = {scene.text("material", "name", n): n for n in range(1, scene.count("material") + 1)}
    materials = [number[scene.text("body", "material", n)] for n in scene.body_groups()]
    strained = any(any(scene.numbers("body", "eigenstrain", n)) for n in scene.body_groups())
    if strained or any(scene.text("material", "law", n) != "linear_elastic" for n in materials):
        raise ResultError(f"{scene.path}: in plane strain the stress normal to the plane is known of linear elastic bodies without eigenstrain alone")
    return np.array([scene.numbers("material", "poisson", n)[0] for n in materials])
