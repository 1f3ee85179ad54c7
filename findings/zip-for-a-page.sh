#!/usr/bin/env bash
# The crate zip 9.4.1, asked for nothing but `deflate`, depends on getrandom 0.4 with its feature `wasm_js` where it is compiled for
# wasm32-unknown-unknown, and so on wasm-bindgen: a page that loads its module without wasm-bindgen's JavaScript cannot use it, though
# archives of the kind need no random numbers. The script needs cargo.
. "$(dirname "$0")/common.sh"
mkdir src && touch src/lib.rs
cat >Cargo.toml <<'TOML'
[package]
name = "page"
version = "0.0.0"
edition = "2024"

[dependencies]
zip = { version = "=9.4.1", default-features = false, features = ["deflate"] }
TOML
tree() { cargo tree --quiet --target wasm32-unknown-unknown --edges normal "$@"; }
tree --prefix none --format '{p} {f}' | sed 's/ (.*//' | grep -E '^(zip|getrandom|wasm-bindgen) ' | sort -u | tee seen
grep -qE '^getrandom v0\.4\..*wasm_js' seen
grep -q '^wasm-bindgen ' seen
