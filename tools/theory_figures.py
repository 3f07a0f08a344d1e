#!/usr/bin/env python3
"""The drawings of docs/explanation, as SVG with large type.

    python tools/theory_figures.py [FOLDER]      write them, into docs/images where no folder is given
"""

import cmath
import math
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "docs/images"
BLUE, RED, GREEN, GREY, INK = "#1f5fa8", "#b3261e", "#1b7a3d", "#8a8a8a", "#222222"


class Drawing:
    """Shapes in pixels, y downwards, on white: the same in light and dark pages."""

    def __init__(self, width, height):
        markers = "".join(f'<marker id="{color[1:]}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="9" markerHeight="9" '
                          f'markerUnits="userSpaceOnUse" orient="auto"><path d="M0 0 L8 4 L0 8 z" fill="{color}"/></marker>'
                          for color in (BLUE, RED, GREEN, GREY, INK))
        self.parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="16">',
                      f"<defs>{markers}</defs>", '<rect width="100%" height="100%" fill="#ffffff"/>']

    def line(self, *points, color=INK, width=1.5, dash=None, end=False, fill="none", close=False):
        path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points) + (" z" if close else "")
        self.parts.append(f'<path d="{path}" fill="{fill}" stroke="{color}" stroke-width="{width}"'
                          + (f' stroke-dasharray="{dash}"' if dash else "") + (f' marker-end="url(#{color[1:]})"' if end else "") + "/>")

    def arrow(self, a, b, color=INK, width=2):
        self.line(a, b, color=color, width=width, end=True)

    def dot(self, x, y, radius=5, color=INK, fill=None):
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{color if fill is None else fill}" stroke="{color}" stroke-width="1.5"/>')

    def circle(self, x, y, radius, color=INK, dash=None, fill="none"):
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{fill}" stroke="{color}" stroke-width="1.5"'
                          + (f' stroke-dasharray="{dash}"' if dash else "") + "/>")

    def box(self, x, y, width, height, color=INK, fill="none", dash=None):
        self.line((x, y), (x + width, y), (x + width, y + height), (x, y + height), color=color, fill=fill, dash=dash, close=True)

    def text(self, x, y, words, color=INK, anchor="middle", size=16, bold=False):
        words = words.replace("&", "&amp;").replace("<", "&lt;")
        while "_{" in words:                       # subscripts
            before, _, rest = words.partition("_{")
            below, _, after = rest.partition("}")
            words = f'{before}<tspan dy="5" font-size="{size - 4}">{below}</tspan><tspan dy="-5">&#8203;{after}</tspan>'
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" fill="{color}" text-anchor="{anchor}" font-size="{size}"'
                          + (' font-weight="bold"' if bold else "") + f">{words}</text>")

    def svg(self):
        return "\n".join([*self.parts, "</svg>", ""])


def grid(drawing, x, y, cell, across, down, color=GREY):
    for k in range(across + 1):
        drawing.line((x + k * cell, y), (x + k * cell, y + down * cell), color=color, width=1)
    for k in range(down + 1):
        drawing.line((x, y + k * cell), (x + across * cell, y + k * cell), color=color, width=1)


