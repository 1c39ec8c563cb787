# shellcheck shell=bash
# A private Python environment with packages from PyPI. To be sourced after setup.sh.
#
#     python="$(python_environment metrics numpy==2.4.6 scikit-image==0.26.0)" || exit 1
#     "$python" script.py

# Creates the environment NAME with exactly these packages, unless it exists, and prints the path of its Python.
# Environments are in ~/.cache/glowworm/python and may be deleted at any time.
python_environment() { # NAME PACKAGE==VERSION...
    local folder="${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/glowworm/python/$1" packages
    shift
    packages="$(python3 --version 2>/dev/null) $*"
    if [ "$(cat "$folder/packages" 2>/dev/null)" != "$packages" ]; then
        command -v python3 >/dev/null || fail "no python3; install Python 3.11 or newer (on Debian: python3-venv)"
        say "installing into $folder: $*"
        rm -rf "$folder"
        {
            python3 -m venv "$folder" &&
                "$folder/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
        } </dev/null >&2 || fail "the Python environment $folder could not be made (see above; on Debian it needs python3-venv)"
        printf '%s\n' "$packages" >"$folder/packages"
    fi
    printf '%s\n' "$folder/bin/python"
}
