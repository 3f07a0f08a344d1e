"""The judge's own truth: closed forms of elasticity, each by a namelist as the program reads it."""

import math
import sys

import numpy as np
import pytest

from paths import ROOT

pytest.importorskip("ngsolve")
sys.path.insert(0, str(ROOT / "tests/second_opinion"))

from opinion_compare import Answer  # noqa: E402
from opinion_mesh import build  # noqa: E402
from opinion_scene import read  # noqa: E402

ORDER = 4
E, NU, S = 200e9, 0.3, 1e6    # Young's modulus, Poisson's ratio, tension
MATERIAL = f"&material name = 'm'  young = {E}  poisson = {NU}  density = 7800 /"
ORTHOTROPIC = ("&material name = 'm'  law = 'orthotropic'  young_1 = 140e9  young_2 = 10e9  young_3 = 10e9  shear_12 = 5e9  poisson_12 = 0.3  poisson_13 = 0.3  poisson_23 = 0.4"
               "  angle = {angle}  density = 1600 /")


def model(x0, y0, x1, y1, *groups, plane="stress", cell=0.01, material=MATERIAL, body=""):
    """The text of a model: a rectangle, with what its body has more, and other groups."""
    bodies = [f"&body material = 'm'  lower = {x0}, {y0}  upper = {x1}, {y1}  {body} /"] if body is not None else []
    return "\n".join([f"&run plane = '{plane}'  end_time = 1.0 /", f"&grid lower = {x0}, {y0}  cell = {cell}  cells = {round((x1 - x0) / cell)}, {round((y1 - y0) / cell)} /",
                      material, *bodies, *groups, "&energy_release estimators = 'domain_integral' /", "&method time = 'static' /\n"])


def traction(x0, y0, x1, y1, fx, fy):
    """A force on an edge."""
    return f"&load kind = 'traction'  lower = {x0}, {y0}  upper = {x1}, {y1}  force = {fx}, {fy} /"


def plate(width, height, *groups, tension=S, **keys):
    """A plate with its middle at 0 under tension along y."""
    w, h = width / 2, height / 2
    return model(-w, -h, w, h, *(traction(-w, s * h, w, s * h, 0.0, s * tension * width) for s in (-1, 1)), *groups, **keys)


def path(*points):
    """A crack."""
    return f"&crack kind = 'path'  points = {', '.join(map(str, points))}  name = 'c' /"


def held(more="", **keys):
    """A plate between two guides, of which the upper one may be moved."""
    return model(-0.2, -0.2, 0.2, 0.2, "&constraint lower = -0.2, -0.2  upper = 0.2, -0.2  fix = 'y' /", f"&constraint lower = -0.2, 0.2  upper = 0.2, 0.2  fix = 'y'  {more} /",
                 path(-0.06, 0.01, 0.05, -0.03), **keys)


def answer(tmp_path, text):
    """What elements say of a model."""
    (tmp_path / "model.nml").write_text(text)
    scene = read(tmp_path / "model.nml")
    return {column: value for column, (_, value, *_) in Answer(scene, build(scene), ORDER).values.items()}


def sih(angle, k1, k2):
    """G of K_I and K_II in orthotropic material in plane stress, its axis 1 turned by an angle from the crack: by its compliances and roots (Sih, Paris & Irwin 1965)."""
    c, s = math.cos(angle), -math.sin(angle)    # from the axes of the material to those of the crack
    s11, s22, s12, s66 = 1 / 140e9, 1 / 10e9, -0.3 / 140e9, 1 / 5e9
    a11 = s11 * c**4 + (2 * s12 + s66) * c**2 * s**2 + s22 * s**4
    a22 = s11 * s**4 + (2 * s12 + s66) * c**2 * s**2 + s22 * c**4
    roots = [m for m in np.roots([s11, 0, 2 * s12 + s66, 0, s22]) if m.imag > 0]
    m1, m2 = ((m * c - s) / (c + m * s) for m in roots)
    return -k1 / 2 * a22 * ((k1 * (m1 + m2) + k2) / (m1 * m2)).imag + k2 / 2 * a11 * (k2 * (m1 + m2) + k1 * m1 * m2).imag


def irwin(k1, k2=0.0):
    return (k1**2 + k2**2) / E


