#!/bin/sh
# Installs the system libraries that Qt, OpenGL and the window tests need: by apt-get when root, else says which are missing.
set -eu
packages="libxcb-cursor0 libxcb-icccm4 libxcb-keysyms1 libxcb-image0 libxcb-render-util0 libxcb-shape0
libxcb-xinerama0 libxcb-xkb1 libxcb-randr0 libxkbcommon-x11-0 libdbus-1-3 libfontconfig1 libegl1 libgl1
libopengl0 libosmesa6 libxrender1 libsm6 fonts-inter xvfb xauth"
command -v dpkg-query >/dev/null 2>&1 || exit 0
missing=""
for package in $packages python3-venv; do
    [ "$package" = python3-venv ] && python3 -c 'import ensurepip' 2>/dev/null && continue
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
if [ "$(id -u)" != 0 ]; then
    echo "These system libraries are missing; install them with: sudo apt-get install$missing" >&2
    exit 0
fi
export DEBIAN_FRONTEND=noninteractive
apt-get update -qq
# shellcheck disable=SC2086
apt-get install -y -qq --no-install-recommends $missing >/dev/null
