# shellcheck shell=bash
# YADE's C++ headers, which Debian does not package: from the upstream tarball in Debian's source
# archive. Sourced by platform.sh.

headers=$cache/yade-$yade_version
tarball_sha256=42702372251bf5e8f07a364bdf30533a1318947e4db90435b1f89293dc029156

has_headers() {
    [ -d "$headers" ]
}

# Built aside and renamed, so that a folder that is there is complete.
fetch_headers() {
    has_headers && return
    require_space "$cache" 200
    rm -rf -- "$headers.partial"
    mkdir -p -- "$headers.partial"
    say "fetching YADE's headers (14 MB, once)"
    logged headers fetch_tarball "$headers.partial/tarball"
    logged headers unpack_tarball "$headers.partial"
    mv -T -- "$headers.partial" "$headers"
}

fetch_tarball() {
    "${inside[@]}" /usr/lib/apt/apt-helper download-file \
        "$mirror/pool/main/y/yade/yade_$yade_version.orig.tar.bz2" "$1" "SHA256:$tarball_sha256"
}

unpack_tarball() {
    local top=trunk-$yade_version
    "${inside[@]}" tar -xjf "$1/tarball" -C "$1" --no-same-owner --strip-components=1 \
        "$top"/{core,lib,pkg,preprocessing,ChangeLog} \
        && rm -- "$1/tarball"
}
