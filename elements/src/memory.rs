//! Estimates of the memory of a model before it is allocated.

/// Bytes per element of a line of beams with its nodes, including the factors of the tangent.
const ELEMENT: f64 = 8e3;
/// Bytes per coordinate that a node depends on: tangents of mapped nodes, pattern and factors.
const FOLLOWED: f64 = 450.0;

/// Gigabytes needed, and gigabytes free.
pub(crate) type Short = [f64; 2];

/// Checks the memory for elements of lines.
pub(crate) fn elements(count: f64) -> Result<(), Short> {
    check(ELEMENT * count)
}

/// Checks the memory for nodes that depend on this number of coordinates in all.
pub(crate) fn followed(coordinates: f64) -> Result<(), Short> {
    check(FOLLOWED * coordinates)
}

fn check(bytes: f64) -> Result<(), Short> {
    // Too small to query the system.
    const SMALL: f64 = 1e8;
    let free = if bytes > SMALL { free() } else { None };
    match free.filter(|free| bytes > *free) {
        Some(free) => Err([bytes, free].map(|x| x / 1e9)),
        None => Ok(()),
    }
}

/// Free bytes, if the system reports them.
fn free() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kilobytes: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024.0 * kilobytes)
}
