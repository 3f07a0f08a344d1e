#!/bin/sh
# Try the installation on a Debian that has nothing else: debootstrap makes one in a new folder, these sources are installed there as the
# recipes do it, and the program and its scripts are run when the sources are gone. Root, debootstrap and the network of packages are needed.
#
#     tools/bare_root.sh [FOLDER]        default: build/bare_root, which must not be there; it is removed at the end
#
# Of this machine nothing is mounted in the folder: it has no /proc, /sys and /dev of its own but for those that debootstrap makes. It is
# removed only when nothing is mounted below it.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
bare=${1:-$root/build/bare_root}
suite=bookworm
packages=$(sed -n 's/^packages="\(.*\)"$/\1/p' "$root/tools/setup.sh")

main() {
    [ "$(id -u)" = 0 ] || fail "only root can change into another root"
    command -v debootstrap >/dev/null || fail "debootstrap is not installed"
    [ ! -e "$bare" ] || fail "$bare: is there already"
    mkdir -p "$bare"
    bare=$(cd "$bare" && pwd -P)
    trap remove EXIT
    trap 'exit 1' INT TERM HUP
    debootstrap --variant=minbase "$suite" "$bare" "$(mirror)" >"$bare.log" 2>&1 || fail "debootstrap has failed: $bare.log"
    umount "$bare/proc" 2>/dev/null || true
    settings_of_apt
    mkdir "$bare/source"
    (cd "$root" && git archive HEAD) | tar -x -C "$bare/source"
    inside apt-get -qq update
    # shellcheck disable=SC2086 # a list of words
    inside env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends $packages python3 python3-venv ca-certificates >>"$bare.log" 2>&1
    inside make -C /source install PREFIX=/opt/hampm 2>>"$bare.log"
    inside rm -r /source
    inside sh -c 'cd /tmp && /opt/hampm/bin/hampm /opt/hampm/share/hampm/input/edge_crack.nml --quiet &&
        /opt/hampm/bin/hampm-tool tabulate edge_crack.h5 --column J'
    echo "hampm is installed and runs in a bare Debian $suite"
}

fail() {
    echo "bare_root.sh: $1" >&2
    exit 1
}

inside() { chroot "$bare" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root ${PIP_CERT:+PIP_CERT="$PIP_CERT"} "$@"; }

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
    if [ -n "$(mounted)" ]; then
        echo "bare_root.sh: not removed, as something is mounted below it: $(mounted)" >&2
    else
        rm -rf --one-file-system "$bare"
    fi
}

main "$@"
