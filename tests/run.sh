#!/bin/sh
# Runs every test. Installs what they need beside Rust and a C compiler: drivers of Vulkan and OpenGL that compute on the
# CPU, which serve as GPUs, and for the viewer a display that exists in memory alone and the libraries of X that a window loads.
set -eu
cd "$(dirname "$0")/.."

if command -v apt-get > /dev/null; then
    missing=""
    for package in mesa-vulkan-drivers libegl1 libgl1-mesa-dri libgles2 xvfb libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6 libxrandr2; do
        dpkg -s "$package" > /dev/null 2>&1 || missing="$missing $package"
    done
    if [ -n "$missing" ]; then
        as_root=""
        [ "$(id -u)" = 0 ] || as_root=sudo
        $as_root apt-get update -qq
        # shellcheck disable=SC2086
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
    fi
fi

# Mesa's device chooser asks Wayland for the screen's GPU, and complains on stderr where there is no session.
export NODEVICE_SELECT=1

exec cargo test --workspace --no-fail-fast "$@"
