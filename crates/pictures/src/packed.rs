//! Arrays of numbers as text: base64 of little-endian bytes, which scripts of a page read as typed
//! arrays.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Single-precision numbers, for a `Float32Array`.
pub fn floats(values: impl IntoIterator<Item = f64>) -> String {
    let bytes = values.into_iter().flat_map(|x| (x as f32).to_le_bytes());
    STANDARD.encode(bytes.collect::<Vec<u8>>())
}

/// Whole numbers, for a `Uint32Array`.
pub fn indices(values: impl IntoIterator<Item = u32>) -> String {
    let bytes = values.into_iter().flat_map(u32::to_le_bytes);
    STANDARD.encode(bytes.collect::<Vec<u8>>())
}

/// Shares from 0 to 1 in steps of 1/65535, for a `Uint16Array`.
pub fn shares(values: impl IntoIterator<Item = f64>) -> String {
    let step = |x: f64| (x.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16;
    let bytes = values.into_iter().flat_map(|x| step(x).to_le_bytes());
    STANDARD.encode(bytes.collect::<Vec<u8>>())
}

/// Largest absolute value of a [`steps`] number; one less than that of a 16-bit number, so that
/// the smallest one is free for "none".
const STEPS: f64 = 32767.0;

/// The largest absolute value divided by [`STEPS`], and the values in this unit, for an
/// `Int16Array`; none is -32768.
pub fn steps(values: &[Option<f64>]) -> (f64, String) {
    let largest = (values.iter().flatten()).fold(0.0_f64, |m, value| m.max(value.abs()));
    let unit = if largest > 0.0 { largest / STEPS } else { 1.0 };
    let step = |value: &Option<f64>| value.map_or(i16::MIN, |value| (value / unit).round() as i16);
    let bytes = values.iter().flat_map(|value| step(value).to_le_bytes());
    (unit, STANDARD.encode(bytes.collect::<Vec<u8>>()))
}

/// The values of [`steps`]; `None` for a text that is not of this kind.
pub fn from_steps(unit: f64, text: &str) -> Option<Vec<Option<f64>>> {
    let bytes = STANDARD.decode(text).ok()?;
    let numbers = bytes
        .chunks_exact(2)
        .map(|pair| i16::from_le_bytes([pair[0], pair[1]]));
    let value = |step: i16| (step > i16::MIN).then(|| unit * f64::from(step));
    (bytes.len() % 2 == 0).then(|| numbers.map(value).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_return_to_a_half_of_a_step_and_gaps_stay_gaps() {
        let values = [Some(0.3), None, Some(-2.0), Some(0.0)];
        let (unit, text) = steps(&values);
        let read = from_steps(unit, &text).unwrap();
        for (value, read) in values.iter().zip(read) {
            match (value, read) {
                (Some(value), Some(read)) => assert!((value - read).abs() <= 0.5 * unit),
                (value, read) => assert_eq!(*value, read),
            }
        }
        assert_eq!(from_steps(1.0, "no base64"), None);
    }
}
