"""Put pictures on one sheet, each with the name of its file above it.

    python tools/contact_sheet.py SHEET.png PICTURE.png ...
"""

import sys
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

ACROSS, WIDTH, HEIGHT, GAP, HEAD = 3, 430, 400, 14, 24  # pictures in a row; pixels


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    pictures = [(Path(name).stem.replace("_", " "), Image.open(name).convert("RGB")) for name in sys.argv[2:]]
    scaled = [(name, fitted(picture)) for name, picture in pictures]
    scaled.sort(key=lambda one: one[1].height)                # rows of pictures that are as high
    rows = [scaled[k:k + ACROSS] for k in range(0, len(scaled), ACROSS)]
    heights = [max(picture.height for _, picture in row) + HEAD + GAP for row in rows]
    sheet = Image.new("RGB", (ACROSS * (WIDTH + GAP) + GAP, sum(heights) + GAP), "white")
    draw, font, top = ImageDraw.Draw(sheet), ImageFont.load_default(16), GAP
    for row, height in zip(rows, heights):
        for k, (name, picture) in enumerate(row):
            left = GAP + k * (WIDTH + GAP)
            draw.text((left + WIDTH / 2, top), name, fill="black", font=font, anchor="mt")
            sheet.paste(picture, (left + (WIDTH - picture.width) // 2, top + HEAD))
        top += height
    sheet.save(sys.argv[1])


def fitted(picture):
    """A picture as large as fits into its place."""
    part = min(WIDTH / picture.width, HEIGHT / picture.height)
    return picture.resize((round(picture.width * part), round(picture.height * part)), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    main()
