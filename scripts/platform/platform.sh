# shellcheck shell=bash
# The set-up that all commands in scripts/ share; to be sourced.
#
#   prepare_platform     Debian 13 with YADE and the compiler, and YADE's headers: made once, then found
#   build TARGET         brings the plugin (or all, with the tests) up to date
#   "${inside[@]}" CMD   runs CMD on the platform, with the plugin importable
#
# Debian 13 is the platform itself; Debian 12 gets a private Debian 13 root in the cache.

set -euo pipefail

platform_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)
repo=$(cd "$platform_dir/../.." && pwd -P)

# Threads that wait give their processor up soon: on a busy machine those they wait for need it.
export GOMP_SPINCOUNT=${GOMP_SPINCOUNT-3000}
# Memory in huge pages where the system lets programs ask for them (doc/decisions/0029-memory.md).
export GLIBC_TUNABLES=${GLIBC_TUNABLES-glibc.malloc.hugetlb=1}

yade_version=2025.2.0
mirror=${SOFTGRAIN_DEBIAN_MIRROR:-http://deb.debian.org/debian}

# shellcheck source=scripts/platform/common.sh
source "$platform_dir/common.sh"
# shellcheck source=scripts/platform/debian.sh
source "$platform_dir/debian.sh"
# shellcheck source=scripts/platform/headers.sh
source "$platform_dir/headers.sh"
# shellcheck source=scripts/platform/build.sh
source "$platform_dir/build.sh"

prepare_platform() {
    choose_platform
    case $kind in
        native) has_packages || with_lock platform install_packages ;;
        root) has_root || with_lock platform make_root ;;
    esac
    require_yade "${root:-/}"
    export_environment
    has_headers || with_lock platform fetch_headers
}

# What programs on the platform see. The platform's own programs come first in PATH: a Python of the
# caller's (pyenv, conda) cannot load YADE.
export_environment() {
    local yade_python
    yade_python=/usr/lib/$(uname -m)-linux-gnu/yade-double/py
    export PATH=/usr/local/sbin:/usr/sbin:/usr/bin:/sbin:/bin:$PATH
    export PYTHONPATH=$repo/py:$build/python:$yade_python${PYTHONPATH:+:$PYTHONPATH}
    export CCACHE_DIR=$cache/ccache CCACHE_BASEDIR=$repo
    # Without a display, pictures go to files.
    [ -n "${DISPLAY:-}" ] || export MPLBACKEND=${MPLBACKEND:-Agg}
    # A private root has no locale but this one.
    [ "$kind" = native ] || export LC_ALL=C.UTF-8
}
