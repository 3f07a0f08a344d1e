#!/bin/sh
# Try the installation on Debians that have nothing else: debootstrap makes each in a new folder, a checkout of the last commit is laid there, and
# the steps are run with the root's own Python. A table tells what they took. Root, debootstrap and the network of packages are needed.
#
#     tools/bare_root.sh [--suite SUITE]... [STEP...]      default: bookworm and trixie, all steps
#
# Steps are targets of make: run, solid (run dim=3), test, docs and any other; setup-PART for one part of tools/setup.sh; pip, by which
# pip install ./python lays the package and both programs into a new environment; and install, by which the program and its scripts are installed
# as the recipes do it and run when the sources are gone. BARE is the folder (default: build/bare_root).
#
# A root is removed only when nothing is mounted below it. Logs stay in build/bare_root.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
logs=${BARE:-$root/build/bare_root}
packages=$(sed -n 's/^packages="\(.*\)"$/\1/p' "$root/tools/setup.sh")
suites=
bare=
. "$root/tools/bare_debian.sh"
# All steps, in their order; install is the last, as it removes the sources
steps="run solid test docs pip install"

main() {
    asked=
    while [ $# -gt 0 ]; do
        case $1 in
            --suite) suites="$suites ${2:?--suite: which?}" && shift ;;
            -*) sed -n '2,9s/^# \{0,1\}//p' "$0" >&2 && exit 2 ;;
            *) asked="$asked $1" ;;
        esac
        shift
    done
    mkdir -p "$logs"
    logs=$(cd "$logs" && pwd -P)
    table=$logs/table.txt status=0
    printf '%-10s %-12s %8s %10s %8s %9s  %s\n' root step 'wall s' 'processor' 'MB more' packages result >"$table"
    trap remove EXIT
    trap 'exit 1' INT TERM HUP
    for suite in ${suites:-bookworm trixie}; do
        log=$logs/$suite.log
        : >"$log"
        make_root
        for step in ${asked:-$steps}; do
            take "$step"
        done
        remove
    done
    cat "$table"
    exit $status
}

# A bare Debian with git and make, by which the sources come, and a checkout of the last commit.
make_root() {
    new_root "$logs/$suite" "$suite" 2>>"$log"
    inside "$bare" apt-get -qq update >>"$log" 2>&1
    inside "$bare" env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends git make ca-certificates >>"$log" 2>&1
    git clone --quiet --no-hardlinks "$root" "$bare/source"
    write_scripts
}

# The steps pip, as installing.md has it, and install, as the recipes have it.
write_scripts() {
    cat >"$bare/root/pip.sh" <<END
set -e
/source/tools/setup.sh program
DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends python3-venv
python3 -m venv /tmp/venv
/tmp/venv/bin/pip install --disable-pip-version-check /source/python
cd /tmp
PATH=/tmp/venv/bin:/usr/bin:/bin
hampm /source/input/edge_crack.nml --quiet
hampm3d /source/input/solid/beam.nml --quiet
python -c 'import hampm; print(hampm.run("/source/input/edge_crack.nml", output="python", progress=False).value("J"))'
END
    cat >"$bare/root/install.sh" <<END
set -e
export DEBIAN_FRONTEND=noninteractive
apt-get -qq install -y --no-install-recommends $packages python3 python3-venv ca-certificates
make -C /source install PREFIX=/opt/hampm
cd "\$(mktemp -d)"
mv /source /source.away
/opt/hampm/bin/hampm /opt/hampm/share/hampm/input/edge_crack.nml --quiet
/opt/hampm/bin/hampm-tool tabulate edge_crack.h5 --column J
END
}

# Run a step and add its row to the table.
take() {
    echo "$suite: $1"
    before=$(size) began=$(date +%s) code=0
    said=$logs/$suite.$1.log
    # POSIX times: of this shell's children, before and after
    inside "$bare" sh -c 'cd /source 2>/dev/null || cd /; "$@"; code=$?; times >/tmp/times; exit $code' sh $(command_of "$1") >"$said" 2>&1 || code=$?
    [ $code = 0 ] || status=1
    result="exit $code"
    counts=$(grep -hE '[0-9]+ (passed|failed|error).* in [0-9.]+s' "$said" | tail -n 1 | tr -d '=')
    [ -z "$counts" ] || result="$result, $counts"
    printf '%-10s %-12s %8d %10s %8d %9d  %s\n' "$suite" "$1" $(($(date +%s) - began)) "$(processor)" $(($(size) - before)) \
        "$(inside "$bare" dpkg-query -f '.\n' -W | wc -l)" "$result" | tee -a "$table"
}

# What a step is in the root. A new step is a line here, and a word of `steps`.
command_of() {
    case $1 in
        solid) echo make run dim=3 ;;
        pip) echo sh /root/pip.sh ;;
        install) echo sh /root/install.sh ;;
        setup-*) echo tools/setup.sh "${1#setup-}" ;;
        *) echo make "$1" ;;
    esac
}

# Seconds of the processor, of the children of the last step: 1m2.50s 0m3.00s
processor() { tail -n 1 "$bare/tmp/times" | sed 's/[ms]/ /g' | awk '{printf "%d", 60 * $1 + $2 + 60 * $3 + $4}'; }

size() { du -smx "$bare" | cut -f 1; }

main "$@"