def step():
    """A step: particles to grid, equations of the nodes, grid to particles, and a grid that has not moved."""
    drawing, cell = Drawing(1120, 350), 70
    titles = "1  particles to grid", "2  nodes", "3  grid to particles", "4  the grid stays"
    says = "mass, momentum, force", "accelerations, velocities", "velocity, strain, displacement", "particles have moved on"
    motion = (13, -9)
    for k, (title, words) in enumerate(zip(titles, says)):
        x, y = 35 + 275 * k, 60
        drawing.text(x + 1.5 * cell, 32, title, bold=True)
        drawing.text(x + 1.5 * cell, y + 3 * cell + 38, words)
        grid(drawing, x, y, cell, 3, 3)
        places = [(x + (i + 0.5) * cell / 2, y + (j + 0.5) * cell / 2) for i in range(1, 5) for j in range(2, 6)]
        if k == 3:
            for px, py in places:
                drawing.dot(px, py, 3, GREY, "#ffffff")
            places = [(px + motion[0], py + motion[1]) for px, py in places]
        px, py = x + 1.25 * cell, y + 1.25 * cell
        corners = [(x + a * cell, y + b * cell) for a in (1, 2) for b in (1, 2)]
        if k in (0, 2):
            for cx, cy in corners:
                near, far = ((px, py), (cx, cy)) if k == 0 else ((cx, cy), (px, py))
                gap = 9 / max(abs(cx - px) + abs(cy - py), 1) * 1.3
                drawing.arrow((near[0] + gap * (far[0] - near[0]), near[1] + gap * (far[1] - near[1])),
                              (far[0] + gap * (near[0] - far[0]), far[1] + gap * (near[1] - far[1])), RED)
        for place in places:
            drawing.dot(*place, 4.5, BLUE)
        for i in range(4):
            for j in range(4):
                active = i < 4 and j > 0
                drawing.box(x + i * cell - 4, y + j * cell - 4, 8, 8, INK if active else GREY, INK if active and k == 1 else "#ffffff")
                if k == 1 and active:
                    drawing.arrow((x + i * cell, y + j * cell), (x + i * cell + 26, y + j * cell - 18), RED)
        if k == 3:
            for (ax, ay) in places[::5]:
                drawing.arrow((ax - motion[0], ay - motion[1]), (ax, ay), RED)
    drawing.dot(380, 332, 4.5, BLUE)
    drawing.text(392, 338, "particle: mass, volume, velocity, strain", anchor="start")
    drawing.box(716, 328, 8, 8)
    drawing.text(732, 338, "node", anchor="start")
    return drawing


def schemes():
    """What a step does in each scheme, in order."""
    drawing = Drawing(1120, 330)
    columns = ["map v^n", "strain", "map force", "kick v_{p}", "map v anew", "strain", "move u_{p}"]
    width, left, top, row = 128, 190, 62, 58
    used = {"usf": (1, 1, 1, 1, 0, 0, 1), "usl": (1, 0, 1, 1, 0, 1, 1), "musl": (1, 0, 1, 1, 1, 1, 1), "usavg": (1, 2, 1, 1, 1, 2, 1)}
    by = {"usf": ("v^n", ""), "usl": ("", "v^{n+1}"), "musl": ("", "v anew"), "usavg": ("v^n", "v anew")}
    for k, name in enumerate(columns):
        drawing.text(left + (k + 0.5) * width, 38, name.replace("v^n", "vⁿ"), bold=True)
    for j, (scheme, boxes) in enumerate(used.items()):
        y = top + j * row
        drawing.text(28, y + 27, scheme, anchor="start", bold=True, size=18)
        drawing.line((left - 20, y + 21), (left + 7 * width + 20, y + 21), color=GREY, end=True)
        for k, use in enumerate(boxes):
            if not use:
                continue
            strained = k in (1, 5)
            drawing.box(left + k * width + 8, y, width - 16, 42, RED if strained else BLUE, "#fdecea" if strained else "#e8f0fa")
            words = {0: "(8)", 2: "(7)", 3: "(5)", 4: "(8)", 6: "by v^{n+1}"}.get(k)
            if strained:
                words = ("half, " if use == 2 else "") + "by " + by[scheme][k == 5]
            words = words.replace("v^{n+1}", "vⁿ⁺¹").replace("v^n", "vⁿ").replace("v anew", "new v")
            drawing.text(left + (k + 0.5) * width, y + 27, words, size=15)
    drawing.text(560, 312, "All maps of a step use the shape functions at the positions of its start. Red: the particles are strained.")
    return drawing


