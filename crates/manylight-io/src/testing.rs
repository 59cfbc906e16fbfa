//! Deterministic random damage to small files, for robustness tests of parsers.

/// `count` damaged copies of `seed`: bytes are replaced, removed, inserted or repeated, or the file
/// is truncated.
pub(crate) fn mutations(seed: &[u8], count: usize) -> impl Iterator<Item = Vec<u8>> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut below = move |limit: usize| {
        // Xorshift (Marsaglia 2003).
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 33) as usize % limit.max(1)
    };
    (0..count).map(move |_| {
        let mut bytes = seed.to_vec();
        for _ in 0..1 + below(3) {
            let at = below(bytes.len());
            match below(7) {
                _ if bytes.is_empty() => {}
                0 => bytes.truncate(at),
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, below(256) as u8),
                3 => bytes[at] = [0, 0xFF, b' ', b'\n', b'-', b'9', b'/', b'.'][below(8)],
                4 => bytes[at] = bytes[below(bytes.len())],
                5 => bytes[at] ^= 1 << below(8),
                _ => {
                    let part = bytes[at..(at + below(20)).min(bytes.len())].to_vec();
                    bytes.splice(at..at, part);
                }
            }
        }
        bytes
    })
}
