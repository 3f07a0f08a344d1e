"""What namelists and command lines say, read a second time: written from the documentation, not from the program.

A namelist is `&group key = value, value ... /`. Values are words or texts in quotes, `3*0.5` repeats one, a comment goes from `!` to
the end of the line. Nothing before a comma, and a repeat `3*` of nothing, are null values: such a one is the default of its place, and a key
that has no others is not given. Names and choices do not depend on case. What this reader refuses the program must refuse too; what the
program accepts must have the values that this reader finds.
"""

import re
import struct

GAP = re.compile(rb"(?:[ \t\r\n]|![^\n]*)*")
NAME = re.compile(rb"[A-Za-z0-9_]*")
KEY = re.compile(rb"([A-Za-z][A-Za-z0-9_]*)(?:[ \t\r\n]|![^\n]*)*=")
WORD = re.compile(rb"[^ \t\r\n,/!='\"&]+")
QUOTED = re.compile(rb"'((?:[^'\n]|'')*)'|\"((?:[^\"\n]|\"\")*)\"")
REPEAT = re.compile(rb"([0-9]+)\*(.*)", re.DOTALL)
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([ed][+-]?\d+)?", re.IGNORECASE)
LOGICAL = {word: truth for truth, letter in ((True, "true"), (False, "false")) for word in (letter, letter[0], f".{letter}.", f".{letter[0]}.")}
OVERRIDE = re.compile(rb"\s*(\w+)\s*(?:\((\d+)\))?\s*\.\s*(\w+)\s*=(.*)", re.DOTALL)


class Refused(Exception):
    """The text is no namelist, or one with names that do not exist."""


class Keys:
    """The groups and keys that there are, from what `hampm --template` prints."""

    LINE = re.compile(r"   (\w+) =(.*?) ! (.*)")

    def __init__(self, template):
        self.kind, self.default, self.repeats, self.free_text = {}, {}, set(), set()
        self.groups = []
        for line in template.splitlines():
            line = re.sub(r"^! (   |&|/)", r"\1", line)  # groups that go with other choices only are printed as comments
            if line.startswith("&"):
                group = line[1:].split()[0]
                self.groups.append(group)
                if "several times" in line:
                    self.repeats.add(group)
            elif found := self.LINE.match(line):
                key, value, meaning = found.groups()
                last = re.split(r"; ", meaning)
                self.kind[group, key] = "logical" if ".true. | .false." in meaning else "text" if "'" in value or last[-1] == "text" or "; text" in meaning or " | " in last[-1] else \
                    "integer" if "; integer in" in meaning else "real"
                if "text" in last:
                    self.free_text.add((group, key))
                self.default[group, key] = last[-1][8:] if last[-1].startswith("default ") else ""

    def of(self, group):
        return [key for of, key in self.kind if of == group]


NULL = b"", False


def set_nulls(settings, group, keys):
    """The settings of a group without keys that have null values only; else these are the defaults."""
    left = {key: listed for key, listed in settings.items() if any(one != NULL for one in listed)}
    for key, listed in left.items():
        default = values(keys.default[group, key].encode(), 0, group, keys)[0]
        left[key] = [default[k] if one == NULL and k < len(default) else one for k, one in enumerate(listed)]
        if NULL in left[key]:
            raise Refused("no default")
    return left


def values(text, at, group, keys):
    """The values that begin at a place, as pairs (text, quoted), and where they end."""
    found, comma = [], True
    while True:
        at = GAP.match(text, at).end()
        if at == len(text) or text[at:at + 1] in b"/&=" or KEY.match(text, at):
            return found, at
        if text[at:at + 1] == b",":
            if comma:
                found.append(NULL)
            comma, at = True, at + 1
            continue
        comma, times, word = False, 1, b""
        if match := WORD.match(text, at):
            word, at = match[0], match.end()
            if repeat := REPEAT.fullmatch(word):
                times, word = int(repeat[1]), repeat[2]
                if not 1 <= times <= 1000:
                    raise Refused("count of a repeat")
                if not word:
                    match = None
                    if text[at:at + 1] not in (b"'", b'"'):
                        found += times * [NULL]
                        continue
        if not match:
            match = QUOTED.match(text, at)
            if not match:
                raise Refused("no value")
            quote = match[0][:1]
            found += times * [(match[0][1:-1].replace(2 * quote, quote), True)]
            at = match.end()
        else:
            if word.lower().decode("latin-1") in keys.of(group):
                raise Refused("a key without =")
            found += times * [(word, False)]
        if len(found) > 3000:
            raise Refused("too many values")


