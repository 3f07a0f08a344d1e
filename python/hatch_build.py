"""What is built with the package: both programs for a wheel, of the sources in the folder above, or in an archive of sources beside this file.

HAMPM_PURE=1 leaves the programs out. Then the wheel is for any machine, and the programs are those of HAMPM and HAMPM3D or in PATH.
"""

import os
import re
import shutil
import subprocess
import sysconfig
import tempfile
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PROGRAMS = {"hampm": ("build/release/hampm", "dim=2"), "hampm3d": ("build/release3d/hampm3d", "dim=3")}
IN_ARCHIVE = "program"      # folder of an archive with the sources of the programs
SOURCES = ("Makefile", "src/**/*.f90", "src/**/*.c", "tools/depends.awk", "tools/setup.sh", "tools/version.sh")
PURE = "HAMPM_PURE=1 leaves the programs out"


class ProgramsHook(BuildHookInterface):
    """Builds the programs, or packs their sources."""

    def initialize(self, version, build_data):
        self.scratch = tempfile.TemporaryDirectory()
        if self.target_name == "sdist":
            build_data["force_include"].update(self.packed(self.sources()))
        elif version == "standard" and os.environ.get("HAMPM_PURE", "0") in ("", "0"):
            sources = self.sources()
            build_data["pure_python"] = False
            build_data["tag"] = "py3-none-" + re.sub(r"[-.]", "_", sysconfig.get_platform())
            for name, (path, dimensions) in PROGRAMS.items():
                self.build(sources, path, dimensions)
                build_data["force_include"][str(sources / path)] = f"hampm/bin/{name}"
                script = Path(shutil.copy(Path(self.root, "start.py"), Path(self.scratch.name, name)))
                script.chmod(0o755)
                build_data["shared_scripts"][str(script)] = name

    def finalize(self, version, build_data, artifact_path):
        self.scratch.cleanup()

    def sources(self):
        """The folder with the sources of the programs."""
        for folder in (Path(self.root, IN_ARCHIVE), Path(self.root).parent):
            if all((folder / name).is_file() for name in ("Makefile", "src/main.f90", "tools/setup.sh")):
                return folder
        self.fail(f"the sources of the programs are neither in {IN_ARCHIVE} nor in the folder above {self.root}; {PURE}")

    def packed(self, sources):
        """File -> its place in an archive. The commit is that of the checkout: VERSION has it there as in `git archive`."""
        files = {str(file): f"{IN_ARCHIVE}/{file.relative_to(sources)}" for pattern in SOURCES for file in sorted(sources.glob(pattern))}
        release, _, commit = subprocess.run([sources / "tools/version.sh"], check=True, capture_output=True, text=True).stdout.strip().partition(" (")
        version = Path(self.scratch.name, "VERSION")
        version.write_text(f"{release}\n{commit.removesuffix(')')}\n")
        return files | {str(version): f"{IN_ARCHIVE}/VERSION"}

    def build(self, sources, path, dimensions):
        """A program by make, which leaves alone what is built already."""
        if not (sources / path).exists():
            self.refuse_without(sources)
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
        # Flags of a make that has started this one are not for it
        environment = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
        command = ["make", f"-j{cores}", "--no-print-directory", "-C", str(sources), "program", "build=release", dimensions]
        if subprocess.run(command, env=environment).returncode != 0 or not (sources / path).is_file():
            self.fail(f"{' '.join(command)} has failed; {PURE}")

    def refuse_without(self, sources):
        """Compiler and libraries are those of tools/setup.sh, but for libraries that are named by hand."""
        script = sources / "tools/setup.sh"
        needed = re.search(r'^packages="(.*)"$', script.read_text(), re.MULTILINE)[1].split()
        if {"HDF5_LINK", "ALGEBRA_LINK"} <= os.environ.keys():
            needed = ["gfortran", "make"]
        listed = subprocess.run(["sh", str(script), "--check"], capture_output=True, text=True).stdout.split()
        missing = [name for name in needed if name in listed]
        if missing:
            self.fail(f"missing to build the programs: {' '.join(missing)} (names of packages in Debian); {PURE}")

    def fail(self, message):
        self.app.abort(f"hampm: {message}")