def tip():
    """The nodes (1), (1'), (2) and (3) of the paper's Fig. 2, with the opening behind the tip and the stress ahead of it."""
    drawing, cell, x, y = Drawing(900, 400), 130, 90, 215
    opening = {0: 44, 1: 30, 2: 0, 3: 0, 4: 0}
    for sign in (-1, 1):
        for level in (0, 1):
            for k in range(4):
                drawing.line(*[(x + j * cell, y + sign * (opening[j] + level * cell * 0.95)) for j in (k, k + 1)],
                             color=INK if level == 0 else GREY, width=2.5 if level == 0 and k < 2 else 1)
        for k in range(5):
            drawing.line((x + k * cell, y + sign * opening[k]), (x + k * cell, y + sign * (opening[k] + cell * 0.95)), color=GREY, width=1)
    peak = [(x + 2 * cell, y - 70), (x + 3 * cell, y - 36)]
    drawing.line((x + 2 * cell, y), *peak, (x + 3 * cell, y), color=RED, fill="#fdecea", width=2, close=True)
    for part in (0.0, 0.25, 0.5, 0.75, 1.0):
        drawing.arrow((x + (2 + part) * cell, y), (x + (2 + part) * cell, y - 70 + 34 * part), RED, 1.5)
    drawing.text(x + 3 * cell + 12, y - 42, "stress of the plane ahead, σ_{2} to σ_{3}", RED, "start")
    for k, name, sign in ((1, "(1)", -1), (1, "(1')", 1), (2, "(2)", 0), (3, "(3)", 0)):
        px, py = x + k * cell, y + sign * opening[k]
        drawing.dot(px, py, 6, BLUE)
        drawing.text(px + (0 if sign else 2), py + (-14 if sign < 0 else 26), name, BLUE, bold=True)
    drawing.arrow((x + cell + 14, y), (x + cell + 14, y - 29), GREEN)
    drawing.arrow((x + cell + 14, y), (x + cell + 14, y + 29), GREEN)
    drawing.text(x + cell + 24, y + 6, "2 u_{1}", GREEN, "start")
    drawing.text(x + 22, y + 6, "crack", INK, "start")
    for a, b in ((1, 2), (2, 3)):
        drawing.arrow((x + (a + 0.5) * cell - 12, 372), (x + a * cell + 2, 372))
        drawing.arrow((x + (a + 0.5) * cell + 12, 372), (x + b * cell - 2, 372))
        drawing.text(x + (a + 0.5) * cell, 378, "h")
    drawing.arrow((x + 4 * cell + 30, y), (x + 4 * cell + 95, y))
    drawing.text(x + 4 * cell + 106, y + 6, "x")
    return drawing


def transition():
    """A leaf beside finer ones: its nodes, its hanging points and their weights."""
    drawing, side, x, y = Drawing(900, 400), 260, 70, 70
    drawing.box(x, y, side, side, INK)
    drawing.line((x + side / 2, y), (x + side / 2, y + side), color=GREY, dash="6 5")
    drawing.line((x, y + side / 2), (x + side, y + side / 2), color=GREY, dash="6 5")
    for k in range(2):
        drawing.box(x + side, y + k * side / 2, side / 2, side / 2)
    nodes = [(0, 0), (1, 0), (0, 1), (1, 1), (1, 0.5), (1.5, 0), (1.5, 0.5), (1.5, 1)]
    hanging = [(0.5, 0), (0, 0.5), (0.5, 0.5), (0.5, 1)]
    for a, b in nodes:
        drawing.dot(x + a * side, y + b * side, 7, BLUE)
    for a, b in hanging:
        drawing.dot(x + a * side, y + b * side, 7, RED, "#ffffff")
    for (a, b), words, dx, dy, anchor in (((0, 0), "1/4", -12, -12, "end"), ((0, 1), "1/4", -12, 24, "end"), ((1, 0), "1/8", 0, -16, "middle"),
                                          ((1, 1), "1/8", 0, 30, "middle"), ((1, 0.5), "1/4", 14, -10, "start")):
        drawing.text(x + a * side + dx, y + b * side + dy, words, GREEN, anchor, bold=True)
    drawing.text(x + side / 2 + 14, y + side / 2 - 12, "middle", RED, "start")
    drawing.text(x + side / 2, 26, "coarse leaf: four bilinear quarters")
    drawing.text(x + 1.25 * side + 20, 26, "finer leaves")
    left = 530
    drawing.dot(left, 110, 7, BLUE)
    drawing.text(left + 18, 116, "node with degrees of freedom", anchor="start")
    drawing.dot(left, 150, 7, RED, "#ffffff")
    drawing.text(left + 18, 156, "hanging: a mean of its masters", anchor="start")
    drawing.text(left - 8, 206, "1/4", GREEN, "start", bold=True)
    drawing.text(left + 34, 206, "weights of the middle; on a side", anchor="start")
    drawing.text(left + 34, 230, "both ends have 1/2. They are positive", anchor="start")
    drawing.text(left + 34, 254, "and sum to 1.", anchor="start")
    return drawing


