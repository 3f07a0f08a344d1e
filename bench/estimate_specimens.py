"""Cracked specimens at random, each with the scene that tells what its energy release rate is: that of quadratic cells, much finer at the
tips. Lengths in mm where a name does not say otherwise.

K of a body that only tractions load does not depend on Poisson's ratio and on the plane (Michell 1899), so that the references of isotropic
specimens have 0.3 and plane stress, whatever the specimen has. A pressed crack that slips everywhere has the K_II of the open one, times the part of
the shear that friction leaves (superposition).
"""

import random
from dataclasses import dataclass, field
from math import atan2, cos, pi, sin

YOUNG = 70e9
STRESS = 1e5               # typical traction [Pa]
KINDS = ("symmetry", "line", "path", "two paths", "incompressible", "zz", "gradient", "neo_hookean", "orthotropic", "eigenstrain", "hole",
         "quadratic", "pressure", "frictionless", "friction", "cpdi")


@dataclass
class Scene:
    """What a namelist is written from."""
    width: float = 40.0
    height: float = 40.0
    lower: tuple = (0.0, 0.0)
    cell: float = 1.0
    poisson: float = 0.3
    plane: str = "stress"
    law: str = "law='linear_elastic' young={young} poisson={poisson}"
    points: int = 2
    order: int = 1
    loads: list = field(default_factory=list)
    more: list = field(default_factory=list)       # other groups
    crack: list = field(default_factory=list)
    level: int = 0
    indicator: str = "tip"
    refine: str = "rings=6"
    method: str = "time='static'"
    end: float = 1.0
    body: str = ""
    nodal: bool = False    # estimators that close a crack at a node
    room: int = 1

    def text(self):
        low = [c - self.room * self.cell for c in self.lower]
        cells = [round(s / self.cell) + 2 * self.room for s in (self.width, self.height)]
        law = self.law.format(young=YOUNG, poisson=self.poisson)
        x0, y0 = self.lower
        lines = [f"&run plane='{self.plane}' end_time={self.end} /",
                 f"&grid lower={low[0]}e-3,{low[1]}e-3 cell={self.cell}e-3 cells={cells[0]},{cells[1]} order={self.order} /",
                 f"&material name='m' {law} density=2700 /",
                 f"&body material='m' lower={x0}e-3,{y0}e-3 upper={x0 + self.width}e-3,{y0 + self.height}e-3 "
                 f"points_per_cell={self.points} {self.body} /"]
        lines += self.more + [f"&load {load} /" for load in self.loads] + [f"&crack {crack} /" for crack in self.crack]
        lines.append(f"&method {self.method} /")
        if self.level or self.indicator != "tip":
            lines.append(f"&refine indicator='{self.indicator}' max_level={self.level} {self.refine} /")
        estimators = ["'domain_integral'"] + ["'vcct'"] * self.nodal
        lines.append(f"&energy_release estimators={','.join(estimators)} /")
        return "\n".join(lines) + "\n"

    def uniform(self, xx, yy, xy, edges="lrbt"):
        """The tractions of a uniform stress, in parts of STRESS, on some edges; thickness 1 m."""
        (x0, y0), w, h = self.lower, self.width, self.height
        ends = {"l": (x0, y0, x0, y0 + h, -xx, -xy, h), "r": (x0 + w, y0, x0 + w, y0 + h, xx, xy, h),
                "b": (x0, y0, x0 + w, y0, -xy, -yy, w), "t": (x0, y0 + h, x0 + w, y0 + h, xy, yy, w)}
        for edge in edges:
            a, b, c, d, fx, fy, length = ends[edge]
            if fx or fy:
                n = STRESS * length * 1e-3
                self.loads.append(f"kind='traction' lower={a}e-3,{b}e-3 upper={c}e-3,{d}e-3 force={fx * n},{fy * n}")


