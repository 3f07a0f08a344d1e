"""Models: the groups of a namelist, read, changed, checked and written."""

import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from .errors import FileError, HampmWarning, Message, error_of
from .groups import Groups
from .namelist import Group, GroupList, RunGroup, places, shown
from .program import call, find_program, key_table, messages_of
from .schema import mistakes
from .tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OWN = "path", "program", "_entries", "_implied"   # attributes of a scene that are no groups


class Scene(Groups):
    """A model, as a namelist describes it.

    Its groups are attributes: `scene.grid.cell = 1e-3`, and lists of those that may stand several times: `scene.load[0].force`,
    `scene.load.add(kind="traction", ...)`. A group that is not there is added when it is asked for; one that stays empty is not written. Numbers are in SI units.
    Which groups and keys there are is what `hampm --keys --json` says; others are an `AttributeError` at once, and values that are not
    allowed a `ModelError` of `check()`. The group &run can be called, too: `scene.run(output="results")` runs the model, as `hampm.run` does.

    path     of the namelist that was read, None where there is none
    program  the program that checks and runs the model; None: the one that `find_program` finds, by the dimensions of its grid
    """

    def __init__(self, path: str | Path | None = None, *, text: str | None = None, program: str | Path | None = None):
        self.path = Path(path) if path is not None else None
        self.program = program
        self._entries: list[Group] = []   # all groups, in their order
        self._implied: list[Group] = []   # those that have only been asked for
        if text is None and self.path is not None:
            try:
                text = self.path.read_text()
            except UnicodeDecodeError as error:
                raise FileError([Message("not a text", file=str(self.path))]) from error
        groups = _read(text or "", path or "text")
        found = places(text or "", str(path or "text"))
        for number, (name, values) in enumerate(groups):
            group = self.add(name, **values)
            if len(found) == len(groups):
                object.__setattr__(group, "_places", found[number])

    @classmethod
    def template(cls, program: str | Path | None = None) -> "Scene":
        """The model that `hampm --template` prints, with every key."""
        return cls(text=call(["--template"], program)[1], program=program)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        known = key_table(self.program)
        if name.lower() not in known:
            raise AttributeError(_unknown_group(name, known))
        found = self._groups_of(name)
        if known[name.lower()]["repeats"]:
            return GroupList(self, name, found)
        if not found:
            found = [self.add(name)]
            self._implied.append(found[0])
        return found[0]

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in OWN:
            first = next(iter(getattr(self, name)._keys)) if not isinstance(getattr(self, name), GroupList) else "add(...)"
            raise AttributeError(f"&{name} is a group: set its keys, such as scene.{name}.{first}")
        object.__setattr__(self, name, value)

    def __delattr__(self, name: str) -> None:
        self._entries = [group for group in self._entries if group._name != name.lower()]

    def __dir__(self) -> list[str]:
        return [*key_table(self.program), *object.__dir__(self)]

    __getitem__ = __getattr__

    def add(self, name: str, /, **values: Any) -> Group:
        """Add a group with these keys. Returns it."""
        name = name.lower()
        known = key_table(self.program)
        if name not in known:
            raise AttributeError(_unknown_group(name, known))
        if self._groups_of(name) and not known[name]["repeats"]:
            raise AttributeError(f"&{name} may stand only once, and is there")
        group = (RunGroup if name == "run" else Group)(name, known[name]["keys"], {}).set(**values)
        if isinstance(group, RunGroup):
            object.__setattr__(group, "_scene", self)
        self._entries.append(group)
        return group

    def with_settings(self, settings: Mapping[str, Any]) -> "Scene":
        """A copy of the model with other values: {"grid.cell": 1e-3, "load(2).force": (0, 1)}, as `--set` takes them."""
        other = self.copy()
        for place, value in settings.items():
            group, _, key = place.partition(".")
            name, _, number = group.partition("(")
            found = other._groups_of(name.lower()) or [other.add(name)]
            if len(found) > 1 and not number:
                raise AttributeError(f"'{place}': there are {len(found)} of &{name}; say which, such as {name}(2).{key}")
            index = int(number.rstrip(")")) if number else 1
            if not 1 <= index <= len(found):
                raise AttributeError(f"'{place}': there is no &{group}")
            found[index - 1][key] = value
        return other

    def with_accuracy(self, errors: Mapping[str, float], at: str = "end") -> "Scene":
        """A copy of the model that asks for these errors, {"K_I": 0.01}: what it leaves out of cells, levels and steps is chosen by the program."""
        other = self.copy()
        for quantity, error in errors.items():
            other.add("accuracy", quantity=quantity, error=error, at=at)
        return other

    def copy(self) -> "Scene":
        """A copy, which changes by itself."""
        other = Scene(program=self.program)
        other.path = self.path
        pairs = [(group, group._copy(other)) for group in self._entries]
        other._entries = [copied for _, copied in pairs]
        other._implied = [copied for group, copied in pairs if any(group is one for one in self._implied)]
        return other

    def __deepcopy__(self, memo: object) -> "Scene":
        return self.copy()

    def dimensions(self) -> int:
        """3 for a solid, whose grid has three numbers of cells, or whose bodies have places of three, else 2."""
        places = [values for name, keys in (("grid", ("cells", "lower")), ("body", ("lower", "center"))) for group in self._groups_of(name)
                  for values in (group[key] for key in keys)]
        return 3 if any(isinstance(values, (list, tuple)) and len(values) == 3 for values in places) else 2

    def found_program(self) -> Path:
        """The program that checks and runs the model."""
        return find_program(self.program, self.dimensions())

    def result_name(self) -> str:
        """Name of the result file of a run."""
        own = self._groups_of("output")
        return (own[0].file if own else None) or (self.path.stem if self.path else "model") + ".h5"

    def write(self, path: str | Path) -> None:
        """Write the namelist. Comments of the one that was read are not kept."""
        Path(path).write_text(str(self))

    def check(self, warn: bool = True) -> "Check":
        """Let `hampm --check --json` look at the model, and tell what a run would do and need. Raises `ModelError` with all mistakes.

        Messages name the line in which the user has set a key, of the namelist that was read or of a program in Python."""
        with TemporaryDirectory() as place:
            file = self._write_for(place)
            code, text, said = call(["--check", "--json", file], self.found_program())
        try:
            told = json.loads(text)
        except ValueError:
            raise error_of(code, messages_of(said)[0]) from None
        for kind in ("errors", "warnings", "notes"):
            told[kind] = [self._located(Message(**item), file) for item in told.get(kind, ())]
        if not told["valid"]:
            raise error_of(code, told["errors"])
        if warn:
            for message in told["warnings"]:
                warnings.warn(str(message), HampmWarning, stacklevel=2)
        return Check(**{name: told[name] for name in Check.__dataclass_fields__ if name in told})

    def sketch(self, **options: Any) -> "Figure":
        """A figure of bodies, cracks, supports and loads, before any run: `hampm.plot("sketch", ...)` with its options, such as grid=True."""
        from .plots import plot
        self.check(warn=False)
        with TemporaryDirectory() as place:
            return plot("sketch", self._write_for(place), **options)

    def _write_for(self, folder: str) -> Path:
        """The file of a model that is as it was read, else one in a folder."""
        if self.path is not None and self.is_as_read():
            return self.path
        file = Path(folder) / "model.nml"
        file.write_text(str(self))
        return file

    def _located(self, message: Message, file: Path) -> Message:
        """A message on the file of the model, where the user has written what it is about."""
        if file == self.path or message.file != str(file):
            return message
        begins = [number for number, line in enumerate(str(self).splitlines(), 1) if line.startswith("&")]
        number = sum(begin <= (message.line or 0) for begin in begins)
        if number == 0:
            return replace(message, file=str(self.path or "the model"), line=None)
        found = self._written()[number - 1]._places
        place = found.get(message.key.partition("(")[0].lower()) or found[""]
        return replace(message, file=place.file, line=place.line)

    def mistakes(self) -> list[Message]:
        """What keys break by themselves, by the JSON schema of models, without the program; `check()` tells all mistakes, and where they stand."""
        return list(mistakes([(group._name, dict(group.items())) for group in self._written()]))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self._written() == other._written()

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        text = StringIO()
        written = _f90nml().Namelist()
        for group in self._written():
            written.add_cogroup(group._name, dict(group.items()))
        written.write(text)
        return text.getvalue()

    __repr__ = __str__

    def _repr_html_(self) -> str:
        rows = [[f"&{group._name}", key, shown(value), group._keys[key]["unit"]] for group in self._written() for key, value in group.items()]
        return Table(("group", "key", "value", "unit"), rows)._repr_html_()

    def _written(self) -> list[Group]:
        """The groups but those that have only been asked for."""
        return [group for group in self._entries if group.items() or not any(group is other for other in self._implied)]

    def _groups_of(self, name: str) -> list[Group]:
        return [group for group in self._entries if group._name == name.lower()]

    def is_as_read(self) -> bool:
        """Whether the file that was read has the model as it is now."""
        try:
            return self.path is not None and Scene(self.path, program=self.program) == self
        except (OSError, FileError, AttributeError):
            return False

    def _remove(self, group: Group) -> None:
        self._entries = [other for other in self._entries if other is not group]