def split():
    """A particle that becomes four children, in the reference configuration and deformed."""
    drawing, side = Drawing(960, 330), 180
    drawing.text(140, 36, "reference", bold=True)
    drawing.text(430, 36, "deformed, whole", bold=True)
    drawing.text(760, 36, "deformed, split", bold=True)

    def place(x, y, a, b, slanted):
        return (x + a * side * (1.1 if slanted else 1) + (0.25 * b * side if slanted else 0),
                y + b * side * (0.95 if slanted else 1) + (0.12 * a * side if slanted else 0))
    for x, y, slanted, parts in ((140, 165, False, 1), (430, 165, True, 1), (760, 165, True, 2)):
        for i in range(parts):
            for j in range(parts):
                at = [((i + p) / parts - 0.5, (j + q) / parts - 0.5) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))]
                drawing.line(*[place(x, y, a, b, slanted) for a, b in at], color=BLUE, fill="#e8f0fa", close=True)
        if parts == 1:
            drawing.dot(x, y, 7, BLUE)
        else:
            drawing.dot(x, y, 5, GREY, "#ffffff")
            for a in (-0.25, 0.25):
                for b in (-0.25, 0.25):
                    drawing.dot(*place(x, y, a, b, True), 6, BLUE)
                    drawing.arrow((x, y), place(x, y, a * 0.85, b * 0.85, True), RED)
    drawing.arrow((130, 288), (51, 288))
    drawing.arrow((150, 288), (229, 288))
    drawing.text(140, 308, "ℓ_{p}, the paper's c")
    drawing.text(430, 308, "x_{p}")
    drawing.text(760, 308, "x_{p} + F (±ℓ_{p}/4, ±ℓ_{p}/4)", RED)
    return drawing


def weight():
    """The weight q of the domain integral: over the distance from the tip, and the disc on the grid."""
    drawing = Drawing(980, 390)
    left, bottom, width, height = 80, 310, 340, 230
    drawing.arrow((left, bottom), (left + width + 40, bottom))
    drawing.arrow((left, bottom), (left, bottom - height - 40))
    curve = [(left + width * r / 100, bottom - height * (1 - t * t * (3 - 2 * t)))
             for r in range(101) for t in [min(max((r / 100 - 0.5) / 0.5, 0), 1)]]
    drawing.line(*curve, color=BLUE, width=3)
    for part, words in ((0.5, "r_{J}/2"), (1, "r_{J}")):
        drawing.line((left + width * part, bottom), (left + width * part, bottom - height), color=GREY, dash="5 5")
        drawing.text(left + width * part, bottom + 28, words)
    drawing.text(left - 16, bottom - height + 6, "1", anchor="end")
    drawing.text(left - 16, bottom + 6, "0", anchor="end")
    drawing.text(left + 20, bottom - height - 22, "q at the nodes", BLUE, "start")
    drawing.text(left + width / 2, bottom + 60, "distance from the tip")
    x, y, cell = 560, 40, 32
    grid(drawing, x, y, cell, 10, 10, "#bbbbbb")
    cx, cy = x + 5 * cell, y + 5 * cell
    drawing.circle(cx, cy, 4 * cell, BLUE)
    drawing.circle(cx, cy, 2 * cell, BLUE, fill="#e8f0fa")
    grid(drawing, x, y, cell, 10, 10, "#bbbbbb")
    drawing.line((x, cy), (cx, cy), color=RED, width=4)
    drawing.dot(cx, cy, 6, RED)
    drawing.text(cx, cy - 26, "q = 1", BLUE, bold=True)
    drawing.text(cx, cy + 3.1 * cell, "q falls", BLUE, bold=True)
    drawing.text(x + 5 * cell, y + 9.7 * cell, "q = 0", BLUE, bold=True)
    drawing.text(x + 12, cy - 10, "crack", RED, "start", bold=True)
    return drawing


