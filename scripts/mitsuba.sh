# shellcheck shell=bash
# Mitsuba 3 for scripts: a libLLVM for its fast variant. To be sourced after setup.sh.
#
#     find_llvm; "$python" script.py

# Older versions fail to compile Mitsuba's kernels.
minimum_llvm=17
debian_llvm=libllvm19

# Exports DRJIT_LIBLLVM_PATH, unless there is no libLLVM: then only Mitsuba's slow variant works.
find_llvm() {
    local llvm
    [ -z "${DRJIT_LIBLLVM_PATH:-}" ] || return 0
    llvm="$(system_llvm)"
    [ -n "$llvm" ] || llvm="$(unpacked_llvm)"
    [ -z "$llvm" ] || export DRJIT_LIBLLVM_PATH="$llvm"
}

# Prints the newest libLLVM that the dynamic linker finds.
system_llvm() {
    local version path best=$minimum_llvm found=
    while read -r version path; do
        if [ "$version" -ge "$best" ]; then
            best="$version" found="$path"
        fi
    done < <(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null |
        sed -n 's/^[[:space:]]*libLLVM[-.a-z]*\([0-9]\{2,\}\).* => \(.*\)$/\1 \2/p')
    printf '%s' "$found"
}

# Prints the libLLVM of a Debian package, unpacked into the cache; nothing is installed.
unpacked_llvm() {
    local cache="${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/glowworm/llvm" work
    if [ ! -e "$cache" ]; then
        command -v apt-get >/dev/null && command -v dpkg >/dev/null || return 0
        say "unpacking $debian_llvm into $cache"
        mkdir -p "$(dirname "$cache")"
        work="$(mktemp -d "$cache.XXXXXX")"
        if (cd "$work" && apt-get download "$debian_llvm" && dpkg -x ./*.deb . && rm ./*.deb) >/dev/null 2>&1; then
            mv -T "$work" "$cache"
        else
            rm -rf "$work"
            say "apt has no $debian_llvm"
            return 0
        fi
    fi
    find "$cache" -name 'libLLVM.so.*' -type f -print -quit
}
