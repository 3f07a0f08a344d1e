"""Valid namelists and command lines, changed at random."""

import re

ODD_VALUES = """0 -0 1 -1 2 1e400 -1e400 1e30 -1e30 1e-30 1e29 9.9e29 1e-29 1e100 1e-100 1e99 nan NaN -inf inf Infinity 1d0 1.0D+3
1q0 2147483647 2147483648 -2147483648 99999999999999999999 1e9 3*1.0 2*0.5 2*'xy' 1000*0 1001*0 0*1 2* *3 3** 1;2 0x10 1_8 1.0_dp
.true. .false. t f T .true.x 1e 1e+ 1e- +1 ++1 +-1 -+1 1. .5 . - + e5 1.e5 .e5 1e5.0 1..2 1.2.3 1,5 1,,5 , ,1 1, 1/2 / & = ! 'x' "x"
'x "x 'x''y' "x""y" 'x"y' '' "" '/' '!' '&end' 'musl' 'USF' 'cg' 'direct' 'none' 'tip' 'gradient' 'zz' 'line' 'consistent' 'partial'
'local' 'total' 'xy' 'x' 'table' 'ramp' 'sine' 'point' 'traction' 'body' 'strain' (1,2) (1) 1e5d3 1e1e1 1-5 1+5 1e+-5 NULL null
0.30000000000000004 4.9e-324 1.7976931348623157e308 0.1e-2 00001 1e00005 0.05 0.01 0.1 1e-3 100 16 17 20 21""".split()
ODD_VALUES += ["1 2", "1\t2", "1\n2", "1e" + 300 * "0" + "5", "1e-" + 250 * "0" + "3", 85 * "9", "5" + 78 * "0", 400 * "x",
               "'" + 1100 * "x" + "'", "1 ! 2", "1\r\n", "1e5\0", "\u00b5", "1\u00a0", "'\u00e9'", "1\v2", "5" + 25 * "0" + "e-25",
               "0." + 60 * "0" + "1e60", "1\\", "'a\\'b'", "'a' 'b'", "'vcct', 'domain_integral'", "'vcct'\"zz\""]
ODD_BYTES = [b"\0", b"\t", b"\n", b"\r", b"\x0b", b"\x1a", b" ", b"!", b"'", b'"', b"/", b"&", b"=", b",", b"*", b"(", b")", b"%", b".",
             b"0", b"9", b"e", b"-", b"+", b"\x7f", b"\x80", b"\xa0", b"\xff", b"\xef\xbb\xbf", b"$", b";", b"_", b"&end", b"/\n&run"]
ODD_LINES = ["&end", "$end", "/", "&run /", "&grid cell = 1 cells = 1, 1 /", "&load /", "&crack tip = 0.05, 0.0 /", "! comment / & ' =",
             "&refine indicator = 'tip' max_level = 2 /", "&refine indicator = 'zz' max_level = 3 /", "  cell(1) = 1.0", "  cell%x = 1.0",
             "&damping rate = 1 / &damping rate = 2 /", "&method mass = 'consistent' solver = 'direct' /", "&body / &body /", "title = 'x'"]

EXTREMES = [f"{sign}{digit}e{power}" for sign in ("", "", "-") for digit in (1, 9.99) for power in (-99, -30, -29, 15, 29, 30, 98, 99)]

ASSIGNMENT = re.compile(r"(\b[a-z_]+ *= *)((?:'[^'\n]*'|[^'\n=/!,\s]+)(?:(?: *, *| +)(?:'[^'\n]*'|[^'\n=/!,\s]+)(?! *=))*)")
NUMBER = re.compile(r"(?<![\w.'])[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\w.'])")
TOKEN = re.compile(r"'[^'\n]*'|[\w.+*-]+|\s+|.")


def number(random):
    """A number as someone might write it."""
    value = random.choice([random.uniform(-2, 2), 10 ** random.uniform(-32, 32), random.randint(-5, 300), random.gauss(0, 1e-3)])
    return random.choice(["{!r}", "{:.3e}", "{:.17g}", "{:.0f}", "{:.2f}"]).format(value)[:80]


