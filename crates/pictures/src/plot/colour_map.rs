//! The colour map of speeds.

/// The map viridis of matplotlib (van der Walt & Smith 2015) at equal steps: its lightness
/// increases evenly, so that colour-blind readers and grey prints keep the order.
const VIRIDIS: [[u8; 3]; 16] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x1a, 0x6c],
    [0x47, 0x2f, 0x7d],
    [0x41, 0x44, 0x87],
    [0x39, 0x56, 0x8c],
    [0x31, 0x68, 0x8e],
    [0x2a, 0x78, 0x8e],
    [0x23, 0x88, 0x8e],
    [0x1f, 0x98, 0x8b],
    [0x22, 0xa8, 0x84],
    [0x35, 0xb7, 0x79],
    [0x54, 0xc5, 0x68],
    [0x7a, 0xd1, 0x51],
    [0xa5, 0xdb, 0x36],
    [0xd2, 0xe2, 0x1b],
    [0xfd, 0xe7, 0x25],
];

/// Red, green and blue for a value from 0 to 1; other values have the colour of the nearer end.
pub fn colour(value: f64) -> [u8; 3] {
    let last = VIRIDIS.len() - 1;
    let place = value.clamp(0.0, 1.0) * last as f64;
    let below = (place as usize).min(last - 1);
    let share = place - below as f64;
    std::array::from_fn(|k| {
        let [a, b] = [below, below + 1].map(|step| f64::from(VIRIDIS[step][k]));
        (a + share * (b - a)).round() as u8
    })
}