@dataclass(frozen=True)
class Check:
    """What a run of a model would do and need, as `hampm --check --json` says.

    particles, cells, occupied_cells  at the start
    steps, time_step                  number of time or load steps, and the longest of them [s]
    samples, snapshots                that the result will have
    memory, results                   memory of the run and size of its result [bytes]; `most_memory`, `most_results` with `most_particles`, to
                                      which cells may refine
    seconds                           of wall time on this machine with `threads`, from a few steps; None where it is not known
    tips                              of each crack tip its place (`x`, `y`) [m], `cell` [m], `radii` of its domains [m] and `expected_errors`,
                                      parts of the values
    G_ref                             reference energy release rate [J/m2], None where there is none
    namelist                          the model as it is used, with every key
    warnings, notes                   `Message`s
    """

    particles: int
    cells: int
    occupied_cells: int
    steps: int
    time_step: float
    samples: int
    snapshots: int
    memory: float
    most_memory: float
    results: float
    most_results: float
    most_particles: float
    tips: list[dict[str, Any]]
    threads: int
    namelist: str
    version: str
    seconds: float | None = None
    G_ref: float | None = None
    warnings: list[Message] = field(default_factory=list)
    notes: list[Message] = field(default_factory=list)

    def _table(self) -> Table[list[str]]:
        rows = [["particles", f"{self.particles}"], ["cells", f"{self.cells}, of which occupied {self.occupied_cells}"],
                ["steps", f"{self.steps}, of {self.time_step:.3g} s at most"], ["memory", f"{self.memory / 1e6:.3g} MB"],
                ["results", f"{self.results / 1e6:.3g} MB: {self.samples} samples, {self.snapshots} snapshots"],
                ["time on this machine", "not known" if self.seconds is None else f"{self.seconds:.2g} s, threads: {self.threads}"]]
        for number, tip in enumerate(self.tips, 1):
            errors = ", ".join(f"{name} {100 * part:.1f} %" for name, part in tip.get("expected_errors", {}).items())
            rows.append([f"tip {number}", f"({tip['x']:.6g}, {tip['y']:.6g}) m; expected errors: {errors or 'not known'}"])
        return Table(("", ""), [*rows, *([kind, str(message)] for kind in ("warning", "note") for message in getattr(self, kind + "s"))])

    def __str__(self) -> str:
        return str(self._table())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return self._table()._repr_html_()


def _f90nml() -> Any:
    try:
        import f90nml
    except ImportError as missing:
        raise ImportError(f"{missing}: models need f90nml: pip install f90nml") from missing
    return f90nml


def _read(text: str, source: str | Path) -> list[tuple[str, dict[str, Any]]]:
    """(name, {key: value}) of the groups of a namelist, in their order."""
    try:
        return [(name, dict(values)) for name, values in _f90nml().Parser().reads(text).items()] if text.strip() else []
    except (ValueError, StopIteration, IndexError, AttributeError, TypeError) as error:
        raise FileError([Message(f"no namelist that could be read ({error or 'it ends within a group'}); hampm --check says why",
                                 file=str(source))]) from error


def _unknown_group(name: str, known: Mapping[str, Any]) -> str:
    close = get_close_matches(name.lower(), known, 1)
    return f"there is no group &{name}" + (f"; did you mean '{close[0]}'?" if close else f"; groups are {', '.join(known)}")