K, TURN = S * math.sqrt(math.pi * 0.02), math.radians(30)    # of a crack of half length 0.02 in an infinite plate, and an angle
SLANTED = 0.02 * math.cos(TURN), 0.02 * math.sin(TURN)
HOLE, LAME = "&body hole = .true.  shape = 'circle'  center = 0.0, 0.0  radius = {} /", S * 0.05**2 / (0.1**2 - 0.05**2)    # of a tube of radii 0.05 and 0.1

# By name: the model, columns (of both tips where there are two) with their values, their tolerance, and J of K_I and K_II with its tolerance
FORMS = {
    # Tada, Paris & Irwin: (1 - 0.025 s^2 + 0.06 s^4) sqrt(sec(pi s/2)), within 0.1 %, s = 2a/W
    "crack in a strip": (plate(0.4, 1.6, path(-0.04, 0.0, 0.04, 0.0)),
                         {"K_I": S * math.sqrt(math.pi * 0.04) * (1 - 0.025 * 0.2**2 + 0.06 * 0.2**4) * math.sqrt(1 / math.cos(math.pi * 0.1)), "K_II": 0.0}, 1e-3, irwin, 1e-4),
    # A crack turned by b from x; the plate of 50 half-lengths makes some 1e-3 of it
    "slanted crack": (plate(2.0, 2.0, path(-SLANTED[0], -SLANTED[1], *SLANTED)), {"K_I": K * math.cos(TURN)**2, "|K_II|": K * math.sin(TURN) * math.cos(TURN)}, 1.5e-3, irwin, 1e-4),
    # A half plane (Koiter); by the strip of 1/100: 1.12152 + 1.4e-4 x ... stays within 0.15 %
    "edge crack": (plate(2.0, 4.0, path(-1.0, 0.0, -0.98, 0.0)), {"K_I": 1.12152 * K}, 1.5e-3, irwin, 1e-4),
    # K_I whatever the material, J by its compliances, independently of K
    **{f"orthotropic material turned by {angle}": (plate(2.0, 2.0, path(-0.02, 0.0, 0.02, 0.0), material=ORTHOTROPIC.format(angle=angle)), {"K_I": K}, 3e-3,
                                                   lambda k1, k2, angle=angle: sih(math.radians(angle), k1, k2), 5e-4) for angle in (0.0, 30.0)},
    # As of tension of that size, and the volume 2 pi p a^2/E
    "pressure in a crack": (plate(2.0, 2.0, path(-0.02, 0.0, 0.02, 0.0), f"&load kind = 'pressure'  on = 'crack'  pressure = {S} /", "&probe name = 'v'  quantity = 'volume'  of = 'c' /", tension=0.0),
                            {"K_I": K, "volume_v": 2 * math.pi * S * 0.02**2 / E}, 1.5e-3, irwin, 1e-3),
    # Sneddon (1946), around an axis
    "penny": (model(0.0, -0.6, 0.6, 0.6, *(traction(0.0, s * 0.6, 0.6, s * 0.6, 0.0, s * S * math.pi * 0.36) for s in (-1, 1)), "&crack kind = 'line'  tip = 0.03, 0.0  direction = 1.0, 0.0 /",
                    plane="axisymmetric"), {"K_I": 2 * S * math.sqrt(0.03 / math.pi)}, 1e-3, lambda k1, k2: k1**2 * (1 - NU**2) / E, 1e-4),
    # Lame: a thick tube in plane strain by an axis, and as a disc with a hole in plane stress
    "tube": (model(0.05, 0.0, 0.1, 0.04, *(f"&constraint lower = 0.05, {y}  upper = 0.1, {y}  fix = 'y' /" for y in (0.0, 0.04)),
                   f"&load kind = 'pressure'  lower = 0.05, 0.0  upper = 0.05, 0.04  pressure = {S} /", "&probe name = 'p'  quantity = 'displacement', 'stress'  at = 0.07, 0.02 /",
                   plane="axisymmetric"),
             {"stress_p_zz": LAME * (1 + 0.1**2 / 0.07**2), "displacement_p_x": (1 + NU) / E * LAME * ((1 - 2 * NU) * 0.07 + 0.1**2 / 0.07)}, 1e-6, None, 0.0),
    "disc with a hole": (model(-0.1, -0.1, 0.1, 0.1, "&body material = 'm'  shape = 'circle'  center = 0.0, 0.0  radius = 0.1 /", HOLE.format(0.05),
                               f"&load kind = 'pressure'  lower = -0.06, -0.06  upper = 0.06, 0.06  pressure = {S} /", "&probe name = 'p'  quantity = 'stress'  at = 0.07, 0.0 /", body=None),
                         {"stress_p_yy": LAME * (1 + 0.1**2 / 0.07**2)}, 1e-4, None, 0.0),
    # Kirsch: three times the tension beside a hole
    "hole in a large plate": (plate(2.0, 2.0, HOLE.format(0.02), "&probe name = 'p'  quantity = 'stress'  at = 0.03, 0.0 /"), {"stress_p_yy": S * (1 + 0.5 * (2 / 3)**2 + 1.5 * (2 / 3)**4)}, 1.5e-3,
                              None, 0.0),
    # Suo & Hutchinson (1990): m^2/(2 B) (1/E1 I1 + 1/E2 I2) of two glued layers of two materials bent apart by one moment
    "layers bent apart": (model(0.0, -0.002, 0.1, 0.003, MATERIAL.replace("'m'", "'soft'").replace(str(E), "70e9"), "&body material = 'm'  lower = 0.0, 0.0  upper = 0.1, 0.003 /",
                                "&body material = 'soft'  lower = 0.0, -0.002  upper = 0.1, 0.0 /", "&constraint lower = 0.1, -0.002  upper = 0.1, 0.003  fix = 'xy' /",
                                *(traction(0.0, y, 0.0, y + 0.001, f, 0.0) for y, f in ((0.002, -1000.0), (0.0, 1000.0), (-0.001, 2000.0), (-0.002, -2000.0))),
                                "&crack kind = 'line'  tip = 0.05, 0.0 /", cell=0.0005, body=None),
                          {"J": sum(2.0**2 / (2 * e * h**3 / 12) for e, h in ((E, 0.003), (70e9, 0.002)))}, 1e-3, None, 0.0)}
