//! Checks whether an image computes the same bits as the host, by hashes of the results.

use anyhow::{Context, Result, ensure};

use super::printed::field;

/// Fails if the hashes that an image printed, such as `hash=show_frames bits=0123456789abcdef`, differ from the
/// host's.
pub(super) fn compare(printed: &str, host: &[(&str, u64)]) -> Result<()> {
    let mut lines = printed.lines().filter(|line| line.starts_with("hash="));
    for (name, bits) in host {
        let line = lines.next().with_context(|| format!("QEMU printed no hash of {name}"))?;
        let of = field(line, "hash")?;
        ensure!(of == *name, "QEMU printed the hash of {of} in place of that of {name}");
        let (here, there) = (format!("{bits:016x}"), field(line, "bits")?);
        ensure!(
            here == there,
            "{name}: QEMU and the host compute other bits, hashes {there} and {here}"
        );
        println!("{name}: QEMU and the host give the same bits, hash {here}.");
    }
    let left = lines.next();
    ensure!(left.is_none(), "QEMU printed a hash that the host does not know: {left:?}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRINTED: &str = "type=Player bodies=20 bytes=1\n\
        hash=bytes bits=00000000000000ff\n\
        hash=frames bits=0123456789abcdef\n";

    const HOST: [(&str, u64); 2] = [("bytes", 0xff), ("frames", 0x0123_4567_89ab_cdef)];

    #[test]
    fn equal_hashes_pass() {
        compare(PRINTED, &HOST).unwrap();
        compare("kernel=rnea bodies=18", &[]).unwrap();
    }

    #[test]
    fn another_bit_or_another_hash_is_refused() {
        let error = compare(&PRINTED.replace("cdef", "cdee"), &HOST).unwrap_err().to_string();
        assert_eq!(
            error,
            "frames: QEMU and the host compute other bits, hashes 0123456789abcdee and 0123456789abcdef"
        );
        assert!(compare(PRINTED, &HOST[..1]).is_err(), "one too many");
        assert!(compare(PRINTED, &[HOST[1], HOST[0]]).is_err(), "in another order");
        assert!(compare("", &HOST).is_err(), "none");
    }
}
