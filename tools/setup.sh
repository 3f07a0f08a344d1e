#!/bin/sh
# Install what hampm needs and what is missing: compiler and libraries, then the Python environment .venv.
#
#     tools/setup.sh              install all
#     tools/setup.sh PART...      install what parts of it need: run (draws and tabulates), batch (sweeps), docs (pages of modules),
#                                 test (run, batch and what tests need), verify (all: VTK, PyVista and NGSolve too),
#                                 program (compiler, libraries and a Python, without its packages)
#     tools/setup.sh valgrind     what test needs, and some package of the distribution, such as valgrind or flang-19
#     tools/setup.sh --check      only list what is missing; exit code 1 if anything is
#
# It says what it installs before it does. What is present is left alone, so that a second run does nothing and says nothing. On Debian and Ubuntu the packages are installed with
# apt-get, as root or through sudo; elsewhere, or without these rights, they are named and the exit code is 1. The Python packages of
# a part are those of requirements/PART.txt, in the versions of requirements.lock.
set -eu

packages="gfortran make liblapack-dev libopenblas-dev libsuitesparse-dev libarpack2-dev libhdf5-dev"
to_draw="gnuplot-nox"
root=$(cd "$(dirname "$0")/.." && pwd)
lock=$root/requirements.lock
of_test="run batch test"
all="run batch docs test verify"
parts=

# MB on the disk and seconds, measured on two cores: packages of Debian by what they bring beside those above them, parts likewise
costs="
gfortran 220 40
make 2 5
liblapack-dev 33 10
libopenblas-dev 98 15
libsuitesparse-dev 9 10
libarpack2-dev 1 3
libhdf5-dev 39 20
gnuplot-nox 66 40
python3 38 10
python3-venv 8 6
valgrind 80 10
flang-19 1080 120
libomp-19-dev 16 5
run 175 15
batch 130 40
docs 115 20
test 255 35
verify 620 30
"

main() {
    case "$*" in
        --check) check ;;
        --help) usage ;;
        *)
            understand "$@"
            install_packages
            install_python
            ;;
    esac
}

# Parts that are asked for, and further packages of the distribution.
understand() {
    for word in "$@"; do
        case $word in
            program) to_draw= ;;
            run | batch | docs) parts="$parts $word" ;;
            test) parts="$parts $of_test" ;;
            verify) parts=$all ;;
            valgrind) parts="$parts $of_test" packages="$packages valgrind" ;;
            flang-19) parts="$parts $of_test" packages="$packages flang-19 libomp-19-dev" ;;
            *)
                usage >&2
                exit 2
                ;;
        esac
    done
    [ $# -gt 0 ] || parts=$all
    # Each once, in the order of the table
    asked=" $parts " parts=
    for part in $all; do
        case $asked in *" $part "*) parts="$parts $part" ;; esac
    done
}

# What some packages or parts cost by the table, in words: about 300 MB, 2 minutes.
cost() {
    megabytes=0 seconds=0
    for name in "$@"; do
        set_cost "${costs#*"
$name "}"
    done
    if [ "$seconds" -lt 100 ]; then
        echo "about $megabytes MB, $seconds s"
    else
        echo "about $megabytes MB, $(((seconds + 30) / 60)) minutes"
    fi
}

# The first two numbers of a text are added to the sums.
set_cost() {
    line=${1%%"
"*}
    megabytes=$((megabytes + ${line% *})) seconds=$((seconds + ${line#* }))
}

usage() { sed -n '2,15s/^# \{0,1\}//p' "$0"; }

has_command() { command -v "$1" >/dev/null 2>&1; }

# --- packages ---------------------------------------------------------------------------------------------------------

missing_packages() {
    if has_command dpkg-query; then
        # shellcheck disable=SC2016 # dpkg-query fills these in
        installed=" $(dpkg-query -W -f '${Package}:${db:Status-Status} ' 2>/dev/null || true)"
    else
        installed=
    fi
    for package in $packages $to_draw; do
        is_present "$package" || echo "$package"
    done
    { [ -n "$parts" ] && python_is_ready; } || [ -n "$(find_python)" ] || printf '%s\n' python3 python3-venv
}

# A package counts as present when one that provides the same is.
is_present() {
    case $1 in
        gfortran | make | valgrind) has_command "$1" ;;
        flang-19) has_command flang-new-19 || has_command flang-19 || has_command flang-new || has_command flang ;;
        libomp-19-dev) any_installed libomp-19-dev libomp-dev ;;
        gnuplot-nox) has_command gnuplot ;;
        libopenblas-dev) any_installed libopenblas-dev libopenblas-openmp-dev libopenblas-pthread-dev || links openblas ;;
        liblapack-dev) any_installed liblapack-dev || links lapack ;;
        libsuitesparse-dev) any_installed libsuitesparse-dev || { links umfpack && links cholmod; } ;;
        libarpack2-dev) any_installed libarpack2-dev || links arpack ;;
        libhdf5-dev) any_installed libhdf5-dev || links hdf5 ;;
    esac
}