def value(text, random):
    """Another value for a key."""
    found = list(ASSIGNMENT.finditer(text))
    if not found:
        return text
    one = random.choice(found)
    new = random.choice(ODD_VALUES) if random.random() < 0.8 else number(random)
    old = one[2].split(",")
    if len(old) > 1 and random.random() < 0.7:
        old[random.randrange(len(old))] = " " + new
        new = ",".join(old)
    return text[:one.start(2)] + new + text[one.end(2):]


def scale(text, random):
    """Another number in the place of one, of a like size."""
    found = list(NUMBER.finditer(text))
    if not found:
        return text
    one = random.choice(found)
    changed = float(one[0]) * random.choice([2, 0.5, 10, 0.1, -1, 3, 1 + 1e-9, 1e6, 1e-6, 1e25])
    new = str(round(changed)) if re.fullmatch(r"\d+", one[0]) and random.random() < 0.7 else repr(changed)
    return text[:one.start()] + new + text[one.end():]


def extreme(text, random):
    """Numbers of any size in the place of several."""
    for one in random.sample(list(NUMBER.finditer(text)), k=1)[:1] if NUMBER.search(text) else []:
        text = text[:one.start()] + random.choice(EXTREMES) + text[one.end():]
        if random.random() < 0.6:
            return extreme(text, random)
    return text


def byte(text, random):
    """A few bytes removed, inserted or replaced."""
    text = text.encode()
    for _ in range(random.choice([1, 1, 1, 2, 5])):
        at, new = random.randrange(len(text) + 1), random.choice(ODD_BYTES)
        if random.random() < 0.3:
            new = bytes([random.randrange(256)])
        text = text[:at] + random.choice([new, new, b""]) + text[at + random.choice([0, 1]):]
    return text


def token(text, random):
    """Tokens removed, doubled, swapped or taken from elsewhere."""
    tokens = TOKEN.findall(text)
    i, j = random.randrange(len(tokens)), random.randrange(len(tokens))
    what = random.randrange(4)
    if what == 0:
        del tokens[i]
    elif what == 1:
        tokens.insert(i, tokens[i])
    elif what == 2:
        tokens[i], tokens[j] = tokens[j], tokens[i]
    else:
        tokens[i] = tokens[j]
    return "".join(tokens)


def line(text, random):
    """Lines removed, doubled, moved, joined or put in."""
    lines = text.split("\n")
    i, j = random.randrange(len(lines)), random.randrange(len(lines))
    what = random.randrange(6)
    if what == 0:
        del lines[i]
    elif what == 1:
        lines.insert(j, lines[i])
    elif what == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif what == 3 and i + 1 < len(lines):
        lines[i:i + 2] = [lines[i] + " " + lines[i + 1]]
    elif what == 4:
        lines.insert(i, random.choice(ODD_LINES))
    else:
        lines[i] = lines[i].upper()
    return "\n".join(lines)


def cut(text, random):
    """The beginning of the text."""
    return text[:random.randrange(len(text))]


def bulk(text, random):
    """Very much of something at some place."""
    at = random.randrange(len(text))
    what = random.choice(["x", " ", "1 ", "1,", "''", "'", "!", "&", "/", "\n", "a=1 ", "&load / ", "3*1 ", "=", "(", "\t", "é"])
    return text[:at] + what * random.choice([10, 100, 1000, 3000]) + text[at:]


