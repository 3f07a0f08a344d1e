# Functions of tools/bare_root.sh and tools/wheel.sh: a Debian that has nothing else, in the folder $bare. Of this machine nothing is mounted in it:
# it has the devices that debootstrap makes, and in a mount namespace that ends with each command a fresh /proc, /dev/shm and /dev/pts.

fail() {
    echo "${0##*/}: $1" >&2
    exit 1
}

# new_root FOLDER SUITE [OPTION...]: lay a bare Debian there, which knows how this machine reaches packages, and call it $bare.
new_root() {
    [ "$(id -u)" = 0 ] || fail "only root can change into another root"
    command -v debootstrap >/dev/null || fail "debootstrap is not installed"
    [ ! -e "$1" ] || fail "$1: is there already"
    mkdir -p "$1"
    bare=$(cd "$1" && pwd -P) suite=$2
    shift 2
    debootstrap --variant=minbase "$@" "$suite" "$bare" "$(mirror)" >&2 || fail "debootstrap has failed"
    umount "$bare/proc" "$bare/sys" 2>/dev/null || true
    # Proxies, certificates and names of hosts, for apt and pip
    for file in ${PIP_CERT:-} /etc/apt/apt.conf /etc/apt/apt.conf.d /etc/pip.conf /etc/hosts /etc/resolv.conf /etc/ssl/certs /usr/local/share/ca-certificates; do
        [ ! -e "$file" ] || { mkdir -p "$bare$(dirname "$file")" && cp -rL "$file" "$bare$(dirname "$file")/"; }
    done
}

# The mirror that this machine takes its packages from.
# shellcheck disable=SC2016 # apt-get fills it in
mirror() { apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | sed -n 1p; }

# A command in a root: inside ROOT COMMAND...
inside() {
    unshare --mount --pid --fork --propagation private sh -c 'mount -t proc proc "$1/proc" && mkdir -p "$1/dev/shm" && mount -t tmpfs -o size=2g tmpfs "$1/dev/shm" &&
        mkdir -p "$1/dev/pts" && mount -t devpts -o newinstance,ptmxmode=0666 devpts "$1/dev/pts" && bare=$1 && shift && exec chroot "$bare" "$@"' sh "$1" \
        /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 ${PIP_CERT:+PIP_CERT="$PIP_CERT"} sh -c 'shift && exec "$@"' sh "$@"
}

mounted() { awk -v below="$bare/" 'index($2 "/", below) == 1 {print $2}' /proc/self/mounts; }

# Remove $bare, if nothing is mounted below it.
remove() {
    [ -n "$bare" ] && [ -e "$bare" ] || return 0
    if [ -n "$(mounted)" ]; then
        echo "${0##*/}: not removed, as something is mounted below it: $(mounted)" >&2
    else
        rm -rf --one-file-system "$bare"
    fi
}
