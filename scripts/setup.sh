#!/bin/sh
# Takes a machine with python3, git and make to a synced environment; does nothing when all is there.
#
#   scripts/setup.sh [--dev] [--peers] [--no-render]
#
#   --dev        also what tests, checks and benchmarks need, the extra `cluster` among it
#   --peers      OpenCV's contrib wheel, with the trackers to compare with, in place of the default one
#   --no-render  do not ask for the OpenGL libraries (linting renders nothing)
set -eu
cd "$(dirname "$0")/.."

GL_PACKAGES="libegl1 libgl1 libopengl0 libgl1-mesa-dri"
UV_REQUIREMENT="uv>=0.8,<1" # the lower bound again in is_usable_uv and in pyproject.toml

say() { printf 'setup: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

# Prints the words of {fits, venv, pip, gl} that are true of this machine; about 0.05 s.
probe() {
    "$python" - <<'PYTHON'
import ctypes, glob, importlib.util, sys

def loads(*names):
    for name in names:
        try:
            return bool(ctypes.CDLL(name))
        except OSError:
            pass
    return False

drivers = ("/usr/lib*/dri/*_dri.so", "/usr/lib/*/dri/*_dri.so", "/usr/lib*/libgallium*.so",
           "/usr/lib/*/libgallium*.so", "/etc/glvnd/egl_vendor.d/*nvidia*",
           "/usr/share/glvnd/egl_vendor.d/*nvidia*")
if (3, 11) <= sys.version_info < (3, 14):
    print("fits")
if importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip"):
    print("venv")
if importlib.util.find_spec("pip"):
    print("pip")
if loads("libEGL.so.1") and loads("libOpenGL.so.0", "libGL.so.1") and any(map(glob.glob, drivers)):
    print("gl")
PYTHON
}

has() { case " $facts " in *" $1 "*) true ;; *) false ;; esac; }

is_usable_uv() {
    case "$("$1" --version 2>/dev/null)" in
        "uv 0."[0-7].* | "") false ;;
        "uv "*) true ;;
        *) false ;;
    esac
}

find_uv() {
    for candidate in uv "${HOME:-}/.local/bin/uv" .uv/bin/uv; do
        if is_usable_uv "$candidate"; then
            uv=$candidate
            return 0
        fi
    done
    return 1
}

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}

may_install() {
    command -v apt-get >/dev/null || return 1
    [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null
}

apt_get() {
    as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get -qq -o DPkg::Lock::Timeout=120 -o Dpkg::Use-Pty=0 "$@" >/dev/null
}

# Installs "$@"; the package lists are refreshed only if they do not do as they are.
install_packages() {
    say "installing system packages: $*"
    apt_get install -y --no-install-recommends "$@" 2>/dev/null ||
        { apt_get update && apt_get install -y --no-install-recommends "$@"; } ||
        fail "apt-get could not install them; its messages are above"
}

# A project-local uv, from the package index pip is set to; pip refuses no folder of our own (PEP 668).
bootstrap_uv() {
    say "fetching uv into .uv/"
    rm -rf .uv
    if has venv; then
        "$python" -m venv .uv
        .uv/bin/python -m pip install --quiet --disable-pip-version-check "$UV_REQUIREMENT"
    else
        "$python" -m pip install --quiet --disable-pip-version-check --target .uv "$UV_REQUIREMENT"
    fi
    find_uv || fail "uv did not install into .uv/; install uv 0.8 or newer yourself and run make again"
}

dev=no
peers=no
render=yes
for argument in "$@"; do
    case "$argument" in
        --dev) dev=yes ;;
        --peers) peers=yes ;;
        --no-render) render=no ;;
        *) fail "unknown argument $argument; there are --dev, --peers and --no-render" ;;
    esac
done
[ "$(uname -s)" = Linux ] && [ "${MUJOCO_GL:-egl}" = egl ] || render=no

environment=${UV_PROJECT_ENVIRONMENT:-.venv}
python=$environment/bin/python
[ -x "$python" ] || python=python3
command -v "$python" >/dev/null || fail "python3 is missing; on Debian or Ubuntu: apt-get install python3"
facts=$(probe | tr '\n' ' ')

missing=""
if [ $render = yes ] && ! has gl; then missing=$GL_PACKAGES; fi
if ! find_uv && ! has venv && ! has pip; then missing="$missing python3-venv"; fi
if [ -n "$missing" ]; then
    # shellcheck disable=SC2086  # a list of names, to be split
    if may_install; then
        install_packages $missing
        facts=$(probe | tr '\n' ' ')
    else
        fail "missing system packages; as root: apt-get install -y --no-install-recommends $missing"
    fi
fi
find_uv || bootstrap_uv

if has fits; then export UV_PYTHON_DOWNLOADS="${UV_PYTHON_DOWNLOADS:-never}"; fi
unset VIRTUAL_ENV # uv warns of any environment other than the project's
set -- sync --locked
# --inexact: a demo after the tests does not take the test packages away again
if [ $dev = yes ]; then set -- "$@" --extra cluster; else set -- "$@" --no-dev --inexact; fi
# The two wheels own the same folder cv2: one only.
[ $peers = no ] || set -- "$@" --extra peers --no-install-package opencv-python-headless
[ ! -x "$environment/bin/beltgrasp" ] || set -- "$@" --quiet
"$uv" "$@"
# Two processes that compile the same code at once can leave a cache that crashes: one goes first.
if [ -z "$(find tracker/affine -name 'aff2*.nbi' -newer tracker/affine/aff2_loops.py 2>/dev/null)" ]; then
    say "compiling the affine group"
    "$environment/bin/python" -c "import tracker.affine.aff2"
fi