@dataclass
class Specimen:
    """A scene, and a reference for it."""
    kind: str
    number: int
    scene: str
    truths: list               # scenes of the same crack, the better one last
    factors: tuple = (1.0, 1.0)  # by which K_I and K_II of the reference are multiplied
    doubt: float = 0.0         # of the reference beside what its scenes differ by [-]
    modulus: float = 0.0       # E' of the specimen, 0: of J of the reference
    truth_modulus: float = YOUNG

    @property
    def name(self):
        return f"{self.kind} {self.number}"


def make(kind, number):
    """Specimen number `number` of a kind."""
    dice = random.Random(f"{kind} {number}")
    scene = Scene()
    scene.poisson = dice.choice([0.0, 0.2, 0.3, 0.3, 0.33, 0.4, 0.45])
    scene.plane = dice.choice(["stress", "strain"])
    scene.level = dice.choice([0, 0, 1, 2])
    changes = {}
    factors, doubt = (1.0, 1.0), 0.0
    if kind == "cpdi":
        scene.level = 0
        on_symmetry(dice, scene, shapes=["centre"], widths=[12, 14, 16])       # an edge crack bends its plate, which takes far longer to come to rest
    elif kind == "symmetry" or kind in ("incompressible", "zz", "gradient", "neo_hookean", "quadratic", "orthotropic") and number % 3 == 0:
        on_symmetry(dice, scene)
    elif kind == "line" or kind in ("incompressible", "neo_hookean", "quadratic", "orthotropic") and number % 3 == 1:
        on_line(dice, scene)
    elif kind in ("friction", "frictionless"):
        factors, changes = pressed(dice, scene, kind)
        doubt = 5e-3
    else:
        on_path(dice, scene, kind)
    if kind == "incompressible":
        scene.poisson = dice.choice([0.47, 0.49, 0.495, 0.499, 0.4999])
        scene.plane = "strain"
    elif kind == "zz":
        scene.indicator, scene.refine = "zz", f"tolerance={dice.choice([0.05, 0.1])}"
        scene.level = max(scene.level, 1)
    elif kind == "gradient":
        scene.indicator, scene.refine = "gradient", f"r_crit={dice.choice([0.06, 0.12])}"
        scene.level = max(scene.level, 1)
    elif kind == "neo_hookean":
        scene.law = scene.law.replace("linear_elastic", "neo_hookean")
    elif kind == "orthotropic":
        ratio, shear = dice.choice([2, 5, 14]), dice.choice([0.05, 0.1, 0.2])
        scene.law = (f"law='orthotropic' young_1=140e9 young_2={140e9 / ratio} shear_12={140e9 * shear} poisson_12=0.3 "
                     f"angle={dice.choice([0, 30, 90, -45]) if not scene.more else dice.choice([0, 90])}")
        scene.plane = "stress"
        changes["law"] = scene.law
    elif kind == "eigenstrain":
        scene.body = f"eigenstrain={dice.uniform(-2e-3, 2e-3):.2e},{dice.uniform(-2e-3, 2e-3):.2e},{dice.uniform(-1e-3, 1e-3):.2e}"
        changes["body"] = ""
    elif kind == "hole":
        scene.more.append(hole(dice, scene))
    elif kind == "quadratic":
        scene.order, scene.points = 2, dice.choice([3, 3, 4])
    elif kind == "pressure":
        scene.loads = []
        scene.uniform(1, 1, 0)                   # opens a crack as much as a pressure on its faces does
        changes["loads"] = scene.loads
        scene.loads = [f"kind='pressure' on='crack' pressure={STRESS}"]
    if kind == "cpdi":
        in_motion(scene, "frame='updated' shape_functions='cpdi'")
    truths = []
    for extra in (2, 3):
        values = dict(poisson=0.3, plane="stress", law=Scene.law, points=3, order=2, indicator="tip", refine="rings=6", method="time='static'",
                      end=1.0, level=(max(scene.level, 1) if scene.indicator == "tip" else 2) + extra, nodal=False) | changes
        if kind == "quadratic":
            values["points"] = 4
            values["level"] = max(scene.level, 1) + extra
        loads, more = values.pop("loads", scene.loads), values.pop("more", [g for g in scene.more if not g.startswith("&damping")])
        crack = values.pop("crack", scene.crack)
        truth = Scene(**(vars(scene) | values | {"loads": loads, "more": more, "crack": crack}))
        truths.append(truth.text())
    modulus = 0.0 if kind == "orthotropic" else YOUNG / (1 - scene.poisson**2 if scene.plane == "strain" else 1)
    return Specimen(kind, number, scene.text(), truths, factors, doubt, modulus)


