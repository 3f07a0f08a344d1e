"""Bodies that meet, beside what is exact: the tables of docs/explanation/contact.md.

    bars    restitution, time of contact, onset and energy of two bars, over cells, place in the cell, mass matrix and functions
    block   acceleration of a block on a slope
    discs   two discs that meet at two speeds
    hertz   contact of a disc on a large body
    drop    K_I(t) of a notched beam on which a weight falls, over the cell and where in a cell the crack is

Run by .venv/bin/python bench/body_contact.py, or for some parts: .venv/bin/python bench/body_contact.py bars --output DIR
"""

import math
import tempfile
from pathlib import Path

import body_contact_scenes as scenes
import numpy as np
from tables import command_line, write

CPDI = "method.shape_functions='cpdi'"
WEIGHTED = "method.mass='weighted'"
BARS = [(25, ()), (50, ()), (100, ()), (25, (WEIGHTED,)), (50, (WEIGHTED,)), (100, (WEIGHTED,)), (50, (CPDI,)), (50, (CPDI, WEIGHTED)), (100, (CPDI, WEIGHTED)),
        (50, ("method.mass='consistent'",)), (50, ("method.mass='fmpm'",))]
PHASES = (0.0, 0.13, 0.25, 0.5, 0.77)
HERTZ = [(16, 0.2, 0.0, ()), (24, 0.16, 0.0, ()), (24, 0.16, 0.4, ()), (48, 0.16, 0.0, ()), (16, 0.2, 0.0, (CPDI,)), (24, 0.16, 0.0, (CPDI,)),
         (24, 0.16, 0.4, (CPDI,))]


def shown(options):
    """Options as a cell of a table."""
    return " ".join(option.split("=")[1].strip("'") for option in options) or "lumped, linear"


def bars(program, folder):
    """The least and the greatest over where in a cell the bars meet."""
    yield "cells", "method", "restitution", "time of contact/2", "onset [cells]", "energy", "contact loss"
    for cells, options in BARS:
        found = [scenes.bars(program, folder, cells, phase, options=options) for phase in PHASES]
        yield cells, shown(options), *(" to ".join(f"{limit(row[name] for row in found):.4f}" for limit in (min, max)) for name in found[0])


def block(program, folder):
    """Asked and measured accelerations."""
    yield "contact", "method", "acceleration", "exact", "force along over normal", "way"
    for contact, friction in (("'friction' friction = 0.3", 0.3), ("'frictionless'", 0.0), ("'friction' friction = 1.0", None), ("'stick'", None)):
        for options in ((), (CPDI,)):
            found = scenes.block(program, folder, contact, end=0.1, options=options)
            slope = math.radians(30)
            exact = 0 if friction is None else 10 * (math.sin(slope) - friction * math.cos(slope))
            yield contact, shown(options), f"{found['acceleration']:.4f}", f"{exact:.4f}", f"{found['ratio']:.5f}", f"{found['way']:.5f}"


def discs(program, folder):
    """What has become of the energies of two discs."""
    yield "speed", "cell", "method", "least kinetic energy", "kinetic at the end", "strain at the end", "contact loss", "restitution"
    for v, end in ((0.1, 4.0), (0.02, 16.0)):
        for h, options in ((0.05, ()), (0.025, ()), (0.05, (CPDI,)), (0.025, (CPDI,))):
            found, restitution = scenes.discs(program, folder, h, v, end=end, options=options)
            kinetic = found["kinetic_energy"] / found["kinetic_energy"][0]
            strain, loss = (found[name][-1] / found["kinetic_energy"][0] for name in ("strain_energy", "contact_loss"))
            yield v, h, shown(options), *(f"{value:.3f}" for value in (kinetic.min(), kinetic[-1], strain, loss, restitution))


def hertz(program, folder):
    """Half-width, pressure and stress over Hertz's."""
    yield "cells to the half-width", "surface in the cell", "method", "half-width", "pressure", "error of the stress", "force"
    for cells, a, phase, options in HERTZ:
        found = scenes.hertz(program, folder, cells, a, phase, options=options)
        yield f"{a * cells:.1f}", phase, shown(options), *(f"{value:.3f}" for value in found.values())


def drop(program, folder):
    """Differences of K_I(t) from that of the finest cells, over its greatest value."""
    yield "cell [mm]", "crack", "contact from [us]", "K_I from [us]", "greatest K_I [MPa sqrt(m)]", "rms difference"
    runs = [(5e-3, 0.0), (2.5e-3, 0.0), (2.5e-3, 0.4), (1.25e-3, 0.4), (1.25e-3, 0.0)]
    rows = []
    for cell, phase in runs:
        crack = f"kind = 'path' points = {phase * cell}, -0.01, {phase * cell}, 0.02"
        history, touch = scenes.drop(program, folder, cell, crack=crack)
        rows.append((cell, phase, history))
    last = rows[-1][2]
    after = last["time"] > touch
    for cell, phase, history in rows:
        k = np.interp(last["time"], history["time"], history["K_I"])
        pressed = history["time"][np.abs(history["contact_force_y"]) > 0][0]
        begins = history["time"][np.abs(history["K_I"]) > 0.02 * history["K_I"].max()][0]
        rms = np.sqrt(np.mean((k - last["K_I"])[after] ** 2)) / last["K_I"].max()
        yield (f"{cell * 1e3:g}", f"{phase} cells beside a grid line", f"{pressed * 1e6:.2f}", f"{begins * 1e6:.2f}", f"{k.max() / 1e6:.3f}",
               f"{rms:.4f}")


if __name__ == "__main__":
    arguments = command_line(__doc__, ["bars", "block", "discs", "hertz", "drop"], "results/contact")
    for part in arguments.part:
        with tempfile.TemporaryDirectory() as folder:
            write(list(globals()[part](arguments.program.resolve(), Path(folder))), part, arguments.output)