def sent_back(angle, kind, poisson=0.3):
    """The part of the energy of a plane wave ('P' or 'S') that a viscous edge sends back, at an angle to its normal: sigma n + Z v = 0 of three waves."""
    fast, slow = 1.0, ((1 - 2 * poisson) / (2 - 2 * poisson))**0.5

    def tractions(direction, way, speed):
        (a, b), (u, v) = direction, way
        lame, shear = fast**2 - 2 * slow**2, slow**2
        return (lame * (a * u + b * v) + 2 * shear * a * u) / speed - fast * u, shear * (a * v + b * u) / speed - slow * v

    sine, speed = math.sin(math.radians(angle)), fast if kind == "P" else slow
    cosine, p, s = math.cos(math.radians(angle)), sine * fast / speed, sine * slow / speed
    across_p, across_s = cmath.sqrt(1 - p * p), cmath.sqrt(1 - s * s)
    here = tractions((cosine, sine), (cosine, sine) if kind == "P" else (-sine, cosine), speed)
    one, other = tractions((-across_p, p), (-across_p, p), fast), tractions((-across_s, s), (s, across_s), slow)
    area = one[0] * other[1] - one[1] * other[0]
    first, second = (here[1] * other[0] - here[0] * other[1]) / area, (here[0] * one[1] - here[1] * one[0]) / area
    return (fast * across_p.real * abs(first)**2 + slow * across_s.real * abs(second)**2) / (speed * cosine)


def absorbing():
    """Energy that comes back from a viscous edge over the angle of incidence: theory, and what is measured (docs/explanation/absorbing_edges.md)."""
    measured = {"P": {0: 0.03, 15: 0.02, 30: 0.05, 45: 0.57}, "S": {0: 0.03, 15: 0.27, 30: 2.16, 45: 3.08}}
    drawing = Drawing(720, 400)
    left, bottom, width, height, most = 80, 330, 560, 290, 14.0

    def place(angle, percent):
        return left + width * angle / 70, bottom - height * percent / most

    drawing.arrow((left, bottom), (left + width + 30, bottom))
    drawing.arrow((left, bottom), (left, bottom - height - 25))
    for angle in range(0, 71, 10):
        drawing.line(place(angle, 0), (place(angle, 0)[0], bottom + 6))
        drawing.text(place(angle, 0)[0], bottom + 25, f"{angle}°")
    for percent in range(0, 15, 2):
        drawing.line(place(0, percent), (left - 6, place(0, percent)[1]))
        drawing.text(left - 12, place(0, percent)[1] + 5, f"{percent} %", anchor="end")
    for kind, color, words, x, y in (("P", BLUE, "longitudinal", 60, 6.6), ("S", RED, "transverse", 46, 9.5)):
        curve = [(angle / 2, 100 * sent_back(angle / 2, kind)) for angle in range(0, 141)]
        drawing.line(*(place(*point) for point in curve if point[1] <= most), color=color, width=3)
        for angle, percent in measured[kind].items():
            drawing.dot(*place(angle, percent), 6, color, "#ffffff")
        drawing.text(*place(x, y), words, color, bold=True)
    drawing.text(left + width / 2, bottom + 55, "angle of incidence")
    drawing.text(left + 14, bottom - height - 12, "energy sent back", anchor="start")
    return drawing


FIGURES = {"theory_step": step, "theory_schemes": schemes, "theory_tip": tip, "theory_transition": transition, "theory_split": split,
           "theory_weight": weight, "theory_absorbing": absorbing}


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    for name, draw in FIGURES.items():
        (folder / f"{name}.svg").write_text(draw().svg(), encoding="utf-8")


if __name__ == "__main__":
    main()