def on_symmetry(dice, scene, shapes=("edge", "centre", "beam"), widths=(16, 20, 24, 30)):
    """Half of an edge crack or a centre crack in tension, or of a double cantilever beam."""
    shape = dice.choice(shapes)
    scene.width = dice.choice(widths)
    scene.height = scene.width * 2 if shape == "edge" else scene.width * dice.choice([1, 2])
    tip = dice.randint(4, scene.width - 6) if shape != "beam" else scene.width // 2
    if shape == "beam":
        scene.height = dice.choice([4, 6, 8])
        scene.width, tip = 8 * scene.height, dice.randint(3, 5) * scene.height
        scene.loads.append(f"kind='traction' lower=0.0,0.0 upper=0.0,{scene.height}e-3 force=0.0,{STRESS * 1e-3}")
    else:
        scene.uniform(0, 1, 0, "t")
    scene.more.append(f"&constraint lower={tip}e-3,0.0 upper={scene.width}e-3,0.0 fix='y' /")
    if shape == "centre":
        scene.more.append(f"&constraint lower=0.0,0.0 upper=0.0,{scene.height}e-3 fix='x' /")
    else:
        scene.more.append(f"&constraint lower={scene.width}e-3,0.0 upper={scene.width}e-3,0.0 fix='x' /")
    scene.crack = [f"kind='symmetry' tip={tip}e-3,0.0"]
    scene.nodal = True
    scene.points = dice.choice([2, 2, 3 if scene.level == 0 else 4])