any_installed() {
    for name in "$@"; do
        case $installed in *" $name:installed "*) return 0 ;; esac
    done
    return 1
}

# Without dpkg-query: can an empty program be linked with this library?
links() {
    if has_command dpkg-query || ! has_command gfortran; then
        return 1
    fi
    scratch=$(mktemp -d)
    echo end >"$scratch/empty.f90"
    status=0
    gfortran "$scratch/empty.f90" -o "$scratch/empty" "-l$1" >/dev/null 2>&1 || status=1
    rm -r "$scratch"
    return $status
}

install_packages() {
    missing=$(missing_packages | tr '\n' ' ')
    [ -n "$missing" ] || return 0
    if ! has_command dpkg-query || ! has_command apt-get; then
        fail "missing: $missing" \
            "These are the names in Debian; install what provides them with the package manager of this system."
    elif [ "$(id -u)" = 0 ]; then
        apt env
    elif has_command sudo && sudo -n true 2>/dev/null; then
        apt sudo -n env
    elif has_command sudo && [ -t 0 ]; then
        apt sudo env
    else
        fail "missing: $missing" "Only root can install them: apt-get install --no-install-recommends $missing"
    fi
}

# Install $missing; the arguments are the command that apt-get is run through.
apt() {
    # shellcheck disable=SC2086 # a list of words
    echo "installing $(listed $missing) by apt-get: $(cost $missing)"
    "$@" DEBIAN_FRONTEND=noninteractive apt-get -qq update
    # shellcheck disable=SC2086 # a list of words
    "$@" DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends $missing
}

# Words with commas between them.
listed() {
    printf '%s' "$1"
    shift
    [ $# = 0 ] || printf ', %s' "$@"
}

fail() {
    printf 'setup.sh: %s\n' "$@" >&2
    exit 1
}

# --- Python -----------------------------------------------------------------------------------------------------------

# The first Python that is new enough and can make environments with pip.
find_python() {
    for python in python3 /usr/bin/python3 python3.14 python3.13 python3.12 python3.11 python3.10; do
        if "$python" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 10))' >/dev/null 2>&1; then
            echo "$python"
            return
        fi
    done
}

# A part that is installed is noted by the sum of what it asks for.
sum_of() { cat "$root/requirements/$1.txt" "$lock" | cksum; }

is_installed() { [ -f "$root/.venv/$1.cksum" ] && [ "$(cat "$root/.venv/$1.cksum")" = "$(sum_of "$1")" ]; }

# An environment has lost its packages where the Python that it was made of is gone or has become another one.
environment_works() { [ -x "$root/.venv/bin/python" ] && "$root/.venv/bin/python" -c 'import pip' >/dev/null 2>&1; }

# Which of some parts are not installed.
missing_parts() {
    works=false
    ! environment_works || works=true
    for part in "$@"; do
        { $works && is_installed "$part"; } || echo "$part"
    done
}

# shellcheck disable=SC2086 # a list of words
python_is_ready() { [ -z "$(missing_parts $parts)" ]; }

install_python() {
    # shellcheck disable=SC2086 # a list of words
    missing=$(missing_parts $parts | tr '\n' ' ')
    [ -n "$missing" ] || return 0
    python=$(find_python)
    [ -n "$python" ] || fail "no python3 >= 3.10 with the modules venv and ensurepip"
    # shellcheck disable=SC2086
    echo "installing the Python packages to $(listed $missing) into .venv: $(cost $missing)"
    environment_works || "$python" -m venv --clear "$root/.venv"
    python=$root/.venv/bin/python
    set --
    for part in $missing; do
        set -- "$@" -r "$root/requirements/$part.txt"
    done
    if "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
        set -- "$@" -c "$lock"
    fi
    # Modules are compiled when they are used first: all of them would take 160 MB. What has no wheel is built without its own setup.py install
    if ! "$python" -m pip install --progress-bar off --disable-pip-version-check --no-compile --use-pep517 "$@" >"$root/.venv/install.log" 2>&1; then
        cat "$root/.venv/install.log" >&2
        fail "the Python packages to $(listed $missing) have not been installed"
    fi
    # The package of python/ as it stands there
    for packages_of in "$root"/.venv/lib/python*/site-packages; do
        [ ! -d "$packages_of" ] || echo "$root/python/src" >"$packages_of/hampm.pth"
    done
    for part in $missing; do
        sum_of "$part" >"$root/.venv/$part.cksum"
    done
}

# --- check ------------------------------------------------------------------------------------------------------------

check() {
    parts=$all
    missing=$(missing_packages)
    python_is_ready || missing="$missing
.venv with the packages of requirements.txt"
    [ -n "$missing" ] || return 0
    echo "$missing" | sed '/^$/d'
    return 1
}

main "$@"
