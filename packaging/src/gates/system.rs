//! Gate: the libraries that every machine of a platform has.

use crate::platform::Platform;

/// Whether a library is a part of the system.
pub fn has(platform: Platform, library: &str) -> bool {
    match platform {
        // glibc, the dynamic linker and the run-time library of GCC: those that the policy of Python's manylinux allows.
        Platform::Linux64 => {
            let (name, version) = library.split_once(".so.").unwrap_or((library, ""));
            !version.is_empty() && LINUX.contains(&name)
        }
        // The names of files do not depend on case. The C library `msvcrt` is a part of Windows, others came later.
        Platform::Win64 => {
            let library = library.to_ascii_lowercase();
            WINDOWS.contains(&library.as_str()) || library.starts_with("api-ms-win-core-")
        }
        Platform::Darwin64 => library == "/usr/lib/libSystem.B.dylib",
    }
}

const LINUX: &[&str] =
    &["libc", "libm", "libpthread", "libdl", "librt", "libgcc_s", "ld-linux-x86-64", "ld-linux-aarch64"];

const WINDOWS: &[&str] = &[
    "advapi32.dll",
    "bcrypt.dll",
    "bcryptprimitives.dll",
    "kernel32.dll",
    "msvcrt.dll",
    "ntdll.dll",
    "userenv.dll",
    "ws2_32.dll",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_the_system_are_known() {
        assert!(has(Platform::Linux64, "libc.so.6"));
        assert!(has(Platform::Linux64, "ld-linux-x86-64.so.2"));
        assert!(has(Platform::Win64, "KERNEL32.dll"));
        assert!(has(Platform::Win64, "api-ms-win-core-synch-l1-2-0.dll"));
        assert!(has(Platform::Darwin64, "/usr/lib/libSystem.B.dylib"));
    }

    #[test]
    fn anything_else_is_not() {
        assert!(!has(Platform::Linux64, "libstdc++.so.6"));
        assert!(!has(Platform::Linux64, "libc"));
        assert!(!has(Platform::Linux64, "libcrypto.so.3"));
        assert!(!has(Platform::Win64, "libwinpthread-1.dll"));
        assert!(!has(Platform::Darwin64, "/usr/local/lib/libSystem.B.dylib"));
    }
}
