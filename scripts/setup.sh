# shellcheck shell=bash
# Dependencies of ./glowworm, ./test and .ci/run on a bare machine. To be sourced; changes nothing by itself.
#
#     need_build_tools; need_vulkan; install_missing
#
# Each need_* checks for a dependency and, if it is missing, records its Debian package; install_missing then
# installs the recorded packages, if any.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
missing_packages=()

say() { printf 'glowworm: %s\n' "$1" >&2; }

fail() {
    printf 'glowworm: error: %s\n' "$1" >&2
    exit 1
}

# Records that PACKAGE is missing, and its purpose.
miss() { # PACKAGE REASON
    if [ ${#missing_packages[@]} -eq 0 ]; then
        say "this machine lacks:"
    fi
    say "  $1: $2"
    missing_packages+=("$1")
}

# What a build needs. The C++ compiler only where a shader differs from the SPIR-V that is committed.
need_build_tools() {
    need_rust
    command -v cc >/dev/null || miss gcc "linker of the program"
    [ "$(uname)" != Linux ] || has_file_in crt1.o "$(library_folders)" || miss libc6-dev "C library, to link the program"
    shaders_have_changed && need_cpp_compiler
    return 0
}

# Where the linker finds the start of every program.
library_folders() { printf '%s' "/usr/lib:/usr/lib64:/usr/lib32$(printf ':%s' /usr/lib/*-linux-*)"; }

need_rust() {
    PATH="$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin"
    command -v cargo >/dev/null ||
        fail "no Rust toolchain (cargo); install Rust $(minimum_rust) or newer with rustup, then run this again"
}

need_cpp_compiler() {
    local compiler
    for compiler in "${CXX:-c++}" g++ clang++; do
        command -v "${compiler%% *}" >/dev/null && return
    done
    miss g++ "C++ compiler, builds the shader compiler"
}

# Whether a shader or an include differs from what shaders/spirv was compiled from. build.rs computes the same.
shaders_have_changed() {
    local sha1=(sha1sum) now
    command -v sha1sum >/dev/null || sha1=(shasum)
    now="$(cd "$root" &&
        find shaders -name '*.comp' -o -name '*.frag' -o -name '*.glsl' -o -name '*.vert' -o -path shaders/compiler/lib.rs |
        LC_ALL=C sort | xargs "${sha1[@]}")"
    [ "$now" != "$(cat "$root/shaders/spirv/sources.sha1" 2>/dev/null)" ]
}

# Compiles the shaders if they have changed.
compile_changed_shaders() {
    if shaders_have_changed; then
        say "shaders have changed, so they are compiled to shaders/spirv"
        "$root/scripts/compile-shaders"
    fi
}

minimum_rust() { sed -n 's/^rust-version *= *"\(.*\)"/\1/p' "$root/Cargo.toml"; }

need_command() { # COMMAND PACKAGE REASON
    command -v "$1" >/dev/null || miss "$2" "$3"
}

need_vulkan() {
    has_vulkan_loader || miss libvulkan1 "Vulkan loader (libvulkan.so.1)"
    has_vulkan_driver || miss mesa-vulkan-drivers "Vulkan drivers, among them one for the CPU (no driver was found)"
}

# Libraries that the window loads at run time. Without them the program still runs, without a window.
need_window_libraries() {
    has_library libX11.so.6 || miss libx11-6 "X11, for the window"
    has_library libX11-xcb.so.1 || miss libx11-xcb1 "X11, for the window"
    has_library libXcursor.so.1 || miss libxcursor1 "pointers, for the window"
    has_library libXi.so.6 || miss libxi6 "mice and keyboards, for the window"
    has_library libxkbcommon.so.0 || miss libxkbcommon0 "keyboard layouts, for the window"
    has_library libxkbcommon-x11.so.0 || miss libxkbcommon-x11-0 "keyboard layouts, for the window"
}

# A virtual X server and input tools, for the tests of the window.
need_window_tests() {
    need_window_libraries
    need_command Xvfb xvfb "X server without a screen, for the tests of the window"
    need_command openbox openbox "window manager, for the tests of the window"
    need_command xdotool xdotool "real input events, for the tests of the window"
}

need_validation_layers() {
    has_file_in VkLayer_khronos_validation.json "${VK_LAYER_PATH:-}" && return
    has_file_in vulkan/explicit_layer.d/VkLayer_khronos_validation.json "$(vulkan_folders)" && return
    miss vulkan-validationlayers "Vulkan validation layers, which watch over every test"
}

has_vulkan_loader() { has_library libvulkan.so.1; }

# Whether the dynamic linker finds this library.
has_library() { # FILE
    has_file_in "$1" "${LD_LIBRARY_PATH:-}" && return
    # Into a variable: grep -q would close the pipe early, which fails under pipefail.
    local known
    known="$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null)" || known=
    [[ $known == *"$1"* ]] || has_file_in "$1" /usr/lib:/usr/lib64:/usr/local/lib
}

has_vulkan_driver() {
    # Drivers named in the environment are used as they are.
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] || has_file_in 'vulkan/icd.d/*.json' "$(vulkan_folders)"
}

# The search path of the Vulkan loader for drivers and layers.
vulkan_folders() {
    printf '%s' "${XDG_CONFIG_HOME:-${HOME:-}/.config}:${XDG_CONFIG_DIRS:-/etc/xdg}:/etc:"
    printf '%s' "${XDG_DATA_HOME:-${HOME:-}/.local/share}:${XDG_DATA_DIRS:-/usr/local/share:/usr/share}:/usr/share"
}

# Whether one of the FOLDERS (with colons between) has a file that matches PATTERN.
has_file_in() { # PATTERN FOLDERS
    local folder file folders
    IFS=: read -ra folders <<<"$2"
    for folder in "${folders[@]}"; do
        [ -n "$folder" ] || continue
        # shellcheck disable=SC2086 # the pattern is to be expanded
        for file in "$folder"/$1; do
            [ -e "$file" ] && return 0
        done
    done
    return 1
}

# Installs the recorded packages: as root or in CI at once, else with sudo after asking. If it cannot, prints what
# to do and returns 1.
install_missing() {
    [ ${#missing_packages[@]} -eq 0 ] && return
    local as_root=() install=(apt-get install -y --no-install-recommends "${missing_packages[@]}")
    if ! command -v apt-get >/dev/null; then
        say "these are package names of Debian and Ubuntu; install the equivalents for this system"
        return 1
    fi
    if [ "$(id -u)" -ne 0 ]; then
        as_root=(sudo)
        if ! command -v sudo >/dev/null; then
            say "to install it, run as root: ${install[*]}"
            return 1
        fi
        if [ "${CI:-}" != true ] && ! confirm "install it with: sudo ${install[*]}"; then
            say "to install it, run: sudo ${install[*]}"
            return 1
        fi
    fi
    say "installing: ${missing_packages[*]}"
    missing_packages=()
    {
        "${as_root[@]}" apt-get update -qq || say "apt-get update failed; using the old package lists"
        "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive "${install[@]}" -qq -o Dpkg::Use-Pty=0
    } </dev/null >&2 || {
        say "error: apt-get could not install it (see above)"
        return 1
    }
}

# Asks on the terminal; without one the answer is no.
confirm() { # QUESTION
    local answer
    [ -t 0 ] && [ -t 2 ] || return 1
    read -r -p "glowworm: $1 ? [y/N] " answer
    [[ $answer == [yY]* ]]
}
