"""Draw the double cantilever beam of square arms: all four quarters of it, opened, with its front, and G along that.

    python tools/solid_dcb.py RESULT.h5 PICTURE.png
"""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "postprocess"))

import plot_field  # noqa: E402
import plot_front  # noqa: E402
import solid_pictures  # noqa: E402
from frames import frames_of  # noqa: E402
from history import read_curve  # noqa: E402
from particle_fields import ParticleField  # noqa: E402
from particle_pictures import colours  # noqa: E402
from pictures import COLOURS, MM, STYLE, plt  # noqa: E402

BEAM = 12 * 1.0**2 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3)   # G of clamped arms under 1 N [J/m2]
SCALE = 4000     # of the displacements


def main():
    file, picture = sys.argv[1:]
    options = plot_field.parse([file, "--field", "von_mises", "--up", "y", "--mirror", "y=0", "--mirror", "z=0.005", "--ligament", "ligament"])
    result = frames_of(file)
    field = ParticleField(result, options.field)
    seen = solid_pictures.survey(result, field, [1], options, SCALE)
    with plt.rc_context(STYLE):
        figure, (body, curve) = plt.subplots(1, 2, figsize=(9, 3.9), width_ratios=(1.9, 1), layout="constrained")
        shades = colours(field, seen, options)
        canvas = solid_pictures.Canvas(body, result, field, SCALE, shades, options)
        canvas.show(1)
        figure.colorbar(canvas.colours, ax=body, location="left", shrink=0.75, extend=shades.extend, label=f"{field.words} [{shades.unit}]")
        found, = plot_front.curves_of(plot_front.parse([file, "--ligament", "ligament", "--scale", str(BEAM)]))
        place, reference = read_curve(ROOT / "tests/reference/solid/dcb.csv")
        for x, values, words, look in ((place, reference, "finite elements of degree 5", {"color": "black", "linewidth": 1}),
                                       (found.place, found.domain, "hampm3d", {"color": COLOURS[0], "marker": "o", "markersize": 3, "linestyle": "none"})):
            curve.plot(MM * x, values, label=words, **look)
            curve.plot(MM * (0.01 - x), values, label="_", **look)
        curve.axhline(1.0, color=COLOURS[7], linestyle=(0, (5, 3)), linewidth=1)
        curve.annotate("beam theory", (5, 1.0), xytext=(0, 3), textcoords="offset points", ha="center", fontsize=9, color="0.4")
        curve.set(xlabel="place along the front [mm]", ylabel="$G / G_\\mathrm{beam}$", ylim=(0, None))
        curve.legend(frameon=False, loc="lower center")
        figure.savefig(picture, dpi=110)
    print(picture)


if __name__ == "__main__":
    main()