def groups_of(text, keys):
    """The groups of a namelist in their order, as pairs (name, {key: values})."""
    at, found = 3 if text.startswith(b"\xef\xbb\xbf") else 0, []
    while (at := GAP.match(text, at).end()) < len(text):
        if text[at:at + 1] != b"&":
            raise Refused("text outside of groups")
        match = NAME.match(text, at + 1)
        group, at, settings = match[0].lower().decode(), match.end(), {}
        if group not in keys.groups or group not in keys.repeats and group in (name for name, _ in found):
            raise Refused(f"group {group}")
        while (at := GAP.match(text, at).end()) < len(text) and text[at:at + 1] != b"/":
            match = KEY.match(text, at)
            if not match:
                raise Refused("no key")
            key = match[1].lower().decode()
            if (group, key) not in keys.kind or key in settings:
                raise Refused(f"key {key}")
            settings[key], at = values(text, match.end(), group, keys)
        if at == len(text):
            raise Refused("no end of a group")
        at += 1
        found.append((group, settings))
    return found


def override(found, text, keys):
    """Apply `group(2).key=value`."""
    match = OVERRIDE.fullmatch(text)
    if not match:
        raise Refused("form of an override")
    group, number, key, value = match[1].lower().decode("latin-1"), match[2], match[3].lower().decode("latin-1"), match[4]
    if (group, key) not in keys.kind:
        raise Refused("name in an override")
    of_name = [settings for name, settings in found if name == group]
    if not of_name and number in (None, b"1"):
        found.append((group, {}))
        of_name = [found[-1][1]]
    if number is None and len(of_name) > 1 or not 0 < int(number or 1) <= len(of_name):
        raise Refused("which group")
    if keys.kind[group, key] == "text" and key != "estimators" and value.strip()[:1] not in (b"'", b'"'):
        listed = [(value.strip(), True)]
    else:
        listed, end = values(value, 0, group, keys)
        if end < len(value):
            raise Refused("values of an override")
        if keys.kind[group, key] == "text":
            listed = [one if one == NULL else (one[0], True) for one in listed]
    of_name[int(number or 1) - 1][key] = listed


def meaning(value, kind, choice_or_text):
    """A value as something to compare."""
    text, quoted = value[0].decode("latin-1"), value[1]
    if kind == "text":
        if not quoted:
            raise Refused("text without quotes")
        text = text.rstrip(" ")
        return text.lower() if choice_or_text else text
    if kind == "logical":
        if quoted or text.lower() not in LOGICAL:
            raise Refused("neither true nor false")
        return LOGICAL[text.lower()]
    if quoted or not NUMBER.fullmatch(text) or kind == "integer" and not re.fullmatch(r"[+-]?\d+", text):
        raise Refused("no number")
    return int(text) if kind == "integer" else float(re.sub("[dD]", "e", text))


def resolved(group, key, given):
    """Whether the program puts something else in the place of a value."""
    return (group, key) == ("crack", "direction") or \
        (group, key) in {("output", "history_interval"), ("method", "courant"), ("method", "time_step")} and given in ([], [0.0]) or \
        group == "method" and key in ("solver", "mass") and given == ["auto"] or \
        (group, key) == ("output", "file") and given == []


