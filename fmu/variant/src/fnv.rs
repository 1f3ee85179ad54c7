//! The FNV-1a hash with 128 bits: short, and the same on every platform. The build script uses this file too.

/// A hash in progress.
pub struct Hash(u128);

impl Default for Hash {
    /// The hash of nothing.
    fn default() -> Self {
        Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }
}

impl Hash {
    /// Goes on with some bytes; a carriage return before a line feed does not count, so that checkouts with Windows
    /// line ends have the same hash. Each call is closed by a separator.
    pub fn add(&mut self, bytes: &[u8]) {
        for (index, byte) in bytes.iter().enumerate() {
            if *byte == b'\r' && bytes.get(index + 1) == Some(&b'\n') {
                continue;
            }
            self.byte(u16::from(*byte));
        }
        self.byte(0x100);
    }

    /// The hash as 32 hexadecimal digits.
    pub fn digits(&self) -> String {
        format!("{:032x}", self.0)
    }

    fn byte(&mut self, byte: u16) {
        self.0 = (self.0 ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
    }
}
