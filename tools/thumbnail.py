"""Draw a small picture of a result without axes, for a table of specimens.

    python tools/thumbnail.py RESULT.h5 PICTURE.png FIELD [SCALE]

FIELD is one of postprocess/plot_field.py, SCALE the factor by which displacements are enlarged.
"""

import io
import sys
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "postprocess"))

import plot_field  # noqa: E402
from frames import frames_of  # noqa: E402

WIDE, HIGH, COLOURS = 220, 120, 48  # pixels at most


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    result, picture, field = sys.argv[1:4]
    options = plot_field.parse([result, "--field", field, *(["--scale", sys.argv[4]] if len(sys.argv) == 5 else [])])
    figure = plot_field.draw([frames_of(Path(result))], options)
    panel, *others = figure.axes
    for axes in others:
        axes.set_visible(False)
    panel.set_axis_off()
    panel.set_title("")
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=150, bbox_inches="tight", pad_inches=0.02)
    with Image.open(drawn) as image:
        small = image.convert("RGB")
        small.thumbnail((WIDE, HIGH), Image.Resampling.LANCZOS)
        small.quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True)


if __name__ == "__main__":
    main()
