#!/bin/sh
# Print the version of these sources, with the commit where it is known: 2.0.0 (e4e7d71f1c05), and "modified" where files differ from it.
#
# The number is the first line of VERSION. The commit is that of the checkout, else the second line of VERSION, which `git archive` fills in.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
release=$(sed -n 1p "$root/VERSION")
commit=
# A folder in the checkout of something else is none of it; that of another user (sudo make install) is
if [ -e "$root/.git" ]; then
    commit=$(git -c safe.directory='*' -C "$root" describe --always --exclude '*' --abbrev=12 --dirty=', modified' 2>/dev/null || true)
fi
[ -n "$commit" ] || commit=$(sed -n 2p "$root/VERSION")
case $commit in
    '' | *Format*) echo "$release" ;;
    *) echo "$release ($commit)" ;;
esac
