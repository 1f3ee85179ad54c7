#!/usr/bin/env bash
# The crate nalgebra 0.35.0, asked for `libm` and not for `std`, has functions of `f64` that are the same on every platform, until the
# crate basin 3.2.0 stands anywhere in the program, even without its default features: it asks for `std` of num-traits, and nalgebra's
# functions, which are those of num-traits, become the system's. The same source gives other bits then, as of `hypot`, by which its
# singular values are found. The script needs cargo and a linker.
. "$(dirname "$0")/common.sh"
mkdir src
cat >src/main.rs <<'RUST'
use nalgebra::ComplexField;

/// Digests of functions of many numbers.
fn main() {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        0.5 + (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut hypot, mut power) = (0u64, 0u64);
    for _ in 0..100_000 {
        let (a, b): (f64, f64) = (next(), next());
        hypot = hypot.rotate_left(5) ^ ComplexField::hypot(a, b).to_bits();
        power = power.rotate_left(5) ^ ComplexField::powf(a, b).to_bits();
    }
    println!("hypot {hypot:016x}\npowf {power:016x}");
}
RUST
manifest() {
    cat >Cargo.toml <<TOML
[package]
name = "bits"
version = "0.0.0"
edition = "2024"

[dependencies]
nalgebra = { version = "=0.35.0", default-features = false, features = ["alloc", "libm"] }
$1
TOML
}
manifest ''
cargo run --quiet --release | tee alone
manifest 'basin = { version = "=3.2.0", default-features = false }'
cargo tree --quiet --edges features --invert num-traits --depth 2 | grep -A1 'num-traits feature "std"' | tee seen
grep -q 'basin v3\.2\.0' seen
cargo run --quiet --release | tee beside
! diff alone beside
