# shellcheck shell=bash
# Where the platform comes from: the machine itself (Debian 13), or a private Debian 13 root
# (Debian 12). Sourced by platform.sh.

package_names() {
    sed 's/#.*//' "$platform_dir/packages" | xargs
}

# Sets: kind (native, root), root (empty when native), inside (the command prefix that enters the
# platform), build (the build folder of this checkout on this platform).
choose_platform() {
    local release key
    release=$(. /etc/os-release 2>/dev/null && echo "${ID:-unknown} ${VERSION_ID:-unknown}") || release=unknown
    case $release in
        'debian 13')
            kind=native
            key=native
            root=''
            inside=()
            ;;
        'debian 12')
            kind=root
            key=$(short_hash "$(package_names) $yade_version trixie")
            root=$cache/root-$key
            inside=(unshare --mount --propagation private "$platform_dir/enter" "$root" "$repo" "$cache")
            require_mount_rights
            ;;
        *) fail "this machine is '$release', but softgrain runs on Debian 12 or 13: use one of them, for example a container of the image debian:13" ;;
    esac
    build=$cache/build-$(short_hash "$repo $key")
}

short_hash() {
    sha256sum <<<"$1" | cut -c1-12
}

require_mount_rights() {
    [ "$(id -u)" = 0 ] \
        || fail "on Debian 12 softgrain lives in a private Debian 13 root, which only root can enter: call as root, or use a Debian 13 machine"
    unshare --mount true 2>/dev/null \
        || fail "this machine lets nobody mount (a container without CAP_SYS_ADMIN?): give that right (docker run --privileged), or use a Debian 13 machine or image"
}

# require_yade ROOT: the plugin fits one version of the host only, since its classes share a layout.
require_yade() {
    local found
    found=$(dpkg-query --admindir="$1/var/lib/dpkg" -W -f '${Version}' yade 2>/dev/null) || found=none
    [[ $found == "$yade_version"-* ]] \
        || fail "the YADE package in $1 has version '$found', but softgrain fits YADE $yade_version only: use a mirror of Debian 13 that has it (SOFTGRAIN_DEBIAN_MIRROR), or a softgrain made for that version"
}

# --- Debian 13 itself

has_packages() {
    [ -z "$(missing_packages)" ]
}

missing_packages() {
    local names
    read -ra names < <(package_names)
    comm -23 <(printf '%s\n' "${names[@]}" | sort) \
        <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${names[@]}" 2>/dev/null | sed -n 's/^installed //p' | sort) \
        | xargs
}

install_packages() {
    local missing
    missing=$(missing_packages)
    [ -n "$missing" ] || return 0
    [ "$(id -u)" = 0 ] \
        || fail "packages are missing; as root, run: apt-get update && apt-get install --no-install-recommends $missing"
    require_space / 4500
    say "installing YADE, the compiler and what they need (about 3 minutes, once)"
    # shellcheck disable=SC2086  # one word per package
    logged packages apt_install $missing
}

# Also takes up what an interrupted installation left.
apt_install() {
    export DEBIAN_FRONTEND=noninteractive
    dpkg --configure -a \
        && apt-get update \
        && apt-get install --yes --fix-broken --no-install-recommends -o DPkg::Lock::Timeout=300 "$@"
}

# --- a private Debian 13 root

has_root() {
    [ -d "$root" ]
}

# Built aside and renamed, so that a root that is there is complete.
make_root() {
    has_root && return
    require_space "$cache" 6000 ", or set XDG_CACHE_HOME to a folder on another disk"
    rm -rf --one-file-system -- "$root.partial"
    command -v mmdebstrap >/dev/null || {
        say "installing mmdebstrap (half a minute, once)"
        logged mmdebstrap apt_install mmdebstrap
    }
    say "making a private Debian 13 with YADE and the compiler in $root (about 3 minutes, once)"
    logged root bootstrap "$root.partial"
    require_yade "$root.partial"
    mv -T -- "$root.partial" "$root"
}

# In namespaces of its own, so that all mounts and processes of the making end with it, and it with
# this shell.
bootstrap() {
    setpriv --pdeathsig KILL unshare --mount-proc --pid --kill-child \
        mmdebstrap --mode=root --variant=minbase --include="$(package_names)" \
        --dpkgopt=force-unsafe-io --aptopt='Acquire::http::Timeout "30"' \
        trixie "$1" "deb $mirror trixie main"
}