QUICK = "penny", "tube", "disc with a hole", "hole in a large plate", "layers bent apart"


@pytest.mark.parametrize("name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.verify) for name in FORMS])
def test_closed_form(name, tmp_path):
    text, columns, tolerance, j_of, near = FORMS[name]
    found = answer(tmp_path, text)
    for tip in ("", "_tip2")[:1 + ("J_tip2" in found)]:
        for column, exact in columns.items():
            value = abs(found[column[1:-1] + tip]) if column[0] == "|" else found[column + tip * (column in ("J", "K_I", "K_II"))]
            assert value == pytest.approx(exact, rel=tolerance, abs=0.0 if exact else 1e-5 * K), column + tip
        assert j_of is None or found[f"J{tip}"] == pytest.approx(j_of(found[f"K_I{tip}"], found[f"K_II{tip}"]), rel=near)


@pytest.mark.verify
def test_heated_strip_with_an_edge_crack_has_one_j(tmp_path):
    """A plate that is held at its ends and cools is as one in tension that is pulled by as much."""
    pulled = answer(tmp_path, held("displacement = 0.0, 4e-5"))
    cooled = answer(tmp_path, held(body="eigenstrain = -1e-4, -1e-4, 0.0, -1e-4"))
    for column in ("K_I", "K_II", "J", "K_I_tip2", "K_II_tip2", "J_tip2"):
        assert cooled[column] == pytest.approx(pulled[column], rel=1e-4), column


@pytest.mark.verify
def test_graded_plate_under_uniform_strain(tmp_path):
    """Where the stiffness rises by e^(beta x) and loads make a uniform strain, J by rings of several sizes is one, and that of K (Eischen 1987)."""
    found = answer(tmp_path, model(-0.4, -0.4, 0.4, 0.4, "&constraint lower = -0.4, -0.4  upper = 0.4, -0.4  fix = 'y' /",
                                   "&constraint lower = -0.4, 0.4  upper = 0.4, 0.4  fix = 'y'  displacement = 0.0, 8e-5 /", path(-0.025, 0.0, 0.025, 0.0),
                                   body="profile_at = -0.4, 0.4  profile_stiffness = 0.0183156, 54.59815"))
    size = E * 1e-4 * math.sqrt(math.pi * 0.025)
    for tip, factor, place in (("", 1.1972, 0.025), ("_tip2", 0.8219, -0.025)):     # of Fourier transforms, beta a = 0.25, an infinite plate
        assert found[f"K_I{tip}"] / size == pytest.approx(factor, rel=8e-3)
        assert found[f"J{tip}"] == pytest.approx(found[f"K_I{tip}"]**2 / (E * math.exp(10 * place)), rel=1e-3)
