#!/bin/sh
# Builds the program for this machine and packs it with its licences, completions and manual pages:
# target/dist/kinora-VERSION-HOST.tar.gz, and its checksum beside it. An archive of the small checker is made too.
#
#   cli/release.sh
set -eu
cd "$(dirname "$0")/.."
host=$(rustc -vV | sed -n 's/^host: //p')
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
dist=target/dist
rm -rf "$dist"
mkdir -p "$dist"

sum() {
    if command -v sha256sum > /dev/null; then sha256sum "$1"; else shasum -a 256 "$1"; fi
}

# pack NAME PROGRAM
pack() {
    folder=$1-$version-$host
    mkdir -p "$dist/$folder/completions"
    cp "$2" README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "$dist/$folder"
    for shell in bash zsh fish powershell nushell; do
        "$2" completions "$shell" > "$dist/$folder/completions/kinora.$shell"
    done
    "$2" man -o "$dist/$folder/man"
    (cd "$dist" && tar -czf "$folder.tar.gz" "$folder" && sum "$folder.tar.gz" > "$folder.tar.gz.sha256")
    rm -rf "${dist:?}/$folder"
}

ending=
case $host in *windows*) ending=.exe ;; esac
cargo build --release --locked -p kinora
pack kinora "target/release/kinora$ending"
# Beside the other, so that neither replaces the other.
cargo build --release --locked -p kinora --no-default-features --target-dir target/checker
pack kinora-checker "target/checker/release/kinora$ending"
ls -l "$dist"
