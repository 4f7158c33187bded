#!/usr/bin/env bash
# Install what `make demo` (setup.sh demo) or `make test` (setup.sh test) needs, and nothing that
# is there already: system libraries where the rights allow it, .venv, the package with its
# dependencies as pinned in constraints.txt. Running it again repairs what was interrupted.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-}" in
demo) extras="" ;;
test) extras="[dev]" ;;
*)
    echo "usage: tools/setup.sh demo|test" >&2
    exit 2
    ;;
esac
target=$1
oldest="3.11"

say() { echo "setup: $*"; }
warn() { echo "setup: $*" >&2; }
die() {
    warn "$*"
    exit 3
}

# --- interpreter

recent_enough() {
    "$1" -c "import sys; sys.exit(sys.version_info < tuple(map(int, '$oldest'.split('.'))))" \
        2>/dev/null
}

choose_python() {
    local candidate
    if [ -n "${PYTHON:-}" ]; then
        recent_enough "$PYTHON" ||
            die "PYTHON=$PYTHON is not a Python of version $oldest or later; name another one"
        python=$PYTHON
        return
    fi
    for candidate in python3 python3.14 python3.13 python3.12 python3.11; do
        if command -v "$candidate" >/dev/null && recent_enough "$candidate"; then
            python=$candidate
            return
        fi
    done
    die "no Python of version $oldest or later found (python3 is" \
        "$(python3 --version 2>/dev/null || echo missing)); install one," \
        "or name it: make $target PYTHON=/path/to/python3"
}

# --- system libraries

# The Debian package is missing if dpkg does not know it and its library cannot be found either
# (other systems, other package names, a Mesa built by hand).
installed() {
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null || true)" = installed ]
}

loads() {
    "$python" - "$@" 2>/dev/null <<'PYTHON'
import ctypes
import sys


def loads(name):
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


sys.exit(not any(loads(name) for name in sys.argv[1:]))
PYTHON
}

has_dri_driver() {
    local folder
    for folder in /usr/lib /usr/lib64 /usr/lib/*-linux-* /usr/local/lib /usr/local/lib/*-linux-*; do
        if compgen -G "$folder/dri/swrast_dri.so" >/dev/null ||
            compgen -G "$folder/libgallium-*.so" >/dev/null; then
            return 0
        fi
    done
    return 1
}

find_missing() {
    missing=()
    if [ "$(uname -s)" = Linux ]; then
        installed libegl1 || loads libEGL.so.1 || missing+=(libegl1)
        installed libgl1 || loads libGL.so.1 || missing+=(libgl1)
        installed libgl1-mesa-dri || has_dri_driver || missing+=(libgl1-mesa-dri)
        installed libosmesa6 || loads libOSMesa.so.8 libOSMesa.so || missing+=(libosmesa6)
        if [ "$target" = test ]; then
            command -v Xvfb >/dev/null || missing+=(xvfb)
        fi
    fi
    if [ ! -x .venv/bin/python ] && ! "$python" -c "import ensurepip, venv" 2>/dev/null; then
        # python3.12 comes with python3.12-venv, python3 with python3-venv.
        missing+=("$(basename "$python")-venv")
    fi
}

as_root() {
    if [ "$(id -u)" = 0 ]; then
        DEBIAN_FRONTEND=noninteractive "$@"
    else
        sudo -n env DEBIAN_FRONTEND=noninteractive "$@"
    fi
}

may_install() {
    command -v apt-get >/dev/null || return 1
    [ "$(id -u)" = 0 ] || { command -v sudo >/dev/null && sudo -n true 2>/dev/null; }
}

# Split the missing packages into those that apt knows and those it does not.
look_up() {
    known=()
    unknown=()
    local package
    for package in "${missing[@]}"; do
        case $(LC_ALL=C apt-cache policy "$package" 2>/dev/null || true) in
        *"Candidate: (none)"* | "") unknown+=("$package") ;;
        *) known+=("$package") ;;
        esac
    done
}

apt_install() {
    as_root apt-get install -y -q --no-install-recommends "$@" >/dev/null
}

install_missing() {
    say "installing system packages: ${missing[*]}"
    look_up
    if [ ${#unknown[@]} -gt 0 ]; then
        # A fresh image has no package lists at all.
        as_root apt-get update -q >/dev/null || warn "apt-get update failed"
        look_up
    fi
    if [ ${#known[@]} -gt 0 ] && ! apt_install "${known[@]}"; then
        # Old lists name versions that are gone from the server.
        as_root apt-get update -q >/dev/null || warn "apt-get update failed"
        apt_install "${known[@]}" || warn "apt-get install failed"
    fi
}

system_packages() {
    local package
    find_missing
    [ ${#missing[@]} -gt 0 ] || return 0
    if may_install; then
        install_missing
        find_missing
        [ ${#missing[@]} -gt 0 ] || return 0
    fi
    warn "missing system packages: ${missing[*]}"
    if command -v apt-get >/dev/null; then
        warn "install them as root: apt-get install ${missing[*]}"
    else
        warn "these are Debian's names; install what your system calls them"
    fi
    for package in "${missing[@]}"; do
        case $package in
        *-venv) die "without $package there is no virtual environment; stopping here" ;;
        xvfb) warn "without xvfb the window tests fail" ;;
        libosmesa6) warn "without libosmesa6 the backend osmesa is missing (Mesa 25.1 and later" \
            "have none: use egl)" ;;
        *) warn "without $package some ways to a GL context are missing" ;;
        esac
    done
    warn "continuing"
}

# --- virtual environment

# A stamp holds what the installation followed from; no stamp, or another one, means: install.
wanted_stamp() {
    echo "$1"
    pwd
    .venv/bin/python --version
    cksum pyproject.toml constraints.txt
}

up_to_date() {
    local done_target
    # What `make test` installs is enough for `make demo`.
    for done_target in "$target" test; do
        if [ -f ".venv/stamp-$done_target" ] &&
            [ "$(cat ".venv/stamp-$done_target")" = "$(wanted_stamp "$done_target")" ]; then
            return 0
        fi
    done
    return 1
}

usable_venv() {
    # The mark stands while pip works: an interrupted pip may leave half a package that looks
    # installed to the next one.
    [ ! -e .venv/installing ] && recent_enough .venv/bin/python &&
        .venv/bin/python -c "import pip" 2>/dev/null
}

environment() {
    if usable_venv; then
        if up_to_date; then
            return
        fi
    else
        say "creating .venv with $("$python" --version)"
        "$python" -m venv --clear .venv ||
            die "python -m venv failed; remove .venv and see the message above"
    fi
    say "installing rtbow and what it needs into .venv; the first time this takes minutes"
    touch .venv/installing
    rm -f .venv/stamp-*
    PIP_DISABLE_PIP_VERSION_CHECK=1 .venv/bin/python -m pip install -q \
        -c constraints.txt -e ".$extras" ||
        die "pip failed; see the message above (no network, or a package index that lacks a" \
            "version of constraints.txt?), then run make $target again"
    wanted_stamp "$target" >.venv/stamp-new
    rm .venv/installing
    mv .venv/stamp-new ".venv/stamp-$target"
}

choose_python
system_packages
environment
