#!/bin/sh
# Build a wheel of the Python package with both programs and the libraries that they load in it, and print a table of sizes and times.
#
#     tools/wheel.sh                  build/wheel/hampm-*.whl, for every Linux whose glibc is not older than that of this machine
#     tools/wheel.sh --sdist          the same from an archive of sources, which is then beside it: both programs are built anew, in minutes
#     tools/wheel.sh --try [FOLDER]   and try it in a Debian that has Python alone: debootstrap makes one in a new folder (build/wheel_root),
#                                     which is removed at the end. Root and the network of packages are needed
#     tools/wheel.sh --in FOLDER      try the wheel of build/wheel in a bare root that is there already; it stays
#
# To try it is to install it by pip, with numpy, h5py and f90nml from the index, and to run models by both programs and from Python. Of
# this machine nothing is mounted in the folder, which is removed only when nothing is mounted below it.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
place=$root/build/wheel
venv=$place/venv
table=$place/table
log=$place/log
bare=
. "$root/tools/bare_debian.sh"

main() {
    mkdir -p "$place"
    : >"$table"
    : >"$log"
    trap finish EXIT
    trap 'exit 1' INT TERM HUP
    case ${1-} in
        '' | --sdist) build "${1-}" ;;
        --try)
            build
            step "a bare Debian" python_alone "${2:-$root/build/wheel_root}"
            try "$bare"
            ;;
        --in)
            [ -x "${2:?}/usr/bin/python3" ] || fail "$2: there is no /usr/bin/python3 in it"
            try "$2"
            ;;
        --help) usage ;;
        *)
            usage >&2
            exit 2
            ;;
    esac
}

usage() { sed -n '2,13s/^# \{0,1\}//p' "$0"; }

# step WHAT COMMAND...: run it; the table gets the seconds and the last line that it says. What it says is in the log, too.
step() {
    what=$1
    shift
    began=$(date +%s)
    if ! "$@" >"$place/said" 2>>"$log"; then
        cat "$place/said" >>"$log"
        row "$what" "$(($(date +%s) - began))" failed
        tail -n 20 "$log" >&2
        fail "$what: has failed; all that was said is in $log"
    fi
    cat "$place/said" >>"$log"
    row "$what" "$(($(date +%s) - began))" "$(tail -n 1 "$place/said")"
}

row() { printf '%s\t%s\t%s\n' "$@" >>"$table"; }

finish() {
    rm -f "$place/said"
    remove
    [ ! -s "$table" ] || awk -F '\t' 'BEGIN {print "| step | seconds | result |\n|---|---|---|"} {printf "| %s | %s | %s |\n", $1, $2, $3}' "$table"
}

# --- the wheel --------------------------------------------------------------------------------------------------------

build() {
    rm -rf "$place/built"
    rm -f "$place"/hampm-*
    step "what builds programs" compiler
    step "what builds wheels" tools
    if [ "${1-}" = --sdist ]; then
        step "archive of sources, and a wheel of it" built
        mv "$place"/built/hampm-*.tar.gz "$place"
    else
        step "a wheel" built --wheel
    fi
    step "with its libraries" repaired
    rm -r "$place/built"
}

compiler() {
    "$root/tools/setup.sh" program >&2
    gfortran --version | sed -n 1p
}

# The packages of requirements/wheel.txt, in an environment of their own.
tools() {
    if ! cmp -s "$root/requirements/wheel.txt" "$venv/wheel.txt"; then
        "${PYTHON:-python3}" -m venv --clear "$venv"
        "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$root/requirements/wheel.txt"
        cp "$root/requirements/wheel.txt" "$venv/wheel.txt"
    fi
    "$venv/bin/auditwheel" --version | sed -n '1s/ installed.*//p'
}

built() {
    "$venv/bin/python" -m build --no-isolation --outdir "$place/built" "$@" "$root/python" >&2
    megabytes "$place"/built/*
}

repaired() {
    PATH=$venv/bin:$PATH auditwheel repair --wheel-dir "$place" "$place"/built/hampm-*.whl >&2
    echo "$(megabytes "$place"/hampm-*.whl): $("$venv/bin/python" -m zipfile -l "$(wheel)" | sed -n 's/^hampm\.libs\/\(lib[a-z0-9]*\)-.*/\1/p' | paste -s -d ' ')"
}

wheel() {
    set -- "$place"/hampm-*.whl
    [ -f "$1" ] || fail "there is no wheel in $place: tools/wheel.sh builds one"
    echo "$1"
}

# Names and sizes of files.
megabytes() {
    for file; do
        echo "${file##*/} $(wc -c <"$file" | awk '{printf "%.1f MB", $1 / 1e6}')"
    done | paste -s -d ',' | sed 's/,/, /g'
}

# --- to try it --------------------------------------------------------------------------------------------------------

# try ROOT: install the wheel there, in an environment that is removed at the end, and run models.
try() {
    in=$1
    file=$(wheel)
    here=$in/tmp/hampm_wheel
    rm -rf "$here"
    mkdir -p "$here"
    cp "$file" "$root/input/edge_crack.nml" "$root/input/solid/beam.nml" "$here"
    python=/tmp/hampm_wheel/venv/bin/python
    step "pip install" there sh -c "python3 -m venv venv && $python -m pip install --quiet --disable-pip-version-check $(basename "$file") &&
        du -sm venv/lib/python*/site-packages/hampm* | awk '{sum += \$1} END {print sum \" MB installed\"}'"
    step "hampm --version" there venv/bin/hampm --version
    step "hampm3d --version" there venv/bin/hampm3d --version
    step "input/edge_crack.nml" there sh -c 'venv/bin/hampm edge_crack.nml --quiet && ls edge_crack.h5'
    step "input/solid/beam.nml" there sh -c 'venv/bin/hampm3d beam.nml --quiet && ls beam.h5'
    step "a model from Python" there $python -c 'if True:
        import hampm
        assert "/venv/lib/" in str(hampm.find_program()) and "/venv/lib/" in str(hampm.find_program(dimensions=3))
        print("J = {:.5g}, error {:.2g}".format(*hampm.run("edge_crack.nml", output="python", progress=False).value("J")))'
    rm -r "$here"
}

# there COMMAND...: in the folder of what is tried in the root $in.
there() { inside "$in" sh -c 'cd /tmp/hampm_wheel && export OMP_NUM_THREADS=2 && exec "$@"' sh "$@"; }

python_alone() {
    new_root "$1" bookworm --include=python3,python3-venv
    [ -z "$(find "$bare" -name 'libgfortran*' -o -name 'libmetis*' -o -name gfortran)" ] || fail "it has more than Python"
    echo "Debian bookworm with Python, without compiler and libraries"
}

main "$@"
