"""Write a PNG with a palette of at most 256 colours: a third of the bytes, for the docs.

    python tools/palette.py DRAWN.png PICTURE.png

Exit code 1 where the picture is still larger than 120 kB.
"""

import sys
from pathlib import Path

from PIL import Image

MOST = 120_000  # bytes


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    drawn, picture = map(Path, sys.argv[1:])
    if not drawn.is_file():
        sys.exit(f"{drawn}: no such file")
    picture.parent.mkdir(parents=True, exist_ok=True)
    with Image.open(drawn) as image:
        reduced = image.convert("RGB").quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    reduced.save(picture, optimize=True)
    size = picture.stat().st_size
    print(f"{picture}: {size / 1000:.0f} kB")
    if size > MOST:
        sys.exit(f"{picture}: {size / 1000:.0f} kB, more than {MOST / 1000:g}: draw it with fewer points per inch")


if __name__ == "__main__":
    main()
