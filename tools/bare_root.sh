#!/bin/sh
# Try the installation on Debians that have nothing else: debootstrap makes each in a new folder, a checkout of the last commit is laid there, and
# the steps are run with the root's own Python. A table tells what they took. Root, debootstrap and the network of packages are needed.
#
#     tools/bare_root.sh [--suite SUITE]... [STEP...]      default: bookworm and trixie, all steps
#
# Steps are targets of make: run, solid (run dim=3), test, docs and any other; setup-PART for one part of tools/setup.sh; and install, by which the
# program and its scripts are installed as the recipes do it and run when the sources are gone. BARE is the folder (default: build/bare_root).
#
# Of this machine nothing is mounted in a root: each has the devices that debootstrap makes and, in a mount namespace that ends with the step,
# a fresh /proc and /dev/shm. It is removed only when nothing is mounted below it. Logs stay in build/bare_root.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
logs=${BARE:-$root/build/bare_root}
packages=$(sed -n 's/^packages="\(.*\)"$/\1/p' "$root/tools/setup.sh")
suites=
# All steps, in their order; install is the last, as it removes the sources
steps="run solid test docs install"

main() {
    asked=
    while [ $# -gt 0 ]; do
        case $1 in
            --suite) suites="$suites ${2:?--suite: which?}" && shift ;;
            -*) sed -n '2,8s/^# \{0,1\}//p' "$0" >&2 && exit 2 ;;
            *) asked="$asked $1" ;;
        esac
        shift
    done
    [ "$(id -u)" = 0 ] || fail "only root can change into another root"
    command -v debootstrap >/dev/null || fail "debootstrap is not installed"
    mkdir -p "$logs"
    logs=$(cd "$logs" && pwd -P)
    table=$logs/table.txt status=0
    printf '%-10s %-12s %8s %10s %8s %9s  %s\n' root step 'wall s' 'processor' 'MB more' packages result >"$table"
    bare=
    trap remove EXIT
    trap 'exit 1' INT TERM HUP
    for suite in ${suites:-bookworm trixie}; do
        bare=$logs/$suite log=$logs/$suite.log
        [ ! -e "$bare" ] || fail "$bare: is there already"
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

fail() {
    echo "bare_root.sh: $1" >&2
    exit 1
}

# A bare Debian with git and make, by which the sources come, and a checkout of the last commit.
make_root() {
    mkdir "$bare"
    debootstrap --variant=minbase "$suite" "$bare" "$(mirror)" >>"$log" 2>&1 || fail "debootstrap has failed: $log"
    umount "$bare/proc" "$bare/sys" 2>/dev/null || true
    settings_of_apt
    inside apt-get -qq update >>"$log" 2>&1
    inside env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends git make ca-certificates >>"$log" 2>&1
    git clone --quiet --no-hardlinks "$root" "$bare/source"
    write_install
}

# The step install, as the recipes have it.
write_install() {
    cat >"$bare/root/install.sh" <<END
set -e
export DEBIAN_FRONTEND=noninteractive
apt-get -qq install -y --no-install-recommends $packages python3 python3-venv ca-certificates
make -C /source install PREFIX=/opt/hampm
cd /tmp
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
    inside sh -c 'cd /source 2>/dev/null || cd /; "$@"; code=$?; times >/tmp/times; exit $code' sh $(command_of "$1") >"$said" 2>&1 || code=$?
    [ $code = 0 ] || status=1
    result="exit $code"
    counts=$(grep -hE '[0-9]+ (passed|failed|error).* in [0-9.]+s' "$said" | tail -n 1 | tr -d '=')
    [ -z "$counts" ] || result="$result, $counts"
    printf '%-10s %-12s %8d %10s %8d %9d  %s\n' "$suite" "$1" $(($(date +%s) - began)) "$(processor)" $(($(size) - before)) \
        "$(inside dpkg-query -f '.\n' -W | wc -l)" "$result" | tee -a "$table"
}

# What a step is in the root. A new step is a line here, and a word of `steps`.
command_of() {
    case $1 in
        solid) echo make run dim=3 ;;
        install) echo sh /root/install.sh ;;
        setup-*) echo tools/setup.sh "${1#setup-}" ;;
        *) echo make "$1" ;;
    esac
}

# Seconds of the processor, of the children of the last step: 1m2.50s 0m3.00s
processor() { tail -n 1 "$bare/tmp/times" | sed 's/[ms]/ /g' | awk '{printf "%d", 60 * $1 + $2 + 60 * $3 + $4}'; }

size() { du -smx "$bare" | cut -f 1; }

# A command in the root, with a /proc and a /dev/shm that end with it.
inside() {
    unshare --mount --pid --fork --propagation private sh -c 'mount -t proc proc "$1/proc" && mkdir -p "$1/dev/shm" && mount -t tmpfs -o size=2g tmpfs "$1/dev/shm" &&
        bare=$1 && shift && exec chroot "$bare" "$@"' sh "$bare" \
        /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 ${PIP_CERT:+PIP_CERT="$PIP_CERT"} "$@"
}

# The mirror that this machine takes its packages from.
# shellcheck disable=SC2016 # apt-get fills it in
mirror() { apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | sed -n 1p; }

# How this machine reaches packages (proxies, certificates), for apt and pip; names of hosts too.
settings_of_apt() {
    for file in ${PIP_CERT:-} /etc/apt/apt.conf /etc/apt/apt.conf.d /etc/pip.conf /etc/hosts /etc/resolv.conf /etc/ssl/certs /usr/local/share/ca-certificates; do
        [ ! -e "$file" ] || { mkdir -p "$bare$(dirname "$file")" && cp -rL "$file" "$bare$(dirname "$file")/"; }
    done
}

mounted() { awk -v below="$bare/" 'index($2 "/", below) == 1 {print $2}' /proc/self/mounts; }

remove() {
    [ -n "$bare" ] && [ -e "$bare" ] || return 0
    if [ -n "$(mounted)" ]; then
        echo "bare_root.sh: not removed, as something is mounted below it: $(mounted)" >&2
    else
        rm -rf --one-file-system "$bare"
    fi
}

main "$@"