def on_line(dice, scene):
    """A crack along a grid line of a plate in tension and shear: one or two tips."""
    scene.width = dice.choice([20, 24, 30, 40])
    scene.height = dice.choice([20, 24, 30, 40])
    y = dice.randint(scene.height // 3, 2 * scene.height // 3)
    scene.uniform(0, 1, dice.choice([0, 0.3, 0.6, 1.0]))
    if dice.random() < 0.5:
        tip = dice.randint(5, scene.width - 6)
        scene.crack = [f"kind='line' tip={tip}e-3,{y}e-3 direction=1.0,0.0"]
    else:
        length = dice.randint(4, scene.width // 2)
        tip = dice.randint(length + 4, scene.width - 4)
        scene.crack = [f"kind='line' tip={tip}e-3,{y}e-3 direction=1.0,0.0 length={length}e-3"]
    scene.nodal = True
    scene.points = dice.choice([2, 2, 3 if scene.level == 0 else 4])


def on_path(dice, scene, kind):
    """A slanted crack of a plate in tension and shear: with two tips, from the edge, or kinked; or two of them."""
    scene.width = scene.height = dice.choice([24, 30, 40])
    scene.lower = (-scene.width / 2, -scene.width / 2)
    both = kind == "two paths"
    scene.level = max(scene.level, 1) if both else scene.level
    scene.uniform(0, 1, dice.choice([0, 0.3, -0.6]))
    w = scene.width
    angle = dice.uniform(-50, 50) * pi / 180
    shape = dice.choice(["centre", "edge", "kinked"])
    a = dice.uniform(0.12, 0.2 if kind == "hole" else 0.25) * w
    x, y = dice.uniform(-0.1, 0.1) * w, dice.uniform(-0.1, 0.1) * w
    if both:
        scene.width = scene.height = w = 40
        scene.lower, scene.loads = (-20.0, -20.0), []
        scene.uniform(0, 1, dice.choice([0, 0.3]))
        d, lift = dice.uniform(7, 9), dice.uniform(-3, 3)
        for number, side in enumerate((-1, 1)):
            turn = dice.uniform(-0.5, 0.5)
            c, s = 4.5 * cos(turn), 4.5 * sin(turn)
            scene.crack.append(f"kind='path' points={side * d - c:.4f}e-3,{side * lift - s:.4f}e-3,{side * d + c:.4f}e-3,{side * lift + s:.4f}e-3 "
                               f"name='{'ab'[number]}'")
        return
    c, s = a * cos(angle), a * sin(angle)
    if shape == "centre":
        points = [(x - c, y - s), (x + c, y + s)]
    elif shape == "edge":
        points = [(-w / 2, y - s), (-w / 2 + 2 * c, y + s)]
    else:
        bend = angle + dice.choice([-1, 1]) * dice.uniform(0.3, 0.9)
        points = [(x - c, y - s), (x, y), (x + a * cos(bend), y + a * sin(bend))]
    scene.crack = ["kind='path' points=" + ",".join(f"{v:.4f}e-3" for point in points for v in point)]
    dice.random()                                # chose an estimator of versions before 3


def pressed(dice, scene, kind):
    """A crack in a plate that is pressed, which slips everywhere. The reference is pulled, and does not close."""
    scene.width = scene.height = 60
    scene.lower, scene.cell = (-30.0, -30.0), 2.0
    scene.level = max(scene.level, 1)
    angle, a = dice.uniform(30, 60) * pi / 180, dice.uniform(4, 6)
    x, y = dice.uniform(-2, 2), dice.uniform(-2, 2)
    friction = 0.0 if kind == "frictionless" else dice.choice([0.1, 0.2, 0.3])
    normal, shear = cos(angle)**2, cos(angle) * sin(angle)
    points = f"{x - a * cos(angle):.4f}e-3,{y - a * sin(angle):.4f}e-3,{x + a * cos(angle):.4f}e-3,{y + a * sin(angle):.4f}e-3"
    loads = Scene(**(vars(scene) | {"loads": []}))
    loads.uniform(0, 1, 0)
    scene.uniform(0, -1, 0)
    scene.loads = [load + " history='ramp' rise_time=1.0" for load in scene.loads]
    contact = f"contact='friction' friction={friction}" if friction else "contact='frictionless'"
    scene.crack = [f"kind='path' points={points} {contact}"]
    scene.method = "time='static' load_steps=2"
    scene.refine = "rings=8"
    return (0.0, -(1 - friction * normal / shear)), {"loads": loads.loads, "crack": [f"kind='path' points={points}"]}


def hole(dice, scene):
    """A hole ahead of or beside the last point of a path, and clear of it."""
    values = [float(v.removesuffix("e-3")) for v in scene.crack[0].split("points=")[1].split(",")]
    (x0, y0), (x1, y1) = values[-4:-2], values[-2:]
    along = atan2(y1 - y0, x1 - x0) + dice.uniform(-1.2, 1.2)
    scene.level = max(scene.level, 1)
    radius = dice.uniform(1.5, 2.0)
    distance = radius + dice.uniform(4.5, 7.0) / 2**scene.level
    return (f"&body shape='circle' hole=.true. center={x1 + distance * cos(along):.4f}e-3,{y1 + distance * sin(along):.4f}e-3 "
            f"radius={radius:.4f}e-3 /")


def in_motion(scene, method):
    """Damped until at rest, from a ramp."""
    scene.method = method
    length = max(scene.width, scene.height) * 1e-3
    speed = (YOUNG / 2700)**0.5
    rate = 1.5 * speed / length                  # about that of the slowest oscillation
    scene.end = 25 / rate
    scene.more.append(f"&damping rate={2 * rate:.3e} /")
    scene.loads = [load + f" history='ramp' rise_time={scene.end / 4:.3e}" for load in scene.loads]