def differences(text, overrides, as_used, keys):
    """What a scene as it is understood has that the text does not say; raises `Refused` where the text says nothing valid."""
    wanted = groups_of(text, keys)
    for one in overrides:
        override(wanted, one, keys)
    wanted = [(group, set_nulls(settings, group, keys)) for group, settings in wanted]
    used = groups_of(as_used, keys)
    for group in ("damping", "contact", "method", "energy_release", "output"):
        if group not in (name for name, _ in wanted):
            wanted.append((group, {}))
    wanted.sort(key=lambda one: keys.groups.index(one[0]))
    if [name for name, _ in wanted] != [name for name, _ in used]:
        return ["other groups"]
    wrong = []
    is_static = any(group == "method" and shown["time"] == [(b"static", True)] for group, shown in used)
    for (group, asked), (_, shown) in zip(wanted, used):
        if list(shown) != keys.of(group):
            wrong.append(f"keys of {group}")
            continue
        for key in keys.of(group):
            kind, is_choice = keys.kind[group, key], (group, key) not in keys.free_text
            def read(listed, kind=kind, is_choice=is_choice):
                return [meaning(value, kind, is_choice) for value in listed]
            given = read(asked[key]) if key in asked else read(values(keys.default[group, key].encode(), 0, group, keys)[0])
            if key not in asked and keys.default[group, key] == "" and kind == "text" and (group, key) in keys.free_text:
                given = [] if key in ("file", "of") else [""]   # one is named after the model, the other a list
            if (group, key) == ("output", "history_interval") and is_static:   # a row is a load step
                continue
            if not resolved(group, key, given) and read(shown[key]) != given:
                wrong.append(f"{group} {key}: {given} became {shown[key]}")
    return wrong


TAKES_VALUE = {"--set", "--output", "--threads", "--resume", "--steps", "--time-limit"}
FLAGS = ["--force", "--check", "--template", "--keys", "--quiet", "--version", "--help"]
CHANGEABLE = (b"output.checkpoint_interval", b"output.checkpoint_steps")  # when a run is resumed


def command_line(arguments):
    """What a command line asks for, in the form of the driver's answer; raises `Refused`."""
    files, output, threads, flags, overrides, only_files = [], b"", b"0", set(), [], False
    resume, steps, limit = b"", 0, 0.0
    rest = list(arguments)
    while rest:
        argument = rest.pop(0)
        if only_files or not argument.startswith(b"-"):
            files.append(argument)
            continue
        if argument == b"--":
            only_files = True
            continue
        name, equals, value = argument.partition(b"=")
        name = name.decode("latin-1")
        if name in FLAGS and not equals:
            flags.add(name)
            continue
        if name not in TAKES_VALUE:
            raise Refused(f"option {name}")
        if not equals:
            if not rest or rest[0].startswith(b"--"):
                raise Refused("no value")
            value = rest.pop(0)
        if not value.strip(b" "):
            raise Refused("empty value")
        if name == "--output":
            output = value
        elif name == "--set":
            overrides.append(value)
        elif name == "--resume":
            resume = value
        elif name == "--steps":
            if not re.fullmatch(rb"\d{1,18}", value) or int(value) < 1:
                raise Refused("steps")
            steps = int(value)
        elif name == "--time-limit":
            limit = meaning((value, False), "real", False)
            if not 1e-100 <= limit < 1e100:
                raise Refused("time limit")
        elif re.fullmatch(rb"\d{1,6}", value) and int(value) <= 1024:
            threads = b"%d" % int(value)
        else:
            raise Refused("threads")
    if len(files) > 1 or any(not name.strip(b" ") for name in files):
        raise Refused("files")
    if resume and (files or "--check" in flags or
                   not all(one.lstrip(b" ").lower().startswith(CHANGEABLE) for one in overrides)):
        raise Refused("not with --resume")
    if not files and not resume and not flags & {"--template", "--keys", "--version", "--help"}:
        raise Refused("no file")
    shown = b"".join(b"1" if flag in flags else b"0" for flag in FLAGS)
    bits = struct.pack(">d", limit).hex().upper().encode()
    return b"\0".join([files[0] if files else b"", output, threads, resume, b"%d" % steps, bits, shown, *overrides])
