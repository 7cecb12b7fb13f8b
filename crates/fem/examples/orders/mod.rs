//! Errors on refined meshes, or with refined time steps, and the orders that follow from them.

use std::error::Error;

/// Prints the errors for each of `sizes`, each twice the one before, and the orders.
///
/// Returns the orders of the last two sizes: the binary logarithm of the ratio of their errors.
pub fn print_orders<const N: usize>(
    names: [&str; N],
    sizes: &[u32],
    errors: impl Fn(u32) -> Result<[f64; N], Box<dyn Error>>,
) -> Result<[f64; N], Box<dyn Error>> {
    print!(" n");
    for name in names {
        print!("  {name:>11}  order");
    }
    println!();
    let (mut last, mut orders) = ([f64::NAN; N], [f64::NAN; N]);
    for (row, &n) in sizes.iter().enumerate() {
        let next = errors(n)?;
        print!("{n:2}");
        for k in 0..N {
            orders[k] = (last[k] / next[k]).log2();
            match row {
                0 => print!("  {:11.3e}      -", next[k]),
                _ => print!("  {:11.3e}  {:5.2}", next[k], orders[k]),
            }
        }
        println!();
        last = next;
    }
    Ok(orders)
}