def style(text, random):
    """The same, written in another way."""
    def rewritten(match):
        word = match[0]
        exponent = random.choice("eEdD")
        if re.fullmatch(r"\d+", word):
            return random.choice([word, "+" + word, "0" + word])
        whole, _, power = word.lower().partition("e")
        if "." not in whole and random.random() < 0.5:
            whole += "."
        if "." in whole and random.random() < 0.3:
            whole += "00"
        return f"{whole}{exponent}{power or random.choice(['0', '+0', '-00'])}" if power or random.random() < 0.5 else whole

    pieces = []
    for k, piece in enumerate(re.split(r"('(?:[^'\n]|'')*'|![^\n]*)", text)):
        if k % 2 and piece.startswith("!"):
            piece = random.choice([piece, "", "! ' / & = \""])
        elif k % 2:
            if '"' not in piece and random.random() < 0.5:
                piece = '"' + piece[1:-1].replace("''", "'") + '"'
        else:
            piece = NUMBER.sub(rewritten, piece)
            piece = re.sub(r"[a-z_]{2,}", lambda m: random.choice([m[0], m[0].upper(), m[0].capitalize()]), piece)
            piece = re.sub(" *, *", lambda m: random.choice([",", " , ", ",\n  ", "\t", ", ! , \n"]), piece)
            piece = re.sub(" *= *", lambda m: random.choice(["=", " = ", "\t=\n", " ! = 1\n = "]), piece)
        pieces.append(piece)
    text = "".join(pieces)
    if random.random() < 0.3:
        text = text.replace("\n", "\r\n")
    text = text.encode()
    return b"\xef\xbb\xbf" + text if random.random() < 0.2 else text


KINDS = {"value": value, "number": scale, "extreme": extreme, "byte": byte, "token": token, "line": line, "cut": cut, "bulk": bulk, "style": style}
WEIGHTS = {"value": 6, "number": 4, "extreme": 2, "byte": 3, "token": 3, "line": 3, "cut": 1, "bulk": 0.3, "style": 2, "override": 3, "arguments": 3}

KEY_NAMES = """run.title run.end_time run.plane grid.cell grid.cells grid.lower material.young material(1).name material(2).young
body.upper body.points_per_cell load.force load(1).kind load(2).force constraint.fix damping.rate method.scheme method.mass
method.courant method.order refine.indicator refine.max_level crack.tip crack.length energy_release.estimators energy_release.radii
output.file output.history_interval output.snapshot_interval GRID.CELL grid.cel grd.cell grid cell .cell grid. body(0).upper
body(x).upper body().upper body(1.upper body(99999999).upper""".split()


def override(random):
    """The value of an option --set."""
    text = random.choice(KEY_NAMES) + random.choice(["=", "=", "=", "=", "=", " = ", "", "=="])
    for _ in range(random.choice([0, 1, 1, 1, 2])):
        text += random.choice(ODD_VALUES) if random.random() < 0.7 else number(random)
    return text.replace("\0", "").encode()


ARGUMENTS = """--check --template --keys --quiet --version --help --set --output --threads --threads=2 --threads=-1 --threads=1025 --threads=
--threads=1e1 --threads=00001 --threads=0000001 --output= --output=. --output=/dev/null --set= --set=grid.cell=1 --set=x --check=1
--chek --Check -h -v - -- --- -x --set=grid.cell --= = case.nml ./case.nml /tmp /etc/shadow /dev/zero 0 1 4 1024 1025 run.title=x
--output=a=b --quiet= --force --force=1 --resume --resume=x.checkpoint --resume= --steps --steps=10 --steps=0 --steps=1e3
--steps=999999999999999999 --steps=1000000000000000000 --time-limit --time-limit=3600 --time-limit=1.5d1 --time-limit=-1
--time-limit=1-5 --time-limit=1e400 --time-limit=.5 --time-limit=x --set=output.checkpoint_steps=5
--set=OUTPUT.checkpoint_interval=1""".split() + ["", " ", "   ", "case.nml ", 300 * "x", "\n", "a b", "é", "\x01", "--set=run.title= a "]


def arguments(random):
    """The arguments of a command line."""
    return [random.choice(ARGUMENTS).encode() if random.random() < 0.9 else override(random)
            for _ in range(random.choice([0, 1, 2, 2, 3, 3, 4, 6]))]
