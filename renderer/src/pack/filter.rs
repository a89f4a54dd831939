//! Pixel filters as inverse distribution functions.

use std::sync::LazyLock;

use kinora_kernel::generated::FILTER_CELLS;
use kinora_scene::Filter;

/// Steps of the integral of a filter.
const STEPS: usize = 1 << 16;

// The filter's weight at x in 0..=1 across its width, up to a factor.
fn weight(filter: Filter, x: f64) -> f64 {
    let c = |k: f64| (std::f64::consts::TAU * k * x).cos();
    match filter {
        Filter::Box => 1.0,
        // σ = width / 6.
        Filter::Gaussian => (-0.5 * (6.0 * (x - 0.5)).powi(2)).exp(),
        // Harris 1978, the four-term window of -92 dB.
        Filter::BlackmanHarris => 0.35875 - 0.48829 * c(1.0) + 0.14128 * c(2.0) - 0.01168 * c(3.0),
    }
}

/// Offsets in pixels at which the filter's integral reaches i / FILTER_CELLS, from -width / 2 to width / 2.
pub fn inverse_distribution(filter: Filter, width: f64) -> Vec<f32> {
    // Films ask for them again and again.
    static BOX: LazyLock<Vec<f64>> = LazyLock::new(|| places(Filter::Box));
    static GAUSSIAN: LazyLock<Vec<f64>> = LazyLock::new(|| places(Filter::Gaussian));
    static BLACKMAN_HARRIS: LazyLock<Vec<f64>> = LazyLock::new(|| places(Filter::BlackmanHarris));
    let places = match filter {
        Filter::Box => &BOX,
        Filter::Gaussian => &GAUSSIAN,
        Filter::BlackmanHarris => &BLACKMAN_HARRIS,
    };
    places.iter().map(|x| ((x - 0.5) * width) as f32).collect()
}

// The same across the filter's width, in 0..=1.
fn places(filter: Filter) -> Vec<f64> {
    let mut sums = Vec::with_capacity(STEPS + 1);
    let mut sum = 0.0;
    sums.push(0.0);
    for i in 0..STEPS {
        sum += weight(filter, (i as f64 + 0.5) / STEPS as f64);
        sums.push(sum);
    }
    let mut step = 0;
    (0..=FILTER_CELLS)
        .map(|cell| {
            let target = sum * f64::from(cell) / f64::from(FILTER_CELLS);
            while step < STEPS && sums[step + 1] < target {
                step += 1;
            }
            if step >= STEPS {
                return 1.0;
            }
            let inside = (target - sums[step]) / (sums[step + 1] - sums[step]);
            (step as f64 + inside) / STEPS as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_the_filters_moments() {
        // Variance in units of width²: box 1/12; the others by quadrature in f64 with 10⁶ steps.
        for (filter, variance) in
            [(Filter::Box, 1.0 / 12.0), (Filter::Gaussian, 0.027_04), (Filter::BlackmanHarris, 0.019_18)]
        {
            let table = inverse_distribution(filter, 2.0);
            assert_eq!(table.len(), FILTER_CELLS as usize + 1);
            assert_eq!((table[0], table[FILTER_CELLS as usize]), (-1.0, 1.0));
            assert!(table.windows(2).all(|w| w[0] < w[1]), "{filter:?} does not grow");
            assert!(table[FILTER_CELLS as usize / 2].abs() < 1e-4, "{filter:?} is not centred");
            let second: f64 =
                table.windows(2).map(|w| f64::from(w[0] * w[0] + w[0] * w[1] + w[1] * w[1]) / 3.0).sum::<f64>()
                    / f64::from(FILTER_CELLS);
            assert!((second / 4.0 - variance).abs() < 5e-4, "{filter:?}: variance {}", second / 4.0);
        }
    }
}
