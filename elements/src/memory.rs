//! Whether there is room for a model, known before it is allocated.

/// Bytes of an element of a line of beams with its nodes, from the model to the factors of its tangent.
const ELEMENT: f64 = 8e3;
/// Bytes of a coordinate that a node follows from: operators, tangents, pattern and factors.
const FOLLOWED: f64 = 300.0;

/// Gigabytes that a model needs, and that there are.
pub(crate) type Short = [f64; 2];

/// Whether there is room for elements of lines.
pub(crate) fn elements(count: f64) -> Result<(), Short> {
    check(ELEMENT * count)
}

/// Whether there is room for nodes that follow from so many coordinates together.
pub(crate) fn followed(coordinates: f64) -> Result<(), Short> {
    check(FOLLOWED * coordinates)
}

fn check(bytes: f64) -> Result<(), Short> {
    // Not worth asking the system.
    const SMALL: f64 = 1e8;
    let free = if bytes > SMALL { free() } else { None };
    match free.filter(|free| bytes > *free) {
        Some(free) => Err([bytes, free].map(|x| x / 1e9)),
        None => Ok(()),
    }
}

/// Bytes that can be had, where the system tells.
fn free() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kilobytes: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024.0 * kilobytes)
}
